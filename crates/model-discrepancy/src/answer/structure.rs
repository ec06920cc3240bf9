//! Structure that no covariate explains: neighbours, in order or in place, that agree.

use crate::algebra::linearised::groups_are_runs;
use crate::levels::{NEIGHBOURS_AGREE, ONLY_NOISE};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use std::collections::BTreeMap;

use crate::choice::context::Context;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::{Covariate, Origin, Quantity, Remaining};

/// Shape of what goes on from each observation to the next.
const AUTOCORRELATED: &str = "autocorrelated";

/// Neighbours of an observation whose residuals are compared with its own.
const NEIGHBOURS: usize = 4;

/// Observations before and after one, and it, that are not taken for its neighbours in place where each goes with the
/// one before: half of a memory of a half from each to the next is gone after one, a thirtieth is left after five.
const REMEMBERED: usize = 5;

/// Largest lag-one correlation of noise: what goes on for longer and has no declared size may be anything.
const MOST_REMEMBERED: f64 = 0.8;

/// Fewest pairs of successive observations that tell memory from what goes on.
const FEWEST_REMEMBERED: f64 = 80.0;

/// Lags at which what is new in each observation is compared; the first is taken by the memory.
const LATER: std::ops::RangeInclusive<usize> = 2..=8;

/// Standard deviations of the sum of these correlations, and significance of their squares, up to which nothing goes on.
/// Of 110 observations of noise with a memory of 0.3 to 0.75 one in six is doubted; of a wave that makes half of the
/// variance, of a period of seven observations or of twice the series, one in thirty is not.
const HARDLY_LONGER: f64 = 1.0;
const NOTHING_LATER: f64 = 0.05;

/// Squared distances that differ by less are the same, over the spread of all places.
const AS_FAR: f64 = 1e-9;

/// Fewest observations, and most, for which neighbours are compared (the search is quadratic).
const OBSERVATIONS: std::ops::RangeInclusive<usize> = 12..=2000;

/// Agreement of neighbours in the measured order and in position.
///
/// Where a group holds several observations, they may depend on each other: the groups must not.
pub(crate) fn structure(context: &Context<'_>, lin: &Linear<'_>) -> Vec<Remaining> {
    let residual = lin.clean_residual();
    let mut found = if groups_are_runs(lin) {
        group_z(lin, &residual)
            .map(|z| remaining("order", AUTOCORRELATED, upper_tail(z)))
            .into_iter()
            .collect()
    } else {
        neighbours(context, lin, &residual)
    };
    found.retain(|r| r.p_value <= NEIGHBOURS_AGREE);
    found
}

/// Neighbours that agree, with what little doubt is enough where noise is to be called larger than declared: inside
/// groups, too, since the noise was declared of readings that do not depend on each other.
pub(crate) fn traces_of_structure(context: &Context<'_>, lin: &Linear<'_>) -> Vec<Remaining> {
    let residual = lin.clean_residual();
    let groups = group_z(lin, &residual).map(|z| remaining("order", AUTOCORRELATED, upper_tail(z)));
    let mut found = neighbours(context, lin, &residual);
    found.extend(groups.filter(|_| found.iter().all(|r| r.p_value > ONLY_NOISE)));
    found.retain(|r| r.p_value <= ONLY_NOISE);
    found
}

/// How well the readings before and after each, and those nearest to it, agree with it.
fn neighbours(context: &Context<'_>, lin: &Linear<'_>, residual: &DVector<f64>) -> Vec<Remaining> {
    let mut found = Vec::new();
    let mut memory = 0.0;
    if lin.series.iter().map(Vec::len).max().unwrap_or(0) >= *OBSERVATIONS.start() {
        let (correlation, pairs) = lag_one(lin, &lin.basis.matrix(), residual);
        let p_value = upper_tail(correlation * pairs.sqrt());
        if p_value <= NEIGHBOURS_AGREE {
            memory = correlation.min(MOST_REMEMBERED);
        }
        found.push(remaining("order", AUTOCORRELATED, p_value));
    }
    // What agrees with the one before says nothing of the place, where the way goes from neighbour to neighbour.
    let apart = if memory > 0.0 { REMEMBERED } else { 0 };
    if let Some((z, skewness)) = neighbour_z(context, lin, residual, apart) {
        // On the way back what goes together meets again what went together on the way there, and the products of one
        // pair and the next are no more independent than that (Bartlett 1946, of two series with this memory).
        let square = memory * memory;
        let z = z * ((1.0 - square) / (1.0 + square)).sqrt();
        found.push(remaining("position", "neighbours agree", upper_tail_of_skewed(z, skewness)));
    }
    found
}

/// The lag-one correlation beyond what the fit leaves by itself, and the number of pairs: times the root of that it is
/// a standard normal where nothing is remembered.
fn lag_one(lin: &Linear<'_>, q: &DMatrix<f64>, residual: &DVector<f64>) -> (f64, f64) {
    let (mut lagged, mut square, mut leaked, mut free, mut pairs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for one in &lin.series {
        for &i in one {
            square += residual[i] * residual[i];
            free += 1.0 - q.row(i).norm_squared();
        }
        for pair in one.windows(2) {
            lagged += residual[pair[0]] * residual[pair[1]];
            leaked -= q.row(pair[0]).dot(&q.row(pair[1]));
            pairs += 1.0;
        }
    }
    if square <= 0.0 || free <= 0.0 {
        return (0.0, pairs);
    }
    (lagged / square - leaked / free, pairs)
}

/// Whether what is left is remembered from one observation to the next and, beyond that, forgotten: noise with memory,
/// and nothing that goes on for longer, as whatever depends on time or place does. Of few observations nobody can say.
pub(crate) fn is_forgotten(lin: &Linear<'_>) -> bool {
    let residual = lin.clean_residual();
    let (memory, pairs) = lag_one(lin, &lin.basis.matrix(), &residual);
    let news: Vec<Vec<f64>> = (lin.series.iter())
        .map(|one| one.windows(2).map(|p| residual[p[1]] - memory * residual[p[0]]).collect())
        .collect();
    let square: f64 = news.iter().flatten().map(|e| e * e).sum();
    let product = |lag: usize| -> f64 {
        news.iter().flat_map(|one| one.iter().zip(one.iter().skip(lag))).map(|(a, b)| a * b).sum()
    };
    let later: Vec<f64> = LATER.map(|lag| product(lag) / square * pairs.sqrt()).collect();
    // Ljung and Box 1978, of lags that are few beside the pairs.
    let portmanteau: f64 = later.iter().map(|z| z * z).sum();
    let goes_on = later.iter().sum::<f64>() / count(later.len()).sqrt();
    pairs >= FEWEST_REMEMBERED
        && memory <= MOST_REMEMBERED
        && goes_on <= HARDLY_LONGER
        && upper_tail_of_square(portmanteau, later.len()) >= NOTHING_LATER
}

/// Lag-one correlation of the groups' mean residuals, times the root of their number; `None` for
/// few groups.
fn group_z(lin: &Linear<'_>, residual: &DVector<f64>) -> Option<f64> {
    let mean =
        |group: &Vec<usize>| group.iter().map(|&i| residual[i]).sum::<f64>() / count(group.len());
    let means: Vec<f64> = lin.clusters.iter().map(mean).collect();
    let square: f64 = means.iter().map(|m| m * m).sum();
    let lagged: f64 = means.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let enough = means.len() >= *OBSERVATIONS.start() && square > 0.0;
    enough.then(|| lagged / square * count(means.len()).sqrt())
}

/// Whether that is left which noise with memory leaves.
pub(crate) fn is_memory(remaining: &Remaining) -> bool {
    remaining.shape == AUTOCORRELATED
}

fn remaining(covariate: &str, shape: &str, p_value: f64) -> Remaining {
    Remaining { covariate: covariate.to_owned(), shape: shape.to_owned(), p_value }
}

fn upper_tail(z: f64) -> f64 {
    Normal::standard().sf(z)
}

fn upper_tail_of_square(chi2: f64, dof: usize) -> f64 {
    ChiSquared::new(count(dof)).map_or(0.0, |law| law.sf(chi2))
}

/// Skewness below which a law is the normal one.
const SYMMETRIC: f64 = 1e-3;

/// The same of a standardised law with this skewness: Pearson's third type, a shifted χ².
fn upper_tail_of_skewed(z: f64, skewness: f64) -> f64 {
    if skewness.abs() < SYMMETRIC {
        return upper_tail(z);
    }
    let dof = 8.0 / (skewness * skewness);
    let Ok(law) = ChiSquared::new(dof) else { return upper_tail(z) };
    let at = |z: f64| (dof + z * (2.0 * dof).sqrt()).max(0.0);
    if skewness > 0.0 { law.sf(at(z)) } else { law.cdf(at(-z)) }
}

/// Moran's I of the residuals of a regression, of neighbours more than `apart` in the order, standardised, and its skewness
/// (Cliff and Ord 1981, ch. 8; the third moment as that of any ratio of quadratic forms).
fn neighbour_z(
    context: &Context<'_>,
    lin: &Linear<'_>,
    residual: &DVector<f64>,
    apart: usize,
) -> Option<(f64, f64)> {
    let pairs = neighbour_pairs(context, lin, apart)?;
    let times_w = |x: &DVector<f64>| {
        let mut y = DVector::zeros(x.len());
        for &(i, j) in &pairs {
            y[i] += 0.5 * x[j];
            y[j] += 0.5 * x[i];
        }
        y
    };
    let q = lin.basis.matrix();
    let dof = count(residual.len().checked_sub(q.ncols()).filter(|&d| d > 2)?);
    let times = |columns: &DMatrix<f64>| {
        let all: Vec<_> = columns.column_iter().map(|c| times_w(&c.into_owned())).collect();
        DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| all[j][i])
    };
    // Traces of powers of M W, M = I − Q Qᵀ.
    let wq = times(&q);
    let (one, two) = (q.tr_mul(&wq), wq.tr_mul(&wq));
    let three = wq.tr_mul(&times(&wq));
    let weights = weights_of(&pairs, residual.len());
    let product = |a: &DMatrix<f64>, b: &DMatrix<f64>| a.tr_mul(b).trace();
    let traces = [
        -one.trace(),
        trace_of_square(&weights) - 2.0 * two.trace() + product(&one, &one),
        trace_of_cube(&weights) - 3.0 * three.trace() + 3.0 * product(&one, &two)
            - product(&(&one * &one), &one),
    ];
    let square = residual.norm_squared();
    let observed = residual.dot(&times_w(residual)) / square;
    let mean = traces[0] / dof;
    let about_mean = traces[1] - dof * mean * mean;
    let variance = 2.0 * about_mean / (dof * (dof + 2.0));
    let third = traces[2] - 3.0 * mean * traces[1] + 2.0 * dof * mean.powi(3);
    let skewness = 8.0 * third / (dof * (dof + 2.0) * (dof + 4.0)) / variance.powf(1.5);
    (square > 0.0 && variance > 0.0).then(|| ((observed - mean) / variance.sqrt(), skewness))
}

/// Rows of the symmetric matrix with entries ½ per direction of a pair.
fn weights_of(pairs: &[(usize, usize)], n: usize) -> Vec<BTreeMap<usize, f64>> {
    let mut rows = vec![BTreeMap::new(); n];
    for &(i, j) in pairs {
        *rows[i].entry(j).or_insert(0.0) += 0.5;
        *rows[j].entry(i).or_insert(0.0) += 0.5;
    }
    rows
}

fn trace_of_square(weights: &[BTreeMap<usize, f64>]) -> f64 {
    weights.iter().flat_map(BTreeMap::values).map(|w| w * w).sum()
}

fn trace_of_cube(weights: &[BTreeMap<usize, f64>]) -> f64 {
    let around = |i: usize| {
        let of = |(&j, &w): (&usize, &f64)| {
            let closed = weights[j].iter().filter_map(|(k, v)| Some(v * weights[*k].get(&i)?));
            w * closed.sum::<f64>()
        };
        weights[i].iter().map(of).sum::<f64>()
    };
    (0..weights.len()).map(around).sum()
}

/// Positions, within the rows of `lin`, of each row and the same component of each neighbour, more than `apart` from it
/// in the order.
fn neighbour_pairs(
    context: &Context<'_>,
    lin: &Linear<'_>,
    apart: usize,
) -> Option<Vec<(usize, usize)>> {
    let axes = axes_of(context);
    let mut pairs = Vec::new();
    for one in &lin.series {
        let observation = |i: usize| lin.layout.rows[lin.rows[i]].observation;
        if axes.is_empty() || !OBSERVATIONS.contains(&one.len()) {
            return None;
        }
        for (at, &i) in one.iter().enumerate() {
            let distance = |j: usize| -> f64 {
                let (i, j) = (observation(i), observation(j));
                let square: f64 = axes.iter().map(|axis| (axis[i] - axis[j]).powi(2)).sum();
                // The last digits of a turned frame decide nothing.
                (square / AS_FAR).round()
            };
            let others = one.iter().enumerate().filter(|(to, _)| at.abs_diff(*to) > apart);
            let mut others: Vec<_> = others.map(|(_, &j)| (distance(j), j)).collect();
            others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            pairs.extend(others.iter().take(NEIGHBOURS).map(|&(_, j)| (i, j)));
        }
    }
    (!pairs.is_empty()).then_some(pairs)
}

/// What makes a place, one list of values per axis: positions over the spread of all of them, so that places are as far
/// apart in any frame, and what lies flat is not looked at from the side; anything else over its own.
fn axes_of(context: &Context<'_>) -> Vec<Vec<f64>> {
    let is_of_place =
        |c: &&Covariate| c.origin == Origin::Coordinate && c.quantity != Quantity::Order;
    let coordinates = context.covariates.iter().filter(is_of_place);
    let (positions, others): (Vec<&Covariate>, Vec<&Covariate>) =
        coordinates.partition(|c| c.quantity == Quantity::Position);
    let over =
        |c: &Covariate, scale: f64| -> Vec<f64> { c.values.iter().map(|v| v / scale).collect() };
    let of_positions: f64 = positions.iter().map(|c| spread(&c.values)).sum();
    let scale = if of_positions > 0.0 { of_positions.sqrt() } else { 1.0 };
    let others = others.into_iter().map(|c| {
        let own = spread(&c.values).sqrt();
        over(c, if own > 0.0 { own } else { 1.0 })
    });
    others.chain(positions.iter().map(|c| over(c, scale))).collect()
}

fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / count(values.len().max(1))
}

/// Mean square distance from the mean.
fn spread(values: &[f64]) -> f64 {
    let mean = mean_of(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count(values.len().max(1))
}
