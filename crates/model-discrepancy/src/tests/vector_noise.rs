//! Noise of vector observations: components of unequal size, and correlated with each other.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::levels::UNEVEN;
use crate::noise::linear::Linear;
use crate::tests::cluster_robust::cluster_robust;
use crate::tests::f_test::f_test;
use crate::tests::scatter_along::ScatterAlong;

/// Fewest groups per component from which a covariance between components is worth estimating.
const GROUPS_PER_COMPONENT: usize = 3;

/// p-value with the covariance between the components of a group estimated from the residual.
///
/// For groups of one vector each (a point, the centre of a press). The rows are whitened with
/// the estimated covariance and a group counts as one reading: `G − ⌈(p + m)/k⌉` degrees of
/// freedom for `G` groups of `k` components. Where groups scatter along the candidate by more than that, as points do
/// whose noise grows with their distance, the cluster-robust test is asked, too. `None` where the groups are not such
/// vectors, or too few.
pub(crate) fn vector_p_value(
    lin: &Linear<'_>,
    base: &Basis,
    tangent: &DMatrix<f64>,
    (added, full): (&Basis, &Basis),
) -> Option<f64> {
    let k = vector_length(lin)?;
    let groups = lin.clusters.len();
    let dof = groups.checked_sub(full.dim().div_ceil(k)).filter(|&d| d > 0)?;
    let residual = full.reject(&lin.residual);
    let mut covariance = DMatrix::zeros(k, k);
    for cluster in &lin.clusters {
        let e = residual.select_rows(cluster);
        covariance += &e * e.transpose();
    }
    let root = (covariance / count(dof)).cholesky()?.l();
    let whiten = |column: &mut [f64]| {
        for cluster in &lin.clusters {
            for (i, &row) in cluster.iter().enumerate() {
                let before = cluster[..i].iter().enumerate();
                let known: f64 = before.map(|(j, &row)| root[(i, j)] * column[row]).sum();
                column[row] = (column[row] - known) / root[(i, i)];
            }
        }
    };
    let white = |mut columns: DMatrix<f64>| {
        let rows = columns.nrows().max(1);
        columns.as_mut_slice().chunks_exact_mut(rows).for_each(&whiten);
        columns
    };
    let base_white = Basis::of(&white(base.matrix()), NEW_DIRECTION);
    let added_white =
        Basis::of(&base_white.reject_columns(&white(tangent.clone())), NEW_DIRECTION.sqrt());
    let mut data: DVector<f64> = lin.residual.clone();
    whiten(data.as_mut_slice());
    let data = base_white.reject(&data);
    let test = f_test(&data, base_white.dim(), &added_white)?;
    let all_white = base_white.with(&added_white.matrix(), NEW_DIRECTION);
    // The covariance was estimated of all groups alike, and whitened to variance one.
    let scatter =
        ScatterAlong::of(&lin.clusters, (&added_white, &all_white), &all_white.reject(&data), 1.0);
    let is_uneven = scatter.p_value() < UNEVEN;
    let robust = if is_uneven { cluster_robust(lin, added, full) } else { 0.0 };
    Some(robust.max(f_tail(test.f_statistic, count(test.directions), count(dof))))
}

/// Components per group, when every group is one observation with the same components.
fn vector_length(lin: &Linear<'_>) -> Option<usize> {
    let components = |cluster: &Vec<usize>| {
        let rows = cluster.iter().map(|&i| lin.layout.rows[lin.rows[i]]);
        rows.map(|r| (r.component, r.observation)).collect::<Vec<_>>()
    };
    let first = components(lin.clusters.first()?);
    let same = |cluster: &Vec<usize>| {
        let own = components(cluster);
        own.len() == first.len()
            && own.iter().zip(&first).all(|(a, b)| a.0 == b.0 && a.1 == own[0].1)
    };
    let k = first.len();
    let enough = lin.clusters.len() >= GROUPS_PER_COMPONENT * k;
    (enough && lin.clusters.iter().all(same)).then_some(k)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::algebra::linearised::Linearised;
    use crate::{Layout, Row};

    const POINTS: usize = 60;
    const SETS: usize = 400;
    /// Of tests at 0.01 no more than this many of 400 may refuse: the binomial bound once in a thousand.
    const MOST_REFUSED: usize = 12;

    /// How many tests at 0.01 of a scale of points find one that is not there, in noise that grows with this power
    /// of the distance.
    fn refused(power: i32) -> usize {
        let mut rng = ChaCha8Rng::seed_from_u64(31);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let clusters: Vec<Vec<usize>> = (0..POINTS).map(|p| (3 * p..3 * p + 3).collect()).collect();
        let row =
            |i: usize| Row { observation: i / 3, component: i % 3, sigma: 1.0, reported: true };
        let rows = (0..3 * POINTS).map(row).collect();
        let layout = Layout { rows, sigma_declared: true, ..Layout::default() };
        let mut refused = 0;
        for _ in 0..SETS {
            let places = DMatrix::from_fn(3 * POINTS, 1, |_, _| normal());
            let distance = |i: usize| places.rows(i - i % 3, 3).norm();
            let shifts = DMatrix::from_fn(3 * POINTS, 3, |i, j| f64::from(u8::from(i % 3 == j)));
            let residual = DVector::from_fn(3 * POINTS, |i, _| distance(i).powi(power) * normal());
            let base = Basis::of(&shifts, NEW_DIRECTION);
            let beside = base.reject_columns(&places);
            let lin = Linear::from(Linearised::of_parts(&layout, residual, base, clusters.clone()));
            let added = Basis::of(&beside, NEW_DIRECTION);
            let full = lin.basis.with(&added.matrix(), NEW_DIRECTION);
            let p = vector_p_value(&lin, &lin.basis, &beside, (&added, &full)).expect("vectors");
            refused += usize::from(p < 0.01);
        }
        refused
    }

    #[test]
    fn it_keeps_its_level_where_noise_grows_with_what_a_point_has_of_the_effect() {
        for power in [0, 1, 2] {
            let refused = refused(power);
            assert!(refused <= MOST_REFUSED, "{refused} in noise with distance^{power}");
        }
    }
}
