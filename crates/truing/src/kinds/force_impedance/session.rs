//! Whether the legs and the reference of a log are of one session.

use force_impedance::LogSample;
use model_discrepancy::{independent_share, lag_one};

use crate::count::count;

/// Variation within segments, over the size of the force, from which on it is the force that varies and no
/// instrument that wanders.
const VARIES: f64 = 0.03;
/// Correlation of a reading with the next from which on most of what varies is no noise: of what legs show
/// of a force, noise in the reference takes away its share of the square.
const SMOOTH: f64 = 0.7;
/// Slope of what the legs show on what the reference reads below which they do not follow it: of one
/// session it is one, but for a gain, noise in the reference, and a delay.
const FOLLOWS: f64 = 0.5;
/// Correlation of both below which they do not: of legs that lose a share of the force it is one.
const GOES_WITH: f64 = 0.5;
/// Standard uncertainties by which it must miss one.
const FAR: f64 = 2.0;

/// Whether the legs show less than half of how the reference varies within segments, and much that it does
/// not, from residuals in the sense normal force − reference.
///
/// Loads that are asked for come again in another session, in the same order; how they are then held does
/// not. What the declared model lacks adds to what the legs show and seldom goes against the force itself.
pub(super) fn is_another(samples: &[LogSample], residuals: impl Iterator<Item = f64>) -> bool {
    let pairs: Option<Vec<(f64, f64)>> = (samples.iter().zip(residuals))
        .map(|(sample, residual)| sample.reference_n.map(|read| (read, read + residual)))
        .collect();
    let Some(pairs) = pairs.filter(|pairs| !pairs.is_empty()) else { return false };
    let within = |of: fn(&(f64, f64)) -> f64| -> Vec<Vec<f64>> {
        let mut rows = pairs.iter();
        let of_segment = |segment: &[LogSample]| {
            let values: Vec<f64> = rows.by_ref().take(segment.len()).map(of).collect();
            let mean = values.iter().sum::<f64>() / count(values.len());
            values.into_iter().map(|value| value - mean).collect()
        };
        samples.chunk_by(|a, b| a.segment == b.segment).map(of_segment).collect()
    };
    let (read, shown) = (within(|pair| pair.0), within(|pair| pair.1));
    let dot = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
    };
    let (square, across) = (dot(&read, &read), dot(&read, &shown));
    let size: f64 = pairs.iter().map(|(read, _)| read * read).sum();
    let [(own, n), (of_legs, _)] = [&read, &shown].map(|of| lag_one(of.iter().map(Vec::as_slice)));
    if square < VARIES * VARIES * size || own < SMOOTH {
        return false;
    }
    let slope = across / square;
    let legs = dot(&shown, &shown) / square;
    let left = legs - slope * slope;
    // Of two series that know nothing of each other (Bartlett 1946).
    let independent = n * independent_share((own * of_legs.max(0.0)).sqrt(), n);
    let uncertainty = (left.max(0.0) / independent).sqrt();
    let is_followed = slope >= FOLLOWS || slope >= GOES_WITH * legs.sqrt();
    !is_followed && slope + FAR * uncertainty < 1.0
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// Samples of a segment, and segments.
    const EACH: usize = 60;
    const MANY: usize = 9;

    /// Loads of 20, 40 and 60 N in turn, held to a tenth: how, is another thing on another day.
    fn force_n(i: usize, day: f64) -> f64 {
        let load_n = [20.0, 40.0, 60.0][i / EACH % 3];
        let at = count(i);
        load_n * (1.0 + 0.1 * (0.31 * at + 2.0 * day).sin() * (0.043 * at * day).cos())
    }

    /// What is said of a reference where the legs are off by `residual_n`.
    fn said(reference_n: impl Fn(usize) -> f64, residual_n: impl Fn(usize) -> f64) -> bool {
        let sample = |i: usize| LogSample {
            time_s: count(i),
            lengths_mm: [100.0; 4],
            cells_n: [0.0; 4],
            normal: Vector3::z_axis(),
            reference_n: Some(reference_n(i)),
            segment: i / EACH,
        };
        let samples: Vec<LogSample> = (0..MANY * EACH).map(sample).collect();
        is_another(&samples, (0..MANY * EACH).map(residual_n))
    }

    #[test]
    fn the_same_loads_on_another_day_are_another_session() {
        assert!(said(|i| force_n(i, 1.0), |i| force_n(i, 1.7) - force_n(i, 1.0)));
    }

    /// How a load is held may be in part that of the day before.
    #[test]
    fn a_course_that_is_alike_by_a_third_is_another_session() {
        let other = |i: usize| 0.35 * force_n(i, 1.0) + 0.65 * force_n(i, 1.7);
        assert!(said(|i| force_n(i, 1.0), |i| other(i) - force_n(i, 1.0)));
    }

    #[test]
    fn what_legs_lack_of_a_force_that_they_follow_is_of_the_session() {
        // Ten times what varies, by the sense of the change; half of the force lost.
        let sense = |i: usize| (force_n(i + 1, 1.0) - force_n(i, 1.0)).signum();
        assert!(!said(|i| force_n(i, 1.0), |i| 30.0 * sense(i)));
        assert!(!said(|i| force_n(i, 1.0), |i| -0.5 * force_n(i, 1.0)));
    }

    #[test]
    fn a_load_that_is_held_tells_nothing() {
        let wanders = |i: usize, day: f64| 40.0 + 0.02 * (force_n(i, day) - 40.0);
        assert!(!said(|i| wanders(i, 1.0), |i| wanders(i, 1.7) - wanders(i, 1.0)));
    }
}
