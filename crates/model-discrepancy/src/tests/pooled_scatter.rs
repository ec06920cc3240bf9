//! Scatter between groups as one number, where noise is all that is left.

use crate::algebra::basis::Basis;
use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::tests::global_test::chi2_interval;
use crate::tests::scatter_along::ScatterAlong;

/// F test of the amplitudes in the orthonormal basis `added`, the last columns of `full`, on the scatter
/// that groups have along them; `None` where more than the declared noise is left, or where no noise was
/// declared and there are no more groups than a mean and the amplitudes.
///
/// The cluster-robust covariance grants each group a covariance of its own: it cannot judge as many
/// amplitudes as a handful of groups show, however large they are. Where the residual beside them is
/// what was declared, groups differ by noise alone or by little more: how much more is one factor,
/// `Σ|A_gᵀe_g|²` over its expectation, with the degrees of freedom of that quadratic form
/// (Satterthwaite 1946).
///
/// Noise that was not declared is what the readings scatter by beside the amplitudes. Nothing then says
/// that groups differ by no more than noise: what a group has of its own may move all amplitudes
/// together, so that there are no more degrees of freedom than groups beyond a mean and the amplitudes.
pub(crate) fn pooled_scatter(lin: &Linear<'_>, added: &Basis, full: &Basis) -> Option<f64> {
    let residual = full.reject(&lin.residual);
    let dof = count(residual.len().saturating_sub(full.dim()));
    if dof < 1.0 {
        return None;
    }
    let (m, left) = (added.dim(), residual.norm_squared() / dof);
    let (variance, most_dof) = if lin.layout.sigma_declared {
        let [_, most] = chi2_interval(dof);
        (left <= most).then_some((1.0, f64::INFINITY))?
    } else {
        let beyond = lin.clusters.len().checked_sub(m + 1).filter(|&groups| groups > 0)?;
        (left > 0.0).then_some((left, count(beyond)))?
    };
    let scatter = ScatterAlong::of(&lin.clusters, (added, full), &residual, variance);
    let amplitude = added.matrix().tr_mul(&lin.residual);
    let f_statistic = amplitude.norm_squared() / (count(m) * variance * scatter.factor());
    Some(f_tail(f_statistic, count(m), scatter.dof.min(most_dof)))
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::Layout;
    use crate::algebra::basis::NEW_DIRECTION;
    use crate::algebra::linearised::Linearised;

    /// Series of groups without an effect, each of whose readings share some scatter: of tests at
    /// 0.05 no more than this many of 400 may refuse, the binomial bound once in a thousand being 36.
    const MOST_REFUSED: usize = 36;
    const SETS: usize = 400;
    const EACH: usize = 8;

    /// How many of the tests of `m` amplitudes at 0.05 refuse, in `groups` groups that share so much of
    /// the scatter of a reading.
    fn refused(groups: usize, m: usize, of_group: f64, sigma_declared: bool) -> usize {
        let n = groups * EACH;
        let layout = Layout { sigma_declared, ..Layout::default() };
        let clusters: Vec<Vec<usize>> =
            (0..groups).map(|g| (EACH * g..EACH * (g + 1)).collect()).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut refused = 0;
        for _ in 0..SETS {
            let columns = DMatrix::from_fn(n, 3, |_, _| normal());
            // The effect is the same at all readings of a group: the hardest case for scatter of groups.
            let of_groups: Vec<f64> = (0..groups * m).map(|_| normal()).collect();
            let tested = DMatrix::from_fn(n, m, |i, j| of_groups[(i / EACH) * m + j]);
            let base = Basis::of(&columns, NEW_DIRECTION);
            let shared: Vec<f64> = (0..groups).map(|_| of_group * normal()).collect();
            let residual = DVector::from_fn(n, |i, _| shared[i / EACH] + normal());
            let lin = Linear::from(Linearised::of_parts(&layout, residual, base, clusters.clone()));
            let added = Basis::of(&lin.basis.reject_columns(&tested), NEW_DIRECTION);
            let full = lin.basis.with(&added.matrix(), NEW_DIRECTION);
            refused += usize::from(pooled_scatter(&lin, &added, &full).is_some_and(|p| p < 0.05));
        }
        refused
    }

    #[test]
    fn it_keeps_its_level_where_groups_scatter_a_little_more_than_declared() {
        let refused = refused(16, 4, 0.2, true);
        assert!(refused <= MOST_REFUSED, "{refused}");
    }

    #[test]
    fn it_keeps_its_level_where_nothing_is_declared() {
        for of_group in [0.2, 1.0] {
            for (groups, m) in [(6, 1), (7, 3), (12, 3)] {
                let refused = refused(groups, m, of_group, false);
                assert!(refused <= MOST_REFUSED, "{refused} of {groups} groups, {m}, {of_group}");
            }
        }
    }

    #[test]
    fn more_amplitudes_than_groups_are_not_pooled_where_nothing_is_declared() {
        assert_eq!(refused(3, 4, 0.0, false), 0);
    }
}
