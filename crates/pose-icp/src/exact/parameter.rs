use geometry::EulerAngles;
use nalgebra::{Isometry3, Translation3, Vector3};

/// One parameter of a pose `p_machine = Rz(γ) Ry(β) Rx(α) p + d`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum PoseParameter {
    /// First coordinate of the workpiece's origin in the machine frame, mm.
    X,
    /// Second coordinate, mm.
    Y,
    /// Third coordinate, mm.
    Z,
    /// Tilt about x, rad.
    Alpha,
    /// Tilt about y, rad.
    Beta,
    /// Rotation about z, rad.
    Gamma,
}

impl PoseParameter {
    /// All six, in the order of every covariance of a pose.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Alpha, Self::Beta, Self::Gamma];

    /// Short name: `x`, `y`, `z`, `alpha`, `beta`, `gamma`.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["x", "y", "z", "alpha", "beta", "gamma"][self as usize]
    }

    /// What it is, for people.
    #[must_use]
    pub fn words(self) -> &'static str {
        [
            "the position along x",
            "the position along y",
            "the height",
            "the tilt about x",
            "the tilt about y",
            "the rotation about z",
        ][self as usize]
    }

    /// Whether it is an angle, in rad.
    #[must_use]
    pub fn is_angle(self) -> bool {
        self >= Self::Alpha
    }
}

/// The six numbers of a pose, `p_machine = Rz(γ) Ry(β) Rx(α) p + d`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PoseStart {
    /// The workpiece's origin in the machine frame.
    pub position_mm: Vector3<f64>,
    /// Orientation of the workpiece.
    pub angles: EulerAngles,
}

impl PoseStart {
    /// The workpiece's origin at `position_mm`, its axes turned by γ alone.
    #[must_use]
    pub fn level(position_mm: Vector3<f64>, gamma_rad: f64) -> Self {
        Self { position_mm, angles: EulerAngles { gamma_rad, ..EulerAngles::default() } }
    }

    /// The pose as a rigid transform.
    #[must_use]
    pub fn machine_from_workpiece(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.position_mm), self.angles.to_rotation())
    }
}
