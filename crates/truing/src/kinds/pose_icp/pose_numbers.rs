use geometry::EulerAngles;
use nalgebra::{Isometry3, Vector3};
use pose_icp::PoseStart;
use serde::Serialize;

/// A pose as six numbers: workpiece to machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseNumbers {
    /// Position of the workpiece's origin.
    pub x_mm: f64,
    /// Position of the workpiece's origin.
    pub y_mm: f64,
    /// Position of the workpiece's origin.
    pub z_mm: f64,
    /// Tilt about x.
    pub alpha_deg: f64,
    /// Tilt about y.
    pub beta_deg: f64,
    /// Rotation about z.
    pub gamma_deg: f64,
}

impl PoseNumbers {
    /// The pose as a rigid transform.
    #[must_use]
    pub fn machine_from_workpiece(&self) -> Isometry3<f64> {
        let position_mm = Vector3::new(self.x_mm, self.y_mm, self.z_mm);
        let angles = EulerAngles {
            alpha_rad: self.alpha_deg.to_radians(),
            beta_rad: self.beta_deg.to_radians(),
            gamma_rad: self.gamma_deg.to_radians(),
        };
        PoseStart { position_mm, angles }.machine_from_workpiece()
    }
}

impl From<&PoseStart> for PoseNumbers {
    fn from(PoseStart { position_mm, angles }: &PoseStart) -> Self {
        Self {
            x_mm: position_mm.x,
            y_mm: position_mm.y,
            z_mm: position_mm.z,
            alpha_deg: angles.alpha_rad.to_degrees(),
            beta_deg: angles.beta_rad.to_degrees(),
            gamma_deg: angles.gamma_rad.to_degrees(),
        }
    }
}
