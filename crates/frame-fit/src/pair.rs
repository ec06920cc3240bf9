//! One point measured in two frames, and how well.

use nalgebra::{Cholesky, DMatrix, Dyn, Point, SMatrix, SVector};

/// One point measured in both frames: `D` = 2 planar, 3 spatial.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PointPair<const D: usize> {
    /// Position in the target frame.
    pub target_mm: Point<f64, D>,
    /// Position in the source frame.
    pub source_mm: Point<f64, D>,
    /// Uncertainty of `target − T·source`, along the axes of the target frame.
    pub uncertainty: Uncertainty<D>,
}

/// Standard uncertainty of the difference between a point and its transformed partner.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Uncertainty<const D: usize> {
    /// The same along every axis.
    Isotropic {
        /// Standard uncertainty of each coordinate.
        sigma_mm: f64,
    },
    /// One per axis, uncorrelated.
    PerAxis {
        /// Standard uncertainty of x, y and z.
        sigma_mm: SVector<f64, D>,
    },
    /// Any symmetric positive definite covariance.
    Full {
        /// Covariance of the coordinates.
        covariance_mm2: SMatrix<f64, D, D>,
    },
}

impl<const D: usize> PointPair<D> {
    /// A pair with the same standard uncertainty along every axis.
    pub fn isotropic(
        source_mm: impl Into<Point<f64, D>>,
        target_mm: impl Into<Point<f64, D>>,
        sigma_mm: f64,
    ) -> Self {
        Self {
            target_mm: target_mm.into(),
            source_mm: source_mm.into(),
            uncertainty: Uncertainty::Isotropic { sigma_mm },
        }
    }
}

impl<const D: usize> Uncertainty<D> {
    /// Covariance of the coordinates.
    #[must_use]
    pub fn covariance_mm2(&self) -> SMatrix<f64, D, D> {
        match self {
            Self::Isotropic { sigma_mm } => SMatrix::identity() * sigma_mm.powi(2),
            Self::PerAxis { sigma_mm } => {
                SMatrix::from_fn(
                    |row, column| {
                        if row == column { sigma_mm[row].powi(2) } else { 0.0 }
                    },
                )
            }
            Self::Full { covariance_mm2 } => *covariance_mm2,
        }
    }

    /// Standard uncertainty of each coordinate, correlation left aside.
    #[must_use]
    pub fn sigma_mm(&self) -> SVector<f64, D> {
        match self {
            Self::Isotropic { sigma_mm } => SVector::repeat(*sigma_mm),
            Self::PerAxis { sigma_mm } => *sigma_mm,
            Self::Full { covariance_mm2 } => covariance_mm2.map_diagonal(f64::sqrt),
        }
    }

    /// `W` with `WᵀW` the inverse covariance; `None` where there is none.
    pub(crate) fn whitening_per_mm(&self) -> Option<SMatrix<f64, D, D>> {
        let sigma = self.sigma_mm();
        let Self::Full { covariance_mm2 } = self else {
            return Some(SMatrix::from_fn(
                |row, column| {
                    if row == column { sigma[row].recip() } else { 0.0 }
                },
            ));
        };
        // Correlations first: sigmas of very different size must not decide the rank.
        let correlation = DMatrix::from_fn(D, D, |row, column| {
            let mean = f64::midpoint(covariance_mm2[(row, column)], covariance_mm2[(column, row)]);
            mean / (sigma[row] * sigma[column])
        });
        let lower = Cholesky::<f64, Dyn>::new(correlation)?.unpack();
        let inverse = lower.solve_lower_triangular(&DMatrix::identity(D, D))?;
        Some(SMatrix::from_fn(|row, column| inverse[(row, column)] / sigma[column]))
    }

    /// One weight for the whole point, from the mean variance of its coordinates.
    pub(crate) fn mean_weight_per_mm2(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "D is 2 or 3")]
        let dimension = D as f64;
        dimension / self.sigma_mm().norm_squared()
    }

    pub(crate) fn is_isotropic(&self) -> bool {
        matches!(self, Self::Isotropic { .. })
    }
}
