use ft_center::{FramePoint, PressRole, SolvedPress, fit_affine_frame};
use nalgebra::Matrix2;
use serde::Serialize;

use crate::text_table::{Cell, EXPANDED, TextTable};

/// The general map `T = S P⁻¹` of (1.14) in \[A\], machine to sensor: what the rigid frame leaves out.
///
/// Its six unknowns fit three presses without residual whatever their errors, so it is told and not
/// used: scale and shear beyond their uncertainty say that something else is wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AffineEstimate {
    /// Rows of `[x y] = matrix · [X Y 1]`: sensor from machine, lengths in mm.
    pub matrix: [[f64; 3]; 2],
    /// Singular values of its linear part, the larger first; both 1 for a rigid map.
    pub scale_ratios: [f64; 2],
    /// Deviation from a right angle between the images of the machine's axes, positive when the
    /// angle is larger.
    pub shear_rad: f64,
    /// Standard uncertainty of each entry of the linear part, from the records and the scatter of the
    /// presses.
    pub std_ratios: [[f64; 2]; 2],
    /// Root mean square of what it leaves of the presses.
    pub residual_rms_mm: f64,
    /// Twice the presses less six.
    pub degrees_of_freedom: usize,
}

impl AffineEstimate {
    /// Of presses at known positions, which scatter by `seat_mm` along each axis; `None` of fewer than
    /// three off one line.
    pub(super) fn of(presses: &[SolvedPress], seat_mm: f64) -> Option<Self> {
        let point = |press: &SolvedPress| FramePoint {
            machine_mm: press.machine_mm,
            sensor_mm: press.orbit.center_mm,
            covariance_mm2: press.orbit.covariance_mm2 + Matrix2::identity() * seat_mm.powi(2),
        };
        let known = presses.iter().filter(|press| press.role == PressRole::Frame);
        let found = fit_affine_frame(&known.map(point).collect::<Vec<_>>()).ok()?;
        let (linear, moved) =
            (found.sensor_from_machine.linear, found.sensor_from_machine.translation_mm);
        let row = |i: usize| [linear[(i, 0)], linear[(i, 1)], moved[i]];
        let std = |i: usize| [found.linear_std_ratio[(i, 0)], found.linear_std_ratio[(i, 1)]];
        let squares: f64 = found.residuals_mm.iter().map(nalgebra::Vector2::norm_squared).sum();
        Some(Self {
            matrix: [row(0), row(1)],
            scale_ratios: found.scale_ratios,
            shear_rad: found.shear_rad,
            std_ratios: [std(0), std(1)],
            residual_rms_mm: (squares / crate::count::count(found.residuals_mm.len())).sqrt(),
            degrees_of_freedom: found.degrees_of_freedom,
        })
    }

    pub(super) fn table(&self) -> TextTable {
        let title = "the presses by a general map (1.14), beside the rigid frame";
        let columns = ["", "value", EXPANDED, "unit"];
        let mut table = TextTable::of_quantities(title, &columns);
        // The singular values are the lengths of turned columns: as uncertain as the least known.
        let std = self.std_ratios.iter().flatten().copied().fold(0.0, f64::max);
        let [major, minor] = self.scale_ratios;
        for (name, value, std, unit) in [
            ("larger scale − 1", 1e6 * (major - 1.0), 1e6 * std, "ppm"),
            ("smaller scale − 1", 1e6 * (minor - 1.0), 1e6 * std, "ppm"),
            ("shear", 1e6 * self.shear_rad, 1e6 * 2.0_f64.sqrt() * std, "µrad"),
        ] {
            let known = Cell::Known(value, Some(std));
            table.push(vec![name.into(), known, Cell::Expanded(Some(std)), unit.into()]);
        }
        table
    }
}
