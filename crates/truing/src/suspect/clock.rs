//! Two clocks: one channel comes from another recorder.

use super::hypothesis::{Hypothesis, listed};
use crate::case::{Change, Edit, Table};

/// Offsets looked at, in sampling intervals, either way.
const FARTHEST: f64 = 60.0;
/// Rounds of refinement, each to a fifth of the one before: a thousandth of an interval.
const ROUNDS: usize = 5;
/// Stretches of the record over which an offset may change.
const STRETCHES: usize = 12;
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
/// Correlation of one residual over slope with the next, beyond which it is not jitter.
const MEMORY: f64 = 0.4;

/// A record on another clock: its column, its time, what it should have read, and the stretches
/// within which time runs on.
pub(crate) struct Record<'t> {
    pub(crate) file: &'static str,
    pub(crate) column: &'static str,
    pub(crate) time_s: &'t [f64],
    pub(crate) read: &'t [f64],
    pub(crate) expected: &'t [f64],
    /// One per reading.
    pub(crate) stretch: &'t [usize],
    /// Longest time by which a sound instrument reads late.
    pub(crate) latency_s: f64,
}

/// The clock of a record late or early, running at another rate, or jittering.
pub(crate) fn clocks(record: &Record<'_>) -> Vec<Hypothesis> {
    let Some(interval_s) = median_step(record) else { return Vec::new() };
    let all: Vec<usize> = (0..record.read.len()).collect();
    let mut found = Vec::new();
    let offset_s = best_offset(record, &all, interval_s);
    let chunk = record.read.len().div_ceil(STRETCHES).max(1);
    let parts: Vec<(f64, f64)> = all
        .chunks(chunk)
        .map(|rows| (record.time_s[rows[rows.len() / 2]], best_offset(record, rows, interval_s)))
        .collect();
    let (at_zero_s, rate) = line(&parts);
    let subject = (record.file, &[record.column][..]);
    let name = listed(&[record.column]);
    let of = |description: String, offset: &dyn Fn(f64) -> f64| {
        let values = (0..record.read.len()).map(|i| moved(record, i, offset(record.time_s[i])));
        let change = Change::Replace { column: record.column.to_owned(), values: values.collect() };
        let edits = vec![Edit { file: record.file, change }];
        Hypothesis::of("input:clock", subject, description, edits)
    };
    let constant = of(
        format!(
            "the clock of {name} in {} is {:.4} s {} that of the other channels (time offset): \
             move it by that",
            record.file,
            offset_s.abs(),
            if offset_s > 0.0 { "behind" } else { "ahead of" }
        ),
        &|_| offset_s,
    );
    // No instrument reads ahead, and none is late for ever.
    let is_delay = (0.0..=record.latency_s).contains(&offset_s);
    found.push(if is_delay { constant } else { constant.unphysical() });
    found.push(of(
        format!(
            "the clock of {name} in {} runs at another rate than that of the other channels: its \
             time is off by {at_zero_s:.4} s and {:.0} ppm",
            record.file,
            1e6 * rate
        ),
        &|t| at_zero_s + rate * t,
    ));
    found.extend(jitter(record, interval_s, offset_s));
    found
}

fn median_step(record: &Record<'_>) -> Option<f64> {
    let mut steps: Vec<f64> = (1..record.time_s.len())
        .filter(|&i| record.stretch[i] == record.stretch[i - 1])
        .map(|i| record.time_s[i] - record.time_s[i - 1])
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0)
}

/// What the record read `offset_s` later, on a straight line between its readings; at the ends of
/// a stretch its last reading.
fn moved(record: &Record<'_>, i: usize, offset_s: f64) -> f64 {
    let at = record.time_s[i] + offset_s;
    let same = |j: usize| record.stretch[j] == record.stretch[i];
    let mut j = i;
    while j + 1 < record.read.len() && same(j + 1) && record.time_s[j + 1] <= at {
        j += 1;
    }
    while j > 0 && same(j - 1) && record.time_s[j] > at {
        j -= 1;
    }
    let next = j + 1;
    if record.time_s[j] > at || next >= record.read.len() || !same(next) {
        return record.read[j];
    }
    let share = (at - record.time_s[j]) / (record.time_s[next] - record.time_s[j]);
    record.read[j] + share * (record.read[next] - record.read[j])
}

/// The offset with which the rows agree best with what they should have read.
fn best_offset(record: &Record<'_>, rows: &[usize], interval_s: f64) -> f64 {
    let misfit = |offset_s: f64| -> f64 {
        rows.iter().map(|&i| (moved(record, i, offset_s) - record.expected[i]).abs()).sum()
    };
    let (mut center, mut step) = (0.0, interval_s);
    let mut reach = FARTHEST;
    for _ in 0..ROUNDS {
        let mut best = (misfit(center), center);
        let mut k = -reach;
        while k <= reach {
            let offset = center + k * step;
            let value = misfit(offset);
            if value < best.0 {
                best = (value, offset);
            }
            k += 1.0;
        }
        center = best.1;
        step /= 5.0;
        reach = 5.0;
    }
    center
}

/// Straight line through points: value at zero, and slope.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = count(points.len());
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let sxy: f64 = points.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    let sxx: f64 = points.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    let slope = if sxx > 0.0 { sxy / sxx } else { 0.0 };
    (my - slope * mx, slope)
}

/// Readings that scatter where the signal is steep, and nowhere else: each was taken at a time of
/// its own.
fn jitter(record: &Record<'_>, interval_s: f64, offset_s: f64) -> Option<Hypothesis> {
    // By whole intervals: between two readings their jitter would be averaged.
    let whole_s = (offset_s / interval_s).round() * interval_s;
    let inner = (1..record.read.len().saturating_sub(1))
        .filter(|&i| record.stretch[i - 1] == record.stretch[i + 1]);
    let mut pairs: Vec<(f64, f64)> = inner
        .map(|i| {
            let slope = (record.expected[i + 1] - record.expected[i - 1])
                / (record.time_s[i + 1] - record.time_s[i - 1]);
            (slope, moved(record, i, whole_s) - record.expected[i])
        })
        .collect();
    let tenth = pairs.len() / 10;
    if tenth < FEWEST {
        return None;
    }
    let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
    let rest_s = sum(|(slope, r)| slope * r) / sum(|(slope, _)| slope * slope);
    for (slope, r) in &mut pairs {
        *r -= rest_s * *slope;
    }
    let steep: Vec<(f64, f64)> = {
        let mut sizes: Vec<f64> = pairs.iter().map(|(slope, _)| slope.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let half = sizes[sizes.len() / 2];
        pairs.iter().copied().filter(|(slope, _)| slope.abs() > half).collect()
    };
    let late: Vec<f64> = steep.iter().map(|(slope, r)| r / slope).collect();
    let square: f64 = late.iter().map(|l| l * l).sum();
    let next: f64 = late.windows(2).map(|pair| pair[0] * pair[1]).sum();
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
    if ratio < STEEP || 2.0 * ratio.ln() < by_chance || next / square > MEMORY {
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

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}

/// Which stretch each row of a table is in, by the names in a column.
pub(crate) fn stretches(table: &Table, column: &str) -> Vec<usize> {
    let column = table.column(column);
    let mut stretch = 0;
    let of_row = |row: usize| {
        let is_next =
            row == 0 || column.is_none_or(|c| table.cell(row, c) == table.cell(row - 1, c));
        stretch += usize::from(!is_next);
        stretch
    };
    (0..table.n_rows()).map(of_row).collect()
}
