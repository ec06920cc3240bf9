//! Two clocks: one channel comes from another recorder.

use super::hypothesis::{Hypothesis, listed};
use crate::case::{Change, Edit, Table};
use crate::count::count;

/// Offsets looked at, in sampling intervals, either way.
const FARTHEST: f64 = 60.0;
/// Rounds of refinement, each to a fifth of the one before: a thousandth of an interval.
const ROUNDS: usize = 5;
/// Steps on either side that are looked at in a round of refinement.
const REACH: i32 = 5;
/// Readings about a time from which the one at that time is worked out: with six, a signal of five
/// readings a period is known to a few hundredths of its height, with a straight line to a fifth.
const NODES: usize = 6;
/// Readings that an offset is judged by, at most, evenly over the record.
const MOST_READINGS: usize = 3000;
/// Share of the readings for which an offset must leave one to hold against them.
const OVERLAP: f64 = 0.5;
/// Parts of the readings by what they should read, and the share of the scatter between these parts
/// beyond which it follows the force, as a gain that changes with it does, and not the time.
const PARTS: usize = 10;
const FOLLOWS: f64 = 0.25;
/// Share of the misfit of a constant offset that another rate leaves at most.
const RATE_LEAVES: f64 = 0.7;
/// Parts of the record, or of each stretch, over which an offset may change.
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
/// Share of the slope that the steepest tenth exceeds, below which a record stands still: there,
/// residual over slope is noise over noise and drowns what the rest says.
const MOVES: f64 = 0.5;
/// Correlation of one residual over slope with the next, beyond which it is not jitter, unless it is less than the second
/// and so many readings on less than the third: a clock that wanders forgets, and what goes on along a ramp does not.
const MEMORY: f64 = 0.4;
const WANDERS: f64 = 0.85;
const FORGOTTEN: f64 = 0.15;
const FORGOTTEN_AFTER: usize = 10;

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

/// A course of time that is off by so much where it begins, and where it ends.
#[derive(Clone, Copy)]
struct Offset {
    first_s: f64,
    last_s: f64,
}

impl Offset {
    fn steady(offset_s: f64) -> Self {
        Self { first_s: offset_s, last_s: offset_s }
    }
}

/// When the course of time of each reading began: with the record, or anew with every stretch of it.
struct Course {
    began_s: Vec<f64>,
    /// The longest.
    span_s: f64,
    is_of_each_stretch: bool,
}

/// By how much a record is late all along, to half an interval of its sampling.
pub(crate) struct Late {
    interval_s: f64,
    offset_s: f64,
}

impl Late {
    /// Whether so many rows are no longer than a sound instrument reads late.
    pub(crate) fn may_be_latency(&self, rows: isize, latency_s: f64) -> bool {
        u32::try_from(rows)
            .is_ok_and(|rows| rows > 0 && f64::from(rows) * self.interval_s <= latency_s)
    }
}

/// The clock of a record late or early, running at another rate, or jittering.
pub(crate) fn clocks(
    record: &Record<'_>,
    &Late { interval_s, offset_s }: &Late,
) -> Vec<Hypothesis> {
    let whole = record.course(false);
    let constant = record.best(&whole, interval_s, Offset::steady(offset_s), true);
    let left = |course: &Course, offset| record.misfit(course, offset).unwrap_or(f64::INFINITY);
    let of_course = |course: &Course| {
        record.best(course, interval_s, record.best_line(course, interval_s), false)
    };
    let mut rate = of_course(&whole);
    let mut course = &whole;
    let each = record.is_parted().then(|| record.course(true));
    if let Some(each) = &each {
        let anew = of_course(each);
        if left(each, anew) < RATE_LEAVES * left(course, rate) {
            (rate, course) = (anew, each);
        }
    }
    let offset_s = constant.first_s;
    let name = listed(&[record.column]);
    let mut found = Vec::new();
    // No instrument reads ahead, and none is late for ever; what is late by less is physics.
    if !(0.0..=record.latency_s).contains(&offset_s) {
        let may_be_a_filter = (-record.latency_s..0.0).contains(&offset_s);
        let description = format!(
            "the clock of {name} in {} is {:.4} s {} that of the other channels (time offset): \
             move it by that{}",
            record.file,
            offset_s.abs(),
            if offset_s > 0.0 { "behind" } else { "ahead of" },
            if may_be_a_filter { ", unless a filter delays the others by as much" } else { "" }
        );
        let physics = may_be_a_filter.then_some("delay");
        let found_here = record.corrected(description, &whole, constant).unphysical();
        found.push(Hypothesis { physics, ..found_here });
    }
    if left(course, rate) < RATE_LEAVES * left(&whole, constant) {
        let slope = (rate.last_s - rate.first_s) / course.span_s;
        let first = if course.is_of_each_stretch {
            "where each stretch of the record begins"
        } else {
            "at first"
        };
        let description = format!(
            "the clock of {name} in {} runs at another rate than that of the other channels: its \
             time is off by {:.4} s {first} and {:.0} ppm",
            record.file,
            rate.first_s,
            1e6 * slope
        );
        found.push(record.corrected(description, course, rate));
    }
    found.extend(jitter(record, offset_s));
    found
}

impl Record<'_> {
    /// The offset that fits best; `None` where times do not run on.
    pub(crate) fn late(&self) -> Option<Late> {
        let interval_s = median_step(self)?;
        let whole = self.course(false);
        let mut best = (f64::INFINITY, 0.0);
        for k in offsets() {
            let offset_s = k * interval_s;
            let misfit = self.misfit(&whole, Offset::steady(offset_s)).unwrap_or(f64::INFINITY);
            // Of equal ones the nearest.
            if misfit < best.0 || misfit <= best.0 && offset_s.abs() < f64::abs(best.1) {
                best = (misfit, offset_s);
            }
        }
        Some(Late { interval_s, offset_s: best.1 })
    }

    /// Rows by which it may come late, negative where it is early: what it should have read may be made of
    /// channels of which some are late, and is known to a row or so. None of one stretch, where a column
    /// further down is a clock that is late.
    pub(crate) fn rows_late(&self, late: &Late) -> Vec<isize> {
        #[expect(clippy::cast_possible_truncation, reason = "at most as many as are looked at")]
        let rows = (late.offset_s / late.interval_s).round() as isize;
        let about = rows - 1..=rows + 1;
        about.filter(|next| self.is_parted() && rows != 0 && *next != 0).collect()
    }

    fn is_parted(&self) -> bool {
        self.stretch.last() > self.stretch.first()
    }

    fn course(&self, is_of_each_stretch: bool) -> Course {
        let mut began_s: Vec<f64> = Vec::with_capacity(self.time_s.len());
        for (i, time_s) in self.time_s.iter().enumerate() {
            let goes_on = i > 0 && !(is_of_each_stretch && self.stretch[i] != self.stretch[i - 1]);
            began_s.push(if goes_on { began_s[i - 1] } else { *time_s });
        }
        let passed_s = self.time_s.iter().zip(&began_s).map(|(time_s, began_s)| time_s - began_s);
        let span_s = passed_s.fold(f64::MIN_POSITIVE, f64::max);
        Course { began_s, span_s, is_of_each_stretch }
    }

    /// Share of the longest course that has passed at a reading.
    fn passed(&self, i: usize, course: &Course) -> f64 {
        (self.time_s[i] - course.began_s[i]) / course.span_s
    }

    fn offset_s(&self, i: usize, course: &Course, offset: Offset) -> f64 {
        offset.first_s + self.passed(i, course) * (offset.last_s - offset.first_s)
    }

    /// The record on the clock of the other channels; readings that it then does not have are left
    /// out.
    fn corrected(&self, description: String, course: &Course, offset: Offset) -> Hypothesis {
        let moved = |i| self.at(self.read, i, self.offset_s(i, course, offset));
        let all: Vec<Option<f64>> = (0..self.read.len()).map(moved).collect();
        let values = all.iter().zip(self.read).map(|(moved, read)| moved.unwrap_or(*read));
        let replace = Change::Replace { column: self.column.to_owned(), values: values.collect() };
        let rows = (0..all.len()).filter(|&i| all[i].is_some()).collect();
        let edits = [replace, Change::Keep { rows }];
        let edits = edits.map(|change| Edit { file: self.file, change }).to_vec();
        Hypothesis::of("input:clock", (self.file, &[self.column]), description, edits)
    }

    /// One of two courses this much later than at reading `i`, by a polynomial through the readings
    /// about that time; `None` beyond the ends of a stretch.
    fn at(&self, values: &[f64], i: usize, offset_s: f64) -> Option<f64> {
        let at = self.time_s[i] + offset_s;
        let (mut first, mut last) = (i, i);
        let same = |j: usize| self.stretch[j] == self.stretch[i];
        while last + 1 < values.len() && same(last + 1) && self.time_s[last] < at {
            last += 1;
        }
        while first > 0 && same(first - 1) && self.time_s[first] > at {
            first -= 1;
        }
        if self.time_s[first] > at || self.time_s[last] < at {
            return None;
        }
        // The reading before that time or at it, and as many on either side.
        let mut middle = if offset_s < 0.0 { first } else { last };
        while middle > 0 && same(middle - 1) && self.time_s[middle] > at {
            middle -= 1;
        }
        let (mut low, mut high) = (middle, middle);
        while high - low + 1 < NODES {
            let down = low > 0 && same(low - 1);
            let up = high + 1 < values.len() && same(high + 1);
            match (down, up) {
                (true, true) if middle - low < high - middle => low -= 1,
                (_, true) => high += 1,
                (true, false) => low -= 1,
                (false, false) => break,
            }
        }
        let weight = |j: usize| -> f64 {
            let factor = |k: usize| (at - self.time_s[k]) / (self.time_s[j] - self.time_s[k]);
            (low..=high).filter(|k| *k != j).map(factor).product()
        };
        let value: f64 = (low..=high).map(|j| weight(j) * values[j]).sum();
        value.is_finite().then_some(value)
    }

    /// Mean distance of the moved record from what it should have read, over the readings that it
    /// has; `None` where these are few.
    fn misfit(&self, course: &Course, offset: Offset) -> Option<f64> {
        let off = |i: usize| {
            let moved = self.at(self.read, i, self.offset_s(i, course, offset))?;
            Some((moved - self.expected[i]).abs())
        };
        let looked_at = self.looked_at(0..self.read.len());
        let all = looked_at.len();
        let (mut sum, mut n) = (0.0, 0);
        for distance in looked_at.filter_map(off) {
            sum += distance;
            n += 1;
        }
        (count(n) >= OVERLAP * count(all)).then(|| sum / count(n))
    }

    /// Some of the rows by which offsets are judged.
    fn looked_at(&self, rows: std::ops::Range<usize>) -> std::iter::StepBy<std::ops::Range<usize>> {
        rows.step_by(self.read.len().div_ceil(MOST_READINGS))
    }

    /// The straight course of the offset that fits best, from the misfit of every stretch of the
    /// record under every offset.
    fn best_line(&self, course: &Course, interval_s: f64) -> Offset {
        let n = self.read.len();
        let mut parts: Vec<Vec<usize>> = vec![Vec::new(); STRETCHES];
        for row in self.looked_at(0..n) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of the stretches"
            )]
            let part = (self.passed(row, course) * count(STRETCHES)) as usize;
            parts[part.min(STRETCHES - 1)].push(row);
        }
        let of_part = |rows: &Vec<usize>| {
            let of_offset = |k: f64| {
                let off = |i: usize| {
                    Some((self.at(self.read, i, k * interval_s)? - self.expected[i]).abs())
                };
                let off = rows.iter().filter_map(|row| off(*row));
                off.fold((0.0, 0.0), |(s, n), d| (s + d, n + 1.0))
            };
            offsets().map(of_offset).collect()
        };
        let table: Vec<Vec<(f64, f64)>> = parts.iter().map(of_part).collect();
        let all: Vec<f64> = offsets().collect();
        let middle = |part: usize| count(2 * part + 1) / count(2 * STRETCHES);
        let middles: Vec<f64> = (0..STRETCHES).map(middle).collect();
        let judged = count(self.looked_at(0..n).len());
        let mut best = (f64::INFINITY, Offset { first_s: 0.0, last_s: 0.0 });
        for &first in &all {
            for &last in &all {
                let (mut sum, mut seen) = (0.0, 0.0);
                for (row, passed) in table.iter().zip(&middles) {
                    let k = first + passed * (last - first);
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "between the offsets that are looked at"
                    )]
                    let (s, m) = row[((k - all[0]) / (all[1] - all[0])).round() as usize];
                    (sum, seen) = (sum + s, seen + m);
                }
                if seen >= OVERLAP * judged && sum / seen < best.0 {
                    let [first_s, last_s] = [first, last].map(|k| k * interval_s);
                    best = (sum / seen, Offset { first_s, last_s });
                }
            }
        }
        best.1
    }

    /// A course of the offset refined, with both ends alike where it is constant.
    fn best(&self, course: &Course, interval_s: f64, start: Offset, is_constant: bool) -> Offset {
        let mut best = (self.misfit(course, start).unwrap_or(f64::INFINITY), start);
        let mut step_s = 0.5 * interval_s;
        for _ in 0..ROUNDS {
            let center = best.1;
            for first in -REACH..=REACH {
                let others = if is_constant { first..=first } else { -REACH..=REACH };
                for last in others {
                    let first_s = center.first_s + f64::from(first) * step_s / f64::from(REACH);
                    let last_s = center.last_s + f64::from(last) * step_s / f64::from(REACH);
                    let offset = Offset { first_s, last_s };
                    if let Some(less) = self.misfit(course, offset).filter(|m| *m < best.0) {
                        best = (less, offset);
                    }
                }
            }
            step_s /= f64::from(REACH);
        }
        best.1
    }
}

/// Offsets that are looked at first, in intervals.
fn offsets() -> impl Iterator<Item = f64> {
    let mut next = -FARTHEST;
    std::iter::from_fn(move || {
        let this = next;
        next += 0.5;
        (this <= FARTHEST).then_some(this)
    })
}

fn median_step(record: &Record<'_>) -> Option<f64> {
    let mut steps: Vec<f64> = (1..record.time_s.len())
        .filter(|&i| record.stretch[i] == record.stretch[i - 1])
        .map(|i| record.time_s[i] - record.time_s[i - 1])
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0)
}

/// Readings that scatter where the signal is steep, and nowhere else: each was taken at a time of
/// its own.
fn jitter(record: &Record<'_>, offset_s: f64) -> Option<Hypothesis> {
    // What it should have read is moved: between two of its own readings jitter would be averaged.
    let expected: Vec<Option<f64>> =
        (0..record.read.len()).map(|i| record.at(record.expected, i, -offset_s)).collect();
    let inner = (1..record.read.len().saturating_sub(1))
        .filter(|&i| record.stretch[i - 1] == record.stretch[i + 1]);
    let mut seen: Vec<(usize, f64, (f64, f64))> = inner
        .filter_map(|i| {
            let [before, at, after] = [expected[i - 1]?, expected[i]?, expected[i + 1]?];
            let slope = (after - before) / (record.time_s[i + 1] - record.time_s[i - 1]);
            Some((record.stretch[i], at, (slope, record.read[i] - at)))
        })
        .collect();
    // What a whole stretch is off by was not read at other times.
    for stretch in seen.chunk_by_mut(|a, b| a.0 == b.0) {
        let mean = stretch.iter().map(|(_, _, (_, r))| r).sum::<f64>() / count(stretch.len());
        for (_, _, (_, r)) in stretch {
            *r -= mean;
        }
    }
    let (forces, mut pairs): (Vec<f64>, Vec<(f64, f64)>) =
        seen.into_iter().map(|(_, force, pair)| (force, pair)).unzip();
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
    let wanders = along(1) < WANDERS && along(FORGOTTEN_AFTER).abs() < FORGOTTEN;
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
