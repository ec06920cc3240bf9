//! What a model would have predicted for groups it had not seen.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::algebra::product::{gram, times, view};
use crate::count::count;
use crate::noise::linear::Linear;

/// Most groups that are left out one by one; beyond, they are left out in this many folds.
const MAX_SINGLE: usize = 64;

/// Folds where there are more groups than [`MAX_SINGLE`].
const FOLDS: usize = 32;

/// One minus the leverage of a fold below which the rest of the data do not predict it.
pub(crate) const MIN_LEFT: f64 = 1e-9;

/// Squared errors of one group that the fit did not see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GroupError {
    /// Sum of squared whitened residuals, over all rows.
    pub(crate) whitened: f64,
    /// Sum of squared reported residuals, in report units squared.
    pub(crate) reported: f64,
    /// Observations with a reported row.
    pub(crate) observations: usize,
}

/// Error of each cluster of a [`Linear`] when left out; `None` where the rest of the data cannot
/// predict it.
pub(crate) type HeldOut = Vec<Option<GroupError>>;

/// Fold of each cluster: one each up to [`MAX_SINGLE`], then interleaved along measured order.
pub(crate) fn folds(clusters: usize, most: usize) -> Vec<usize> {
    let folds = if clusters <= most.min(MAX_SINGLE) { clusters } else { most.min(FOLDS) };
    (0..clusters).map(|c| c % folds.max(1)).collect()
}

/// Leaves each fold out of the linearised fit with span `basis`.
///
/// The prediction error of left-out rows `e` with leverage block `H` is `(I − H)⁻¹·e`.
///
/// Clusters for which `skip` is true stay in the fit and are not judged.
pub(crate) fn leave_out(
    lin: &Linear<'_>,
    basis: &Basis,
    folds: &[usize],
    skip: &[bool],
) -> HeldOut {
    let residual = basis.reject(&lin.residual);
    let mut held_out = vec![None; lin.clusters.len()];
    for fold in 0..folds.iter().max().map_or(0, |&f| f + 1) {
        let members: Vec<_> = (0..folds.len()).filter(|&c| folds[c] == fold && !skip[c]).collect();
        let rows: Vec<_> = members.iter().flat_map(|&c| lin.clusters[c].iter().copied()).collect();
        let Some(predicted) = predict(basis, &residual, &rows) else { continue };
        errors_of(lin, &members, &predicted, &mut held_out);
    }
    held_out
}

/// Puts the errors of clusters, predicted row by row, to their places.
pub(crate) fn errors_of(
    lin: &Linear<'_>,
    clusters: &[usize],
    predicted: &DVector<f64>,
    held_out: &mut HeldOut,
) {
    let mut offset = 0;
    for &c in clusters {
        let n = lin.clusters[c].len();
        let errors = predicted.rows(offset, n).into_owned();
        held_out[c] = Some(group_error(lin, &lin.clusters[c], &errors));
        offset += n;
    }
}

/// Errors of `rows` predicted without them; `None` where the rest does not predict them.
pub(crate) fn predict(
    basis: &Basis,
    residual: &DVector<f64>,
    rows: &[usize],
) -> Option<DVector<f64>> {
    let q_f = basis.rows(rows);
    let e_f = residual.select_rows(rows);
    let (n, k) = q_f.shape();
    if k == 0 {
        return Some(e_f);
    }
    // The smaller of the two equivalent systems: over the rows left out, or over the parameters.
    let gram = if n <= k { times(view(&q_f), view(&q_f).transpose()) } else { gram(&q_f) };
    let left = DMatrix::identity(gram.nrows(), gram.nrows()) - gram;
    let factor = left.cholesky()?;
    if factor.l_dirty().diagonal().iter().any(|d| d * d < MIN_LEFT) {
        return None;
    }
    Some(if n <= k {
        factor.solve(&e_f)
    } else {
        let along = factor.solve(&q_f.tr_mul(&e_f));
        e_f + q_f * along
    })
}

/// Sums the errors (whitened, one per position in `rows`) of one group.
pub(crate) fn group_error(lin: &Linear<'_>, rows: &[usize], errors: &DVector<f64>) -> GroupError {
    let mut sum = GroupError::default();
    let mut last = None;
    for (&i, error) in rows.iter().zip(errors.iter()) {
        let row = lin.layout.rows[lin.rows[i]];
        sum.whitened += error * error;
        if row.reported {
            sum.reported += (error * lin.sigma[i]).powi(2);
            if last != Some(row.observation) {
                sum.observations += 1;
                last = Some(row.observation);
            }
        }
    }
    sum
}

/// Root mean square per observation over the groups that could be predicted, and its standard
/// error from the scatter between groups.
pub(crate) fn rms(errors: &[Option<GroupError>]) -> (f64, f64) {
    let known: Vec<_> = errors.iter().flatten().filter(|e| e.observations > 0).collect();
    let observations: f64 = known.iter().map(|e| count(e.observations)).sum();
    if known.is_empty() {
        return (f64::NAN, f64::NAN);
    }
    let mean = known.iter().map(|e| e.reported).sum::<f64>() / observations;
    let groups = count(known.len());
    let scatter: f64 =
        known.iter().map(|e| (e.reported - mean * count(e.observations)).powi(2)).sum();
    let rms = mean.sqrt();
    let std = if known.len() > 1 && rms > 0.0 {
        (scatter * groups / (groups - 1.0)).sqrt() / observations / (2.0 * rms)
    } else {
        f64::NAN
    };
    (rms, std)
}

/// Paired comparison of two models on the groups that both predict.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Comparison {
    /// Mean difference of squared whitened error, second minus first, per group.
    pub(crate) difference: f64,
    /// Standard error of `difference`.
    pub(crate) std: f64,
    /// Sum of squared reported error of each model on those groups.
    pub(crate) reported: [f64; 2],
    /// Groups that both predict.
    pub(crate) judged: usize,
    /// Groups that the first predicts and the second does not.
    pub(crate) lost: usize,
}

/// Compares `second` with `first`, leaving out the clusters for which `skip` is true.
pub(crate) fn compare(first: &HeldOut, second: &HeldOut, skip: &[bool]) -> Comparison {
    let mut differences = Vec::new();
    let mut reported = [0.0; 2];
    let mut lost = 0;
    for ((a, b), _) in first.iter().zip(second).zip(skip).filter(|(_, skip)| !**skip) {
        match (a, b) {
            (Some(a), Some(b)) => {
                differences.push(b.whitened - a.whitened);
                reported[0] += a.reported;
                reported[1] += b.reported;
            }
            (Some(_), None) => lost += 1,
            (None, _) => {}
        }
    }
    let judged = differences.len();
    let n = count(judged.max(1));
    let difference = differences.iter().sum::<f64>() / n;
    let scatter: f64 = differences.iter().map(|d| (d - difference).powi(2)).sum();
    let std = (scatter / (n - 1.0).max(1.0) / n).sqrt();
    Comparison { difference, std, reported, judged, lost }
}
