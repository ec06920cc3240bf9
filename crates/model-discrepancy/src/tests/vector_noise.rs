//! Noise of vector observations: components of unequal size, and correlated with each other.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test;

/// Fewest groups per component from which a covariance between components is worth estimating.
const GROUPS_PER_COMPONENT: usize = 3;

/// p-value with the covariance between the components of a group estimated from the residual.
///
/// For groups of one vector each (a point, the centre of a press). The rows are whitened with
/// the estimated covariance and a group counts as one reading: `G − ⌈(p + m)/k⌉` degrees of
/// freedom for `G` groups of `k` components. `None` where the groups are not such vectors, or
/// too few.
pub(crate) fn vector_p_value(
    lin: &Linear<'_>,
    base: &Basis,
    tangent: &DMatrix<f64>,
    full: &Basis,
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
    let added =
        Basis::of(&base_white.reject_columns(&white(tangent.clone())), NEW_DIRECTION.sqrt());
    let mut data: DVector<f64> = lin.residual.clone();
    whiten(data.as_mut_slice());
    let data = base_white.reject(&data);
    let test = f_test(&data, base_white.dim(), &added)?;
    Some(f_tail(test.f_statistic, count(test.directions), count(dof)))
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
