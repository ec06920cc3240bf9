//! A clock that jitters: each reading was taken at a time of its own.

use super::hypothesis::{Hypothesis, listed};
use super::record::Record;
use crate::count::count;

/// Parts of the readings by what they should read, and the share of the scatter between these parts
/// beyond which it follows the force, as a gain that changes with it does, and not the time.
const PARTS: usize = 10;
const FOLLOWS: f64 = 0.25;
/// Residual where the signal is steep over that where it is flat: there, jitter is then three
/// quarters of the variance.
const STEEP: f64 = 2.0;
/// The same of the median sizes: of a few readings far off the root mean square alone says as much.
/// In tenths of forty readings the logarithm of the ratio of medians has a standard deviation of
/// √(2·1.36/40) = 0.26: chance goes so far once in thirty times, and not together with the other.
const STEEP_IN_THE_MIDDLE: f64 = 1.6;
/// The same in standard deviations of the logarithm of a ratio of variances, of noise alone.
const STEEP_SIGMAS: f64 = 6.0;
/// Readings in a tenth of a record from which jitter can be told: their scatter is known to a
/// quarter.
const FEWEST: usize = 8;
/// Share of the slope that the steepest tenth exceeds, below which a record stands still: there,
/// residual over slope is noise over noise and drowns what the rest says.
const MOVES: f64 = 0.5;
/// Correlation of one residual over slope with the next, beyond which it is not jitter, unless it is less than the second
/// and so many readings on less than the third: a clock that wanders forgets, and what goes on along a ramp does not.
const MEMORY: f64 = 0.4;
const WANDERS: f64 = 0.85;
const FORGOTTEN: f64 = 0.15;
const FORGOTTEN_AFTER: usize = 10;

/// Jitter that is tried where it is longer than from one reading to the next, in intervals, and how many times of it are looked
/// at either way.
const LONGER: [f64; 8] = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
const EITHER_WAY: f64 = 3.0;
/// Logarithm of the ratio of the squares that such a jitter makes and those that are there, at most: half as much again.
const EXPLAINED: f64 = 0.4;

/// A reading, what it should have been, and by what that changes.
#[derive(Clone, Copy)]
struct Seen {
    row: usize,
    stretch: usize,
    expected: f64,
    slope: f64,
    residual: f64,
}

/// Readings that scatter where the signal is steep, and nowhere else: each was taken at a time of
/// its own. Where that is farther off than the next reading, they scatter as what lies about them does.
pub(super) fn jitter(record: &Record<'_>, offset_s: f64) -> Option<Hypothesis> {
    // What it should have read is moved: between two of its own readings jitter would be averaged.
    let expected: Vec<Option<f64>> =
        (0..record.read.len()).map(|i| record.at(record.expected, i, -offset_s)).collect();
    let inner = (1..record.read.len().saturating_sub(1))
        .filter(|&i| record.stretch[i - 1] == record.stretch[i + 1]);
    let seen: Vec<Seen> = inner
        .filter_map(|row| {
            let [before, at, after] = [expected[row - 1]?, expected[row]?, expected[row + 1]?];
            let slope = (after - before) / (record.time_s[row + 1] - record.time_s[row - 1]);
            let residual = record.read[row] - at;
            Some(Seen { row, stretch: record.stretch[row], expected: at, slope, residual })
        })
        .collect();
    told(record, seen.clone(), true)
        .or_else(|| told(record, by_what_lies_about(record, &expected, &seen)?, false))
}

/// The same with what lies about each within the jitter that explains the most: its standard deviation for the slope, over the
/// jitter, and the residual beside its mean.
fn by_what_lies_about(
    record: &Record<'_>,
    expected: &[Option<f64>],
    seen: &[Seen],
) -> Option<Vec<Seen>> {
    let interval_s = record.interval_s()?;
    let mut best: Option<(f64, Vec<Seen>)> = None;
    for times in LONGER {
        let jitter_s = times * interval_s;
        let all = seen.iter().map(|seen| about(record, expected, seen, jitter_s));
        let all: Vec<Seen> = all.collect();
        let ratio = squares(&all, |seen| seen.residual)
            / (squares(&all, |seen| seen.slope) * jitter_s.powi(2));
        let off = ratio.ln().abs();
        if best.as_ref().is_none_or(|(known, _)| off < *known) {
            best = Some((off, all));
        }
        // A longer one makes more yet.
        if ratio < 1.0 {
            break;
        }
    }
    let (off, all) = best?;
    // The mean of what lies about each is a part of what it is off by, then.
    let [beside, whole] = [&all[..], seen].map(|seen| squares(seen, |seen| seen.residual));
    (off <= EXPLAINED && beside <= whole).then_some(all)
}

fn squares(seen: &[Seen], of: fn(&Seen) -> f64) -> f64 {
    seen.iter().map(|seen| of(seen).powi(2)).sum()
}

fn about(record: &Record<'_>, expected: &[Option<f64>], seen: &Seen, jitter_s: f64) -> Seen {
    let away_s = |row: usize| record.time_s[row] - record.time_s[seen.row];
    let is_about = |row: &usize| {
        record.stretch[*row] == seen.stretch && away_s(*row).abs() <= EITHER_WAY * jitter_s
    };
    let before = (0..seen.row).rev().take_while(is_about);
    let after = (seen.row..expected.len()).take_while(is_about);
    let weighed = before.chain(after).filter_map(|row| {
        let weight = (-0.5 * (away_s(row) / jitter_s).powi(2)).exp();
        Some((weight, expected[row]? - seen.expected))
    });
    let [all, mean, square] = weighed.fold([0.0; 3], |[all, mean, square], (weight, change)| {
        [all + weight, mean + weight * change, square + weight * change * change]
    });
    let mean = mean / all;
    let scatter = (square / all - mean * mean).max(0.0).sqrt();
    let slope = (scatter / jitter_s).copysign(seen.slope);
    Seen { slope, residual: seen.residual - mean, ..*seen }
}

/// Whether it is jitter; a clock that wanders is, where that may be.
fn told(record: &Record<'_>, mut seen: Vec<Seen>, may_wander: bool) -> Option<Hypothesis> {
    // What a whole stretch is off by was not read at other times.
    for stretch in seen.chunk_by_mut(|a, b| a.stretch == b.stretch) {
        let mean = stretch.iter().map(|seen| seen.residual).sum::<f64>() / count(stretch.len());
        for seen in stretch {
            seen.residual -= mean;
        }
    }
    let (forces, mut pairs): (Vec<f64>, Vec<(f64, f64)>) =
        seen.into_iter().map(|seen| (seen.expected, (seen.slope, seen.residual))).unzip();
    if follows(forces, &pairs) > FOLLOWS {
        return None;
    }
    let tenth = pairs.len() / 10;
    if tenth < FEWEST {
        return None;
    }
    let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
    let rest_s = sum(|(slope, r)| slope * r) / sum(|(slope, _)| slope * slope);
    for (slope, r) in &mut pairs {
        *r -= rest_s * *slope;
    }
    let steep = steep(&pairs);
    let late: Vec<f64> = steep.iter().map(|(slope, r)| r / slope).collect();
    let square: f64 = late.iter().map(|l| l * l).sum();
    let along = |by: usize| {
        late.iter().zip(late.iter().skip(by)).map(|(one, other)| one * other).sum::<f64>() / square
    };
    let wanders = may_wander && along(1) < WANDERS && along(FORGOTTEN_AFTER).abs() < FORGOTTEN;
    let goes_on = along(1) > MEMORY && !wanders;
    let jitter_s = (square / count(late.len())).sqrt();
    pairs.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let rms = |part: &[(f64, f64)]| {
        (part.iter().map(|(_, r)| r * r).sum::<f64>() / count(part.len())).sqrt()
    };
    let median = |part: &[(f64, f64)]| {
        let mut sizes: Vec<f64> = part.iter().map(|(_, r)| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes[sizes.len() / 2]
    };
    let (flat, steepest) = (&pairs[..tenth], &pairs[pairs.len() - tenth..]);
    if median(steepest) < STEEP_IN_THE_MIDDLE * median(flat) {
        return None;
    }
    let ratio = rms(steepest) / rms(flat);
    // A variance of n readings has a logarithm of variance 2/n.
    let by_chance = STEEP_SIGMAS * (4.0 / count(tenth)).sqrt();
    if ratio < STEEP || 2.0 * ratio.ln() < by_chance || goes_on {
        return None;
    }
    let description = format!(
        "the clock of {} in {} jitters: its readings miss by what the signal changes in {jitter_s:.4} s \
         rms, either way, and only where it changes; record both on one clock (time base)",
        listed(&[record.column]),
        record.file
    );
    let subject = (record.file, &[record.column][..]);
    Some(Hypothesis::of("input:clock", subject, description, Vec::new()).shown())
}

/// Pairs of slope and residual where the signal is steep, in the order of time: the steeper half, and
/// of a record that mostly stands still only where it moves.
fn steep(pairs: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sizes: Vec<f64> = pairs.iter().map(|(slope, _)| slope.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let steepest = sizes[sizes.len() - sizes.len() / 10];
    let least = sizes[sizes.len() / 2].max(MOVES * steepest);
    pairs.iter().copied().filter(|(slope, _)| slope.abs() > least).collect()
}

/// Share of the scatter of residuals that lies between parts of the readings, by their force.
fn follows(forces: Vec<f64>, pairs: &[(f64, f64)]) -> f64 {
    let mut sorted: Vec<(f64, f64)> =
        forces.into_iter().zip(pairs).map(|(force, (_, r))| (force, *r)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let n = count(sorted.len());
    let sum = |part: &[(f64, f64)]| part.iter().map(|(_, r)| r).sum::<f64>();
    let mean = sum(&sorted) / n;
    let whole: f64 = sorted.iter().map(|(_, r)| (r - mean).powi(2)).sum();
    let between = sorted.chunks(sorted.len().div_ceil(PARTS).max(1));
    let between =
        between.map(|part| (sum(part) / count(part.len()) - mean).powi(2) * count(part.len()));
    between.sum::<f64>() / whole
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of a stretch, and between two of them, s.
    const EACH: usize = 40;
    const STEP_S: f64 = 0.025;
    /// Stretches; every fourth is a ramp, the others stand still.
    const MANY: usize = 20;
    /// Load of those that stand still, and at the end of a ramp.
    const LOAD_N: f64 = 40.0;
    const NOISE_N: f64 = 0.1;

    /// Even numbers between −1 and 1 without order.
    fn even(i: usize) -> f64 {
        2.0 * (0.618_034 * count(i) * count(i % 97 + 3)).fract() - 1.0
    }

    /// Jitter found in a log that mostly stands still, whose readings are off by `error_n` of slope
    /// in N/s, number of the ramp, and way along it.
    fn found(error_n: impl Fn(f64, usize, f64) -> f64) -> Option<String> {
        let way = |i: usize| count(i % EACH) / count(EACH);
        let is_ramp = |i: usize| (i / EACH).is_multiple_of(4);
        let clean = |i: usize| if is_ramp(i) { LOAD_N * way(i) } else { LOAD_N };
        let slope = LOAD_N / (STEP_S * count(EACH));
        let off = |i: usize| if is_ramp(i) { error_n(slope, i / EACH / 4, way(i)) } else { 0.0 };
        found_in(clean, off)
    }

    /// Jitter found in readings of a force that are off.
    fn found_in(clean: impl Fn(usize) -> f64, off: impl Fn(usize) -> f64) -> Option<String> {
        let n = MANY * EACH;
        let time_s: Vec<f64> = (0..n).map(|i| STEP_S * count(i)).collect();
        let expected: Vec<f64> = (0..n).map(|i| clean(i) + NOISE_N * even(i)).collect();
        let read: Vec<f64> = (0..n).map(|i| clean(i) + off(i) + NOISE_N * even(i + n)).collect();
        let stretch: Vec<usize> = (0..n).map(|i| i / EACH).collect();
        let record = Record {
            file: "log.csv",
            column: "reference_n",
            time_s: &time_s,
            read: &read,
            expected: &expected,
            stretch: &stretch,
            latency_s: 0.1,
        };
        jitter(&record, 0.0).map(|hypothesis| hypothesis.description)
    }

    /// A force that stands still, and goes down and up again, read up to ten readings earlier or later.
    #[test]
    fn readings_that_change_their_order_are_jitter() {
        let force = |at: f64| {
            let way = (at.rem_euclid(count(EACH)) - 10.0) / 20.0;
            let down = (std::f64::consts::PI * way.clamp(0.0, 1.0)).sin();
            LOAD_N * (1.0 - 0.8 * down)
        };
        let off = |i: usize| force(count(i) + 10.0 * even(i * 7 + 3)) - force(count(i));
        assert!(found_in(|i| force(count(i)), off).is_some());
    }

    #[test]
    fn an_error_that_goes_on_along_a_ramp_is_no_jitter() {
        let sign = |ramp: usize| if ramp.is_multiple_of(2) { 2.0 } else { -2.0 };
        let slow = |_, ramp, way: f64| sign(ramp) * (std::f64::consts::PI * way).sin();
        assert_eq!(found(slow), None);
    }

    #[test]
    fn stretches_that_are_off_are_no_jitter() {
        // To and fro in ten readings, about many loads; by more in two stretches, which are off.
        let is_off = |i: usize| i / EACH % 10 == 3;
        let clean = |i: usize| {
            let ripple = (std::f64::consts::TAU * count(i) / 10.0).sin();
            let load_n = 10.0 * count(i / EACH % 7);
            if is_off(i) { LOAD_N + 12.0 * ripple } else { load_n + 4.0 * ripple }
        };
        assert_eq!(found_in(clean, |i| if is_off(i) { 1.5 } else { 0.0 }), None);
        let at_random = |i: usize| if is_off(i) { 3.0 * even(i + 7) } else { 0.0 };
        assert!(found_in(clean, at_random).is_some());
    }

    #[test]
    fn a_clock_that_wanders_within_some_readings_is_jitter() {
        // As late for three readings in a row.
        let late_s = |i: usize| 0.06 * even(7919 * (i / 3));
        let at = |ramp: usize, way: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 40")]
            let reading = (way * count(EACH)).round() as usize;
            1000 * ramp + reading
        };
        let found = found(|slope, ramp, way| slope * late_s(at(ramp, way)));
        assert!(found.is_some_and(|words| words.contains("jitters")));
    }

    #[test]
    fn readings_at_times_of_their_own_are_jitter() {
        let late_s = |ramp: usize, way: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 40")]
            let reading = (way * count(EACH)).round() as usize;
            0.06 * even(1000 * ramp + reading)
        };
        let found = found(|slope, ramp, way| slope * late_s(ramp, way));
        assert!(found.is_some_and(|words| words.contains("jitters")));
    }
}
