//! How much groups scatter along amplitudes.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::algebra::basis::Basis;

/// Sum over the groups of the squared residual along the columns of an orthonormal basis, `Σ|A_gᵀe_g|²`: how well
/// amplitudes are known where readings scatter the more, the more they have of an effect.
pub(crate) struct ScatterAlong {
    /// As it is, over the variance of a reading.
    observed: f64,
    /// Its expectation where every reading scatters alike.
    expected: f64,
    /// Degrees of freedom of that quadratic form (Satterthwaite 1946).
    pub(crate) dof: f64,
}

impl ScatterAlong {
    /// Along `added`, the last columns of `full`, which leaves `residual` of readings of this variance.
    pub(crate) fn of(
        clusters: &[Vec<usize>],
        (added, full): (&Basis, &Basis),
        residual: &DVector<f64>,
        variance: f64,
    ) -> Self {
        let (mut observed, mut expected, mut squares) = (0.0, 0.0, 0.0);
        let mut crossed = DMatrix::zeros(full.dim(), full.dim());
        for cluster in clusters {
            let along = added.rows(cluster);
            let taken = full.rows(cluster).tr_mul(&along);
            observed += along.tr_mul(&residual.select_rows(cluster)).norm_squared();
            let own = taken.tr_mul(&taken);
            let kept = along.tr_mul(&along) - &own;
            expected += kept.trace();
            // Between two groups the model leaves −H_gH_hᵀ.
            squares += kept.norm_squared() - own.norm_squared();
            crossed.gemm(1.0, &taken, &taken.transpose(), 1.0);
        }
        squares += crossed.norm_squared();
        Self { observed: observed / variance, expected, dof: expected * expected / squares }
    }

    /// By how much the variance of an amplitude is larger than if all readings scattered alike.
    pub(crate) fn factor(&self) -> f64 {
        (self.observed / self.expected).max(1.0)
    }

    /// Chance of as much where they do.
    pub(crate) fn p_value(&self) -> f64 {
        let law = ChiSquared::new(self.dof);
        law.map_or(1.0, |law| law.sf(self.dof * self.factor()))
    }
}
