//! A reference that is read late.

use std::ops::Range;

use crate::{LogSample, LoggedForce};

/// Weights of a quadratic through seven equidistant readings, at the middle one (Savitzky and
/// Golay 1964), times 21: noise falls to √(1/3), slow motion stays.
const SMOOTH: [f64; 7] = [-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0];
/// Places of a block at which the delay is looked at, at most.
const N_PLACES: usize = 8;

/// The force of one segment, midway between what the legs and what the reference say.
///
/// The legs read f(t), the reference f(t − τ), so their mean is nearly f(t − τ/2): half a delay
/// later it is the legs, half a delay earlier the reference. Their noise enters the difference of
/// the two alike, so that noise alone looks like no delay.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    slope_n_per_s: Vec<f64>,
    /// First sample in the log.
    first: usize,
}

impl Record {
    /// Of one segment whose first sample has this index; `None` without a reference.
    pub(crate) fn of(run: &[LogSample], solved: &[LoggedForce], first: usize) -> Option<Self> {
        let middle = |(s, f): (&LogSample, &LoggedForce)| Some(0.5 * (f.normal_n + s.reference_n?));
        let raw: Vec<f64> = run.iter().zip(solved).map(middle).collect::<Option<_>>()?;
        let time_s: Vec<f64> = run.iter().map(|s| s.time_s).collect();
        let force_n = smoothed(&raw);
        let end = time_s.len() - 1;
        let slope = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(end));
            if a == b { 0.0 } else { (force_n[b] - force_n[a]) / (time_s[b] - time_s[a]) }
        };
        let slope_n_per_s = (0..=end).map(slope).collect();
        Some(Self { time_s, force_n, slope_n_per_s, first })
    }

    /// Mean over a block of f(t + τ/2) − f(t − τ/2), and its derivative by τ.
    pub(crate) fn effect(&self, block: &Range<usize>, delay_s: f64) -> (f64, f64) {
        let places = block.clone().step_by(block.len().div_ceil(N_PLACES));
        let share = 1.0 / crate::count(places.len());
        let (mut value, mut slope) = (0.0, 0.0);
        for i in places {
            let time_s = self.time_s[i - self.first];
            let (late, early) = (self.at(time_s + 0.5 * delay_s), self.at(time_s - 0.5 * delay_s));
            value += share * (late.0 - early.0);
            slope += share * 0.5 * (late.1 + early.1);
        }
        (value, slope)
    }

    /// Force and its derivative at a time: cubics through values and slopes, straight beyond the
    /// ends.
    fn at(&self, time_s: f64) -> (f64, f64) {
        let end = self.time_s.len() - 1;
        let i = self.time_s.partition_point(|t| *t <= time_s);
        if i == 0 || i > end {
            let edge = if i == 0 { 0 } else { end };
            let slope = self.slope_n_per_s[edge];
            return (self.force_n[edge] + slope * (time_s - self.time_s[edge]), slope);
        }
        let h = self.time_s[i] - self.time_s[i - 1];
        let u = (time_s - self.time_s[i - 1]) / h;
        let (a, b) = (self.force_n[i - 1], self.force_n[i]);
        let (p, q) = (h * self.slope_n_per_s[i - 1], h * self.slope_n_per_s[i]);
        // a + p u + c u² + d u³ with the values and slopes of both ends.
        let (c, d) = (3.0 * (b - a) - 2.0 * p - q, 2.0 * (a - b) + p + q);
        (a + u * (p + u * (c + u * d)), (p + u * (2.0 * c + u * 3.0 * d)) / h)
    }
}

/// Smoothed where seven readings are at hand.
fn smoothed(raw: &[f64]) -> Vec<f64> {
    let mut out = raw.to_vec();
    for (i, window) in raw.windows(SMOOTH.len()).enumerate() {
        let sum: f64 = window.iter().zip(SMOOTH).map(|(v, w)| v * w).sum();
        out[i + SMOOTH.len() / 2] = sum / 21.0;
    }
    out
}
