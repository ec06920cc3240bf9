//! Is a candidate's tangent in the residual by more than chance? Judged at group level.

use crate::algebra::f_tail::f_tail;
use crate::count::count;
use crate::levels::CLEAR_BEYOND_DOUBT;
use crate::levels::MIN_CLUSTERS;
use crate::tests::f_test::{Significance, f_test};
use faer::{MatRef, Side};
use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::levels::MIN_AGREEING;
use crate::noise::linear::Linear;
use crate::tests::agreement::agreement_p_value;
use crate::tests::under_noise::Tested;
use crate::tests::vector_noise::vector_p_value;

/// Fewest degrees of freedom left for which a correlation between neighbours can be estimated.
const MIN_DOF_FOR_CORRELATION: usize = 8;

/// Whether the group level must confirm a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// The effect shows in many groups: the scatter between groups judges it.
    Many,
    /// The effect lives in one group: nothing but the other groups' noise can judge it.
    One,
}

/// What a test has to show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    pub(crate) reach: Reach,
    /// How many candidates were looked at in the same data to find this one.
    pub(crate) searched: f64,
    /// Above it, a test need not be asked further.
    pub(crate) level: f64,
}

/// Tests `tangent` (whitened) beside everything in `base`.
///
/// Three tests, of which the least significant counts: the classical F test; the same after
/// taking out the correlation of successive observations, of neighbours (Prais and Winsten 1954)
/// and of long memory; and one at group level. Where a group is one vector, that is the F test with
/// the covariance of its components estimated; where it holds many readings, a Wald test on the
/// cluster-robust covariance CR2 with Hotelling's T² approximated as Zhang (2012) and Pustejovsky
/// and Tipton (2018) do, which asks no more than independent groups; with as many directions as
/// groups, or more, it is the agreement of the groups with each other.
/// Where one is above `level` the rest are not asked: they could only raise it.
pub(crate) fn significance(
    lin: &Linear<'_>,
    base: &Basis,
    tangent: &DMatrix<f64>,
    reach: Reach,
    level: f64,
) -> Option<Significance> {
    let residual = base.reject(&lin.residual);
    let asked = Asked { reach, searched: 1.0, level };
    let mut beside = base.reject_columns(tangent);
    for (mut left, whole) in beside.column_iter_mut().zip(tangent.column_iter()) {
        // Round-off of a column that the base holds is no direction.
        if left.norm() <= NEW_DIRECTION.sqrt() * whole.norm() {
            left.fill(0.0);
        }
    }
    significance_beside(lin, base, &residual, &beside, asked)
}

/// [`significance`] of a candidate of which `base` leaves `beside`; of the data it leaves
/// `residual`.
///
/// That the candidate was searched for counts under every colour of the noise. The group level
/// then has only to confirm it: its few groups could not tell chances so small apart.
pub(crate) fn significance_beside(
    lin: &Linear<'_>,
    base: &Basis,
    residual: &DVector<f64>,
    beside: &DMatrix<f64>,
    asked: Asked,
) -> Option<Significance> {
    let added = Basis::of(beside, NEW_DIRECTION.sqrt());
    let mut test = f_test(residual, base.dim(), &added)?;
    test.p_value = (test.p_value * asked.searched).min(1.0);
    if test.p_value > asked.level {
        return Some(test);
    }
    let full = base.with(&added.matrix(), NEW_DIRECTION);
    if full.dim() < base.dim() + added.dim() {
        return None;
    }
    // The cheap ones first.
    if asked.reach == Reach::Many {
        let at_group_level = vector_p_value(lin, base, beside, &full)
            .unwrap_or_else(|| group_p_value(lin, &test, residual, &added, &full));
        test.p_value = test.p_value.max(at_group_level);
    }
    if test.dof >= MIN_DOF_FOR_CORRELATION {
        let tested = Tested::new(lin, &full, added.dim(), residual);
        raise(&mut test.p_value, tested.p_values(), asked);
    }
    Some(test)
}

/// Whether what is significant by [`significance_beside`] stays so with the noise in the readings
/// behind the rows.
///
/// To be asked of what is about to be added: it costs more than all other tests.
pub(crate) fn holds_in_readings(
    lin: &Linear<'_>,
    residual: &DVector<f64>,
    beside: &DMatrix<f64>,
    test: &Significance,
    asked: Asked,
) -> bool {
    let is_clear = test.p_value <= CLEAR_BEYOND_DOUBT * asked.level;
    if lin.projected.is_empty() || is_clear || test.dof < MIN_DOF_FOR_CORRELATION {
        return true;
    }
    let added = Basis::of(beside, NEW_DIRECTION.sqrt());
    let full = lin.basis.with(&added.matrix(), NEW_DIRECTION);
    let tested = Tested::new(lin, &full, added.dim(), residual);
    let mut p_value = test.p_value;
    raise(&mut p_value, tested.p_values_of_readings(), asked);
    p_value <= asked.level
}

/// The largest of p-values, until one is above the level asked for.
fn raise(p_value: &mut f64, mut others: impl Iterator<Item = f64>, asked: Asked) {
    while *p_value <= asked.level
        && let Some(other) = others.next()
    {
        *p_value = p_value.max((other * asked.searched).min(1.0));
    }
}

fn group_p_value(
    lin: &Linear<'_>,
    test: &Significance,
    residual: &DVector<f64>,
    added: &Basis,
    full: &Basis,
) -> f64 {
    let clusters = lin.clusters.len();
    if clusters >= MIN_AGREEING && added.dim() >= clusters {
        return agreement_p_value(lin, residual, added);
    }
    if clusters >= MIN_CLUSTERS {
        return cluster_robust(lin, added, full);
    }
    let largest = lin.clusters.iter().map(Vec::len).max().unwrap_or(1);
    if largest == 1 {
        return 0.0;
    }
    // Too few groups to know their scatter well: count each as few readings as may be independent,
    // and let the scatter only object.
    let per_group = largest.min(3);
    let dof = (clusters * per_group).saturating_sub(full.dim()).min(test.dof) / per_group;
    let of_few = f_tail(test.f_statistic, count(test.directions), count(dof.max(1)));
    let has_scatter = clusters >= MIN_AGREEING;
    if has_scatter { of_few.max(cluster_robust(lin, added, full)) } else { of_few }
}

/// Wald test of the amplitudes in the orthonormal basis `added` on their CR2 covariance.
fn cluster_robust(lin: &Linear<'_>, added: &Basis, full: &Basis) -> f64 {
    let q = full.matrix();
    let g = added.matrix();
    let residual = full.reject(&lin.residual);
    let m = g.ncols();
    let mut covariance = DMatrix::zeros(m, m);
    // M_g = A_g·G_g and K_g = Q_gᵀ·M_g, with A_g = (I − Q_g·Q_gᵀ)^(−½).
    let mut adjusted = Vec::with_capacity(lin.clusters.len());
    for cluster in &lin.clusters {
        let q_g = select(&q, cluster);
        let Some(m_g) = inverse_root_times(&q_g, &select(&g, cluster)) else { return 1.0 };
        let e_g = residual.select_rows(cluster);
        let score = m_g.tr_mul(&e_g);
        covariance += &score * score.transpose();
        let k_g = q_g.tr_mul(&m_g);
        adjusted.push((m_g.tr_mul(&m_g), k_g));
    }
    let amplitude = g.tr_mul(&lin.residual);
    let Some(cholesky) = covariance.cholesky() else { return 1.0 };
    let wald = amplitude.dot(&cholesky.solve(&amplitude));
    let eta = satterthwaite(&adjusted, m);
    let dof = eta - count(m) + 1.0;
    if dof <= 0.0 {
        return 1.0;
    }
    f_tail(wald * dof / (eta * count(m)), count(m), dof)
}

/// `M_gᵀ·M_g` and `K_g` of a cluster.
type Adjusted = (DMatrix<f64>, DMatrix<f64>);

/// Degrees of freedom of the Wishart law that matches the total variance of CR2: of the products
/// `P` of all pairs of clusters, `(tr P)² + tr P²`, with `P = M_gᵀ·M_g − K_gᵀ·K_g` of a cluster with
/// itself, else `−K_gᵀ·K_h`.
fn satterthwaite(adjusted: &[Adjusted], m: usize) -> f64 {
    let columns = adjusted.first().map_or(0, |(_, k)| k.nrows());
    let shared = if 2 * columns < adjusted.len() {
        of_pairs_by_moments(adjusted, columns, m)
    } else {
        of_pairs(adjusted, m)
    };
    let own = adjusted.iter().map(|(whole, k)| {
        let product = k.tr_mul(k);
        squares(&(whole - &product)) - squares(&product)
    });
    count(m * (m + 1)) / (shared + own.sum::<f64>())
}

/// `(tr P)² + tr P²`.
fn squares(product: &DMatrix<f64>) -> f64 {
    product.trace().powi(2) + product.dot(&product.transpose())
}

/// Clusters whose products with the others are found together.
const TOGETHER: usize = 32;

/// Sum of [`squares`] of `K_gᵀ·K_h` over all pairs, pair by pair.
fn of_pairs(adjusted: &[Adjusted], m: usize) -> f64 {
    let columns: Vec<_> = adjusted.iter().flat_map(|(_, k)| k.column_iter()).collect();
    let all = DMatrix::from_columns(&columns);
    let mut total = 0.0;
    for start in (0..adjusted.len()).step_by(TOGETHER) {
        let end = (start + TOGETHER).min(adjusted.len());
        let some = all.columns(m * start, m * (end - start)).transpose();
        let products = some * all.columns_range(m * start..);
        for g in start..end {
            for h in g..adjusted.len() {
                let product = products.view((m * (g - start), m * (h - start)), (m, m));
                let term = squares(&product.into_owned());
                // A pair and the same the other way round.
                total += if g == h { term } else { 2.0 * term };
            }
        }
    }
    total
}

/// The same by the second moments of the entries of `K`, `Σ_g K_ai·K_bj`: `Σ W²_(ai)(bj)` and
/// `Σ W_(ai)(bj)·W_(aj)(bi)`, for many clusters beside few columns.
fn of_pairs_by_moments(adjusted: &[Adjusted], columns: usize, m: usize) -> f64 {
    let entries = adjusted.iter().flat_map(|(_, k)| k.iter().copied());
    let all = DMatrix::from_iterator(columns * m, adjusted.len(), entries);
    let moments = &all * all.transpose();
    let mut crossed = 0.0;
    for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let block = |i, j| moments.view((columns * i, columns * j), (columns, columns));
        // W_(aj)(bi) is the block of j and i.
        crossed += block(i, j).dot(&block(j, i));
    }
    moments.norm_squared() + crossed
}

/// `(I − Q·Qᵀ)^(−½)·X` by the eigenvectors of the smaller of `Qᵀ·Q` and `Q·Qᵀ`; `None` where these
/// are not found.
///
/// A direction of leverage one has no residual and is left as it is.
fn inverse_root_times(q: &DMatrix<f64>, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let is_wide = q.nrows() < q.ncols();
    let gram = if is_wide { q * q.transpose() } else { q.transpose() * q };
    let n = gram.nrows();
    let eigen = MatRef::from_column_major_slice(gram.as_slice(), n, n)
        .self_adjoint_eigen(Side::Lower)
        .ok()?;
    let v = DMatrix::from_fn(n, n, |i, j| eigen.U()[(i, j)]);
    let leverages = DVector::from_fn(n, |i, _| eigen.S().column_vector()[i]);
    let stretch = leverages.map(|leverage| {
        let left = 1.0 - leverage;
        let kept = leverage < NEW_DIRECTION || left < NEW_DIRECTION.sqrt();
        if kept { 0.0 } else { left.powf(-0.5) - 1.0 }
    });
    let scaled = |factors: DVector<f64>, mut along: DMatrix<f64>| {
        for (mut row, factor) in along.row_iter_mut().zip(factors.iter()) {
            row *= *factor;
        }
        &v * along
    };
    if is_wide {
        return Some(x + scaled(stretch, v.tr_mul(x)));
    }
    let factors = stretch.zip_map(&leverages, |s, l| if s == 0.0 { 0.0 } else { s / l });
    Some(x + q * scaled(factors, v.tr_mul(&q.tr_mul(x))))
}

fn select(matrix: &DMatrix<f64>, rows: &[usize]) -> DMatrix<f64> {
    matrix.select_rows(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;
    use crate::algebra::linearised::Linearised;

    /// Readings of one group each.
    const N: usize = 40;
    /// Of sums over some thousand products.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn moments_give_what_all_pairs_give() {
        let wave = |of: usize| move |i: usize, j: usize| (0.7 * count(i * of + 3 * j * j)).sin();
        let cluster = |g: usize| {
            (DMatrix::from_fn(2, 2, wave(g + 5)), DMatrix::from_fn(4, 2, wave(2 * g + 1)))
        };
        let adjusted: Vec<Adjusted> = (0..9).map(cluster).collect();
        let by_hand: f64 = (adjusted.iter())
            .flat_map(|(_, g)| adjusted.iter().map(move |(_, h)| squares(&(g.transpose() * h))))
            .sum();
        assert!((of_pairs(&adjusted, 2) / by_hand - 1.0).abs() < ROUND_OFF);
        assert!((of_pairs_by_moments(&adjusted, 4, 2) / by_hand - 1.0).abs() < ROUND_OFF);
    }

    #[test]
    fn a_column_that_the_base_holds_is_no_direction() {
        let wave = |of: usize| move |i: usize, _: usize| (0.7 * count(i * of)).sin();
        let columns = DMatrix::from_columns(&[
            DVector::from_fn(N, wave(1)),
            DVector::from_fn(N, wave(2)),
            DVector::from_fn(N, wave(3)),
        ]);
        let basis = Basis::of(&columns, NEW_DIRECTION);
        let layout = Layout::default();
        let clusters: Vec<_> = (0..N).map(|i| vec![i]).collect();
        let residual = DVector::from_fn(N, wave(5)) + DVector::from_fn(N, wave(7));
        let lin = Linear::from(Linearised::of_parts(&layout, residual, basis, clusters));
        let held = &columns * DMatrix::from_column_slice(3, 1, &[1.0, -2.0, 0.5]);
        assert_eq!(significance(&lin, &lin.basis, &held, Reach::One, 1.0), None);
        let new =
            DMatrix::from_columns(&[held.column(0).into_owned(), DVector::from_fn(N, wave(5))]);
        let test = significance(&lin, &lin.basis, &new, Reach::One, 1.0).unwrap();
        assert_eq!(test.directions, 1);
    }
}
