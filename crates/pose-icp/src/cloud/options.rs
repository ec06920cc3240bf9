use least_squares::Loss;
use nalgebra::{Isometry3, Point3};

use super::error::{OptionName, RegisterError};

/// What is made small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Objective {
    /// Distance from the tangent plane of the nearest target point, `n·(T p − q)` (Chen and
    /// Medioni 1991): slides along the surface freely, so that few iterations do.
    #[default]
    PointToPlane,
    /// Distance from the nearest target point, `T p − q` (Besl 1992): needs no normals,
    /// and hundreds of iterations where a surface slides along itself.
    PointToPoint,
    /// `(R nₚ + n_q)·(T p − q) / |R nₚ + n_q|` (Rusinkiewicz 2019): exact on arcs, for which it
    /// needs normals on both sides.
    Symmetric,
}

/// What may happen to one component of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Freedom {
    /// The data decide.
    #[default]
    Free,
    /// Stays as it is at the start.
    Held,
    /// Stays as it is at the start to within a standard uncertainty.
    Prior {
        /// Standard uncertainty, in mm for a translation, in rad for a rotation.
        sigma: f64,
    },
}

/// How to register.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RegisterOptions {
    /// What is made small; point-to-plane.
    pub objective: Objective,
    /// Where the source lies at the start, target from source; the identity.
    pub start: Isometry3<f64>,
    /// What may happen to `[tx, ty, tz, rx, ry, rz]`, the shift of `pivot_mm` from where it is at the
    /// start and the rotation vector about it, along the target's axes; all free.
    pub freedoms: [Freedom; 6],
    /// Point of the target frame that rotations turn about; the middle of the source at the start.
    pub pivot_mm: Option<Point3<f64>>,
    /// Standard uncertainty of one residual; where it is `None` it is estimated from them.
    ///
    /// It scales the loss, the priors and the covariance.
    pub sigma_mm: Option<f64>,
    /// Robust loss of residuals over their standard uncertainty; none, that is, squares.
    pub loss: Option<Loss>,
    /// Share of the matches to keep, those of the least residual (Chetverikov 2002); 1.
    pub keep_share: f64,
    /// Points further than this from the target take no part; no limit.
    pub max_distance_mm: Option<f64>,
    /// Leaves out points that lie beside the target rather than over it; yes.
    ///
    /// A point lies beside the target if the tangent plane of the nearest target point is left
    /// sideways by more than the points there lie apart. Needs normals.
    pub skip_beyond_border: bool,
    /// Ends when a pass moves no point of the source further than this, or is foretold to move none by a
    /// tenth of it; 1e-6 mm.
    ///
    /// This is the one test, of a length: no angle is compared with a translation.
    pub tolerance_mm: f64,
    /// Passes over the points at each level of detail, at most; 100.
    pub max_iterations: usize,
}

impl Default for RegisterOptions {
    fn default() -> Self {
        Self {
            objective: Objective::default(),
            start: Isometry3::identity(),
            freedoms: [Freedom::Free; 6],
            pivot_mm: None,
            sigma_mm: None,
            loss: None,
            keep_share: 1.0,
            max_distance_mm: None,
            skip_beyond_border: true,
            tolerance_mm: 1e-6,
            max_iterations: 100,
        }
    }
}

impl RegisterOptions {
    pub(crate) fn check(&self) -> Result<(), RegisterError> {
        let positive = |option, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(RegisterError::InvalidOption { option, value })
            }
        };
        positive(OptionName::Tolerance, self.tolerance_mm)?;
        if let Some(sigma_mm) = self.sigma_mm {
            positive(OptionName::Sigma, sigma_mm)?;
        }
        if let Some(max_distance_mm) = self.max_distance_mm {
            positive(OptionName::MaxDistance, max_distance_mm)?;
        }
        for freedom in self.freedoms {
            if let Freedom::Prior { sigma } = freedom {
                positive(OptionName::PriorSigma, sigma)?;
            }
        }
        if !(self.keep_share > 0.0 && self.keep_share <= 1.0) {
            return Err(RegisterError::InvalidOption {
                option: OptionName::Keep,
                value: self.keep_share,
            });
        }
        if let Some(
            Loss::Huber { scale }
            | Loss::Cauchy { scale }
            | Loss::Tukey { scale }
            | Loss::GemanMcClure { scale },
        ) = self.loss
        {
            positive(OptionName::LossScale, scale)?;
        }
        let pose = self.start.translation.vector.iter().chain(self.start.rotation.coords.iter());
        let pivot = self.pivot_mm.iter().flat_map(|p| p.iter());
        match pose.chain(pivot).find(|v| !v.is_finite()) {
            Some(&value) => Err(RegisterError::InvalidOption { option: OptionName::Start, value }),
            None => Ok(()),
        }
    }
}
