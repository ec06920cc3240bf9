//! The frame as a map of the positions that the machine says.

use nalgebra::{Matrix2x3, Matrix4, Point2, Vector2};

use crate::SensorFrame;

/// `sensor = scale · Rot(θ) · Mirror · machine + translation`, machine as it says that it is.
///
/// The angle is that of the [`SensorFrame`]. A scale of the machine and a datum between the origins
/// are in it; what moves the head by load, time or temperature is not.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CommandedFrame {
    /// How far the machine really moves over how far it says: 1 unless found otherwise.
    pub scale: f64,
    /// Standard uncertainty of it; zero where it is not estimated.
    pub std_scale: f64,
    /// The machine's origin in the sensor frame.
    pub translation_mm: Vector2<f64>,
    /// Standard uncertainty of it.
    pub std_translation_mm: Vector2<f64>,
    /// Image of the frame's pivot in the sensor frame.
    pub image_mm: Point2<f64>,
    /// Covariance of angle (rad), `image_mm` and scale.
    pub covariance: Matrix4<f64>,
}

impl CommandedFrame {
    /// Of a frame to which no effect belongs.
    pub(crate) fn declared(frame: &SensorFrame) -> Self {
        let arm = -(frame.sensor_from_machine().linear * frame.pivot_mm.coords);
        // A small angle moves the end of an arm by its perpendicular.
        let jacobian = Matrix2x3::new(-arm.y, 1.0, 0.0, arm.x, 0.0, 1.0);
        let covariance = jacobian * frame.covariance * jacobian.transpose();
        let mut about_pivot = Matrix4::zeros();
        about_pivot.fixed_view_mut::<3, 3>(0, 0).copy_from(&frame.covariance);
        Self {
            scale: 1.0,
            std_scale: 0.0,
            translation_mm: frame.translation_mm,
            std_translation_mm: covariance.diagonal().map(f64::sqrt),
            image_mm: frame.sensor_from_machine().apply(&frame.pivot_mm),
            covariance: about_pivot,
        }
    }
}
