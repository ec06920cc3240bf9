use nalgebra::{Matrix2, Point2};

use crate::{PoseParameter, Tip};

/// What is known beside the touches.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseOptions {
    /// The ball.
    pub tip: Tip,
    /// Parameters that keep the value they start from.
    ///
    /// γ by default: a surface of revolution does not show it.
    pub held: Vec<PoseParameter>,
    /// Those of the held ones that are known from elsewhere, from fiducials for instance.
    ///
    /// The loop asks of the others whether what is held is wrong, but not of these.
    pub known: Vec<PoseParameter>,
    /// Whether the machine reads along axes of its own, which may read long or be out of square;
    /// a laser tracker has none.
    pub machine_axes: bool,
    /// Where the part's axis is, from touches of its side.
    pub lateral: Option<LateralPrior>,
    /// What the uncertainties of the touches mean.
    pub noise: Noise,
}

impl Default for PoseOptions {
    fn default() -> Self {
        Self {
            tip: Tip::default(),
            held: vec![PoseParameter::Gamma],
            known: Vec::new(),
            machine_axes: true,
            lateral: None,
            noise: Noise::Declared,
        }
    }
}

/// Where the workpiece's z axis passes a horizontal plane of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LateralPrior {
    /// Machine z of the plane: the mean height of the side touches.
    pub at_z_mm: f64,
    /// Machine x and y of the axis in that plane.
    pub center_mm: Point2<f64>,
    /// Covariance of `center_mm`, mm².
    pub covariance_mm2: Matrix2<f64>,
}

/// What the uncertainties of the touches mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Noise {
    /// They are known: the uncertainty of the pose is a priori.
    #[default]
    Declared,
    /// They only weigh touches against each other: the uncertainty of the pose is scaled by what
    /// the residual shows.
    Estimated,
}
