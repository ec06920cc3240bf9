//! Two clocks: one channel comes from another recorder.

use super::hypothesis::{Hypothesis, listed};
use super::jitter::jitter;
use super::median;
use super::record::Record;
use crate::case::{Change, Edit, Table};
use crate::count::count;

/// Offsets looked at, in sampling intervals, either way.
const FARTHEST: f64 = 60.0;
/// Rounds of refinement, each to a fifth of the one before: a thousandth of an interval.
const ROUNDS: usize = 5;
/// Steps on either side that are looked at in a round of refinement.
const REACH: i32 = 5;
/// Readings that an offset is judged by, at most, evenly over the record.
const MOST_READINGS: usize = 3000;
/// Share of the readings for which an offset must leave one to hold against them.
const OVERLAP: f64 = 0.5;
/// Share of the misfit of a constant offset that another rate leaves at most.
const RATE_LEAVES: f64 = 0.7;
/// Times the misfit of a constant offset that an error of either sign, by the way the record goes, leaves where it is as
/// good: of loads that go up and down in equal steps nobody can say which it is.
const AS_WELL: f64 = 1.1;
/// Parts of the record, or of each stretch, over which an offset may change.
const STRETCHES: usize = 12;
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
        let may_be_a_reversal = record.left_of_a_reversal() <= AS_WELL * left(&whole, constant);
        let (unless, physics) = if may_be_a_reversal {
            let of_the_way = "; or as likely one of the two reads otherwise while the load rises than while it falls \
                              (a reversal, hysteresis)";
            (of_the_way, Some("reversal [by the way of the load]"))
        } else if may_be_a_filter {
            (", unless a filter delays the others by as much", Some("delay"))
        } else {
            ("", None)
        };
        let description = format!(
            "the clock of {name} in {} is {:.4} s {} that of the other channels (time offset): \
             move it by that{unless}",
            record.file,
            offset_s.abs(),
            if offset_s > 0.0 { "behind" } else { "ahead of" },
        );
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
        let interval_s = self.interval_s()?;
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

    /// The same where it reads so much more while it rises, and as much less while it falls, as fits best.
    fn left_of_a_reversal(&self) -> f64 {
        let goes_on = |i: usize| i > 0 && self.stretch[i] == self.stretch[i - 1];
        let way = |i: usize| {
            let from = if goes_on(i) { i - 1 } else { i };
            let to = if goes_on(i + 1) { i + 1 } else { i };
            self.expected[to] - self.expected[from]
        };
        let last = self.read.len().saturating_sub(1);
        let along: Vec<f64> = (self.looked_at(0..last))
            .filter(|i| way(*i) != 0.0)
            .map(|i| way(i).signum() * (self.expected[i] - self.read[i]))
            .collect();
        let middle = median(along.clone());
        along.iter().map(|off| (off - middle).abs()).sum::<f64>() / count(along.len().max(1))
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
