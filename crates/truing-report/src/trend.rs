//! Means and spreads along an axis: structure that single readings hide.

use super::number::real;

/// Fewer readings than this show their structure themselves.
pub(crate) const LEAST: usize = 40;
/// Readings in one mean, at least.
const PER_MEAN: usize = 12;
/// Means along one axis, at most.
const MOST_MEANS: usize = 30;
/// Up to this many distinct places, each gets its own mean.
const DISTINCT: usize = 12;

/// Means `[x, y]` of stretches along x, ascending; empty where there are too few readings.
///
/// Stretches hold equally many readings. Where x takes only a few values, each has its mean.
pub(crate) fn means(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if points.len() < LEAST {
        return Vec::new();
    }
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let distinct = sorted.chunk_by(same_place).take(DISTINCT + 1).count();
    if distinct <= DISTINCT {
        return sorted.chunk_by(same_place).map(mean).collect();
    }
    let n = (sorted.len() / PER_MEAN).clamp(1, MOST_MEANS);
    sorted.chunks(sorted.len().div_ceil(n)).map(mean).collect()
}

/// Spread of one stretch of readings along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    /// Mean place.
    pub(crate) x: f64,
    /// Smallest and largest.
    pub(crate) all: [f64; 2],
    /// What two thirds lie between.
    pub(crate) two_thirds: [f64; 2],
}

/// Spreads of at most `most` stretches of equally many neighbouring readings, in their order.
pub(crate) fn spreads(points: &[[f64; 2]], most: usize) -> Vec<Spread> {
    let length = points.len().div_ceil(most.max(1)).max(1);
    points.chunks(length).map(spread).collect()
}

fn spread(points: &[[f64; 2]]) -> Spread {
    let mut values: Vec<f64> = points.iter().map(|p| p[1]).collect();
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    let sixth = last / 6;
    Spread {
        x: mean(points)[0],
        all: [values[0], values[last]],
        two_thirds: [values[sixth], values[last - sixth]],
    }
}

fn same_place(a: &[f64; 2], b: &[f64; 2]) -> bool {
    a[0].total_cmp(&b[0]).is_eq()
}

fn mean(points: &[[f64; 2]]) -> [f64; 2] {
    let share = 1.0 / real(points.len());
    points.iter().fold([0.0, 0.0], |sum, p| [sum[0] + share * p[0], sum[1] + share * p[1]])
}
