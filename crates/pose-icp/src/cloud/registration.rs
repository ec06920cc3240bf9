use nalgebra::{Isometry3, Matrix6, Point3};

use super::observability::Observability;

/// Where the source lies, and how well that is known.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Registration {
    /// Maps source coordinates to target coordinates.
    pub target_from_source: Isometry3<f64>,
    /// Covariance of a left perturbation `[tx, ty, tz, rx, ry, rz]` about `pivot_mm`; mm²,
    /// mm·rad, rad².
    ///
    /// For rows of standard uncertainty `sigma_mm` that are independent of one another, but for those
    /// that share an average over the target's points. Nothing is added for what is held.
    pub covariance: Matrix6<f64>,
    /// Point of the target frame that rotations turn about.
    pub pivot_mm: Point3<f64>,
    /// Standard uncertainty of one residual: the one declared, or estimated from the residuals.
    pub sigma_mm: f64,
    /// Root-mean-square residual of the points used.
    pub rms_mm: f64,
    /// Points of the source that took part in the end.
    pub used: usize,
    /// Passes over the points, at all levels of detail.
    pub iterations: usize,
    /// Passes over all points.
    pub full_iterations: usize,
    /// Furthest that the last pass moved a point.
    pub last_motion_mm: f64,
    /// Why the passes ended; `None` where they ran out.
    pub termination: Option<Termination>,
    /// What the shape determines; `None` where neither side has normals.
    pub observability: Option<Observability>,
}

/// Ways to succeed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Termination {
    /// A pass moved no point by more than the tolerance, or the next one is foretold to move none by a
    /// tenth of it.
    Motion,
    /// Points between two target points change their minds for ever, and move the pose by no more
    /// than a tenth of its own standard uncertainty.
    Settled,
}
