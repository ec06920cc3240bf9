//! Scatter between groups as one number, where the noise is declared and reached.

use nalgebra::DMatrix;

use crate::algebra::basis::Basis;
use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::tests::global_test::chi2_interval;

/// F test of the amplitudes in the orthonormal basis `added`, the last columns of `full`, on the scatter
/// that groups have along them; `None` where no noise was declared, or more than it is left.
///
/// The cluster-robust covariance grants each group a covariance of its own: it cannot judge as many
/// amplitudes as a handful of groups show, however large they are. Where the residual beside them is
/// what was declared, groups differ by noise alone or by little more: how much more is one factor,
/// `Σ|A_gᵀe_g|²` over its expectation, with the degrees of freedom of that quadratic form
/// (Satterthwaite 1946).
pub(crate) fn pooled_scatter(lin: &Linear<'_>, added: &Basis, full: &Basis) -> Option<f64> {
    let residual = full.reject(&lin.residual);
    let dof = count(residual.len().saturating_sub(full.dim()));
    if !lin.layout.sigma_declared || dof < 1.0 {
        return None;
    }
    let [_, most] = chi2_interval(dof);
    if residual.norm_squared() / dof > most {
        return None;
    }
    let m = added.dim();
    let (mut observed, mut expected, mut squares) = (0.0, 0.0, 0.0);
    let mut crossed = DMatrix::zeros(full.dim(), full.dim());
    for cluster in &lin.clusters {
        let along = added.rows(cluster);
        let taken = full.rows(cluster).tr_mul(&along);
        observed += along.tr_mul(&residual.select_rows(cluster)).norm_squared();
        let own = taken.tr_mul(&taken);
        let left = along.tr_mul(&along) - &own;
        expected += left.trace();
        // Between two groups the model leaves −H_gH_hᵀ.
        squares += left.norm_squared() - own.norm_squared();
        crossed.gemm(1.0, &taken, &taken.transpose(), 1.0);
    }
    squares += crossed.norm_squared();
    let factor = (observed / expected).max(1.0);
    let amplitude = added.matrix().tr_mul(&lin.residual);
    let f_statistic = amplitude.norm_squared() / (count(m) * factor);
    Some(f_tail(f_statistic, count(m), expected * expected / squares))
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::Layout;
    use crate::algebra::basis::NEW_DIRECTION;
    use crate::algebra::linearised::Linearised;

    /// Series of groups without an effect, each of whose readings share a little scatter: of tests at
    /// 0.05 no more than this many of 400 may refuse, the binomial bound once in a thousand being 36.
    const MOST_REFUSED: usize = 36;

    #[test]
    fn it_keeps_its_level_where_groups_scatter_a_little_more_than_declared() {
        let (groups, each, m) = (16, 8, 4);
        let n = groups * each;
        let layout = Layout { sigma_declared: true, ..Layout::default() };
        let clusters: Vec<Vec<usize>> =
            (0..groups).map(|g| (each * g..each * (g + 1)).collect()).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut refused = 0;
        for _ in 0..400 {
            let columns = DMatrix::from_fn(n, 3 + m, |_, _| normal());
            // The effect is the same at all readings of a group: the hardest case for scatter of groups.
            let of_groups: Vec<f64> = (0..groups * m).map(|_| normal()).collect();
            let tested = DMatrix::from_fn(n, m, |i, j| of_groups[(i / each) * m + j]);
            let base = Basis::of(&columns.columns(0, 3).into_owned(), NEW_DIRECTION);
            let shared: Vec<f64> = (0..groups).map(|_| 0.2 * normal()).collect();
            let residual = DVector::from_fn(n, |i, _| shared[i / each] + normal());
            let lin = Linear::from(Linearised::of_parts(&layout, residual, base, clusters.clone()));
            let added = Basis::of(&lin.basis.reject_columns(&tested), NEW_DIRECTION);
            let full = lin.basis.with(&added.matrix(), NEW_DIRECTION);
            refused += usize::from(pooled_scatter(&lin, &added, &full).is_some_and(|p| p < 0.05));
        }
        assert!(refused <= MOST_REFUSED, "{refused}");
    }

    #[test]
    fn undeclared_noise_is_not_pooled() {
        let layout = Layout::default();
        let columns = DMatrix::from_fn(12, 1, |i, _| (0.7 * count(i)).sin());
        let base = Basis::of(&DMatrix::from_element(12, 1, 1.0), NEW_DIRECTION);
        let clusters: Vec<Vec<usize>> = (0..6).map(|g| vec![2 * g, 2 * g + 1]).collect();
        let lin = Linear::from(Linearised::of_parts(
            &layout,
            columns.column(0).into_owned(),
            base,
            clusters,
        ));
        let added = Basis::of(&lin.basis.reject_columns(&columns), NEW_DIRECTION);
        let full = lin.basis.with(&added.matrix(), NEW_DIRECTION);
        assert_eq!(pooled_scatter(&lin, &added, &full), None);
    }
}
