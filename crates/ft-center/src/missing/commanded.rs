//! The frame as a map of the positions that the machine says, with what the loop found.

use model_discrepancy::{Closure, Column};
use nalgebra::{DMatrix, Matrix4, Point2, Vector2};

use crate::missing::press_effects::PressEffect;
use crate::{CommandedFrame, SensorFrame};

impl CommandedFrame {
    /// Of the frame that the loop leaves; `scale` and `datum_mm` are what the machine's effects say.
    pub(crate) fn of(
        frame: &SensorFrame,
        closure: &Closure,
        effects: &[PressEffect],
        scale: f64,
        datum_mm: Vector2<f64>,
    ) -> Self {
        let linear = frame.sensor_from_machine().linear;
        let pivot_mm = frame.pivot_mm.coords;
        // From the pivot, whose image the base parameters are, to the origin.
        let arm = linear * (datum_mm - pivot_mm * (1.0 + scale));
        // From the pivot, whose image the base parameters are, to where it is with the datum.
        let shifted = linear * datum_mm;
        // scale; angle, image of the pivot.
        let mut jacobian = DMatrix::zeros(6, closure.columns.len());
        for (k, column) in closure.columns.iter().enumerate() {
            let moved = match *column {
                Column::Base(0) => Vector2::new(-arm.y, arm.x),
                Column::Base(axis) => Vector2::ith(axis - 1, 1.0),
                Column::Amplitude { effect, parameter } => match effects[effect] {
                    PressEffect::FrameScale => -(linear * pivot_mm),
                    PressEffect::DatumOffset => linear.column(parameter).into_owned(),
                    _ => Vector2::zeros(),
                },
                Column::Empirical { .. } | Column::Place { .. } => Vector2::zeros(),
            };
            jacobian.fixed_view_mut::<2, 1>(0, k).copy_from(&moved);
            let image = match *column {
                Column::Base(0) => Vector2::new(-shifted.y, shifted.x),
                Column::Amplitude { effect, .. } if effects[effect] == PressEffect::FrameScale => {
                    Vector2::zeros()
                }
                _ => moved,
            };
            jacobian[(3, k)] = f64::from(u8::from(matches!(*column, Column::Base(0))));
            jacobian.fixed_view_mut::<2, 1>(4, k).copy_from(&image);
            let is_scale = matches!(*column, Column::Amplitude { effect, .. }
                if effects[effect] == PressEffect::FrameScale);
            jacobian[(2, k)] = f64::from(u8::from(is_scale));
        }
        let covariance = &jacobian * &closure.covariance * jacobian.transpose();
        let std = covariance.diagonal().map(|v| v.max(0.0).sqrt());
        let order = [3, 4, 5, 2];
        Self {
            scale: 1.0 + scale,
            std_scale: std[2],
            translation_mm: frame.translation_mm + linear * (datum_mm - pivot_mm * scale),
            std_translation_mm: Vector2::new(std[0], std[1]),
            image_mm: Point2::from(frame.translation_mm + linear * (pivot_mm + datum_mm)),
            covariance: Matrix4::from_fn(|i, j| covariance[(order[i], order[j])]),
        }
    }
}
