//! Mistakes in deviations that the repeats at one target show: of one alone any would fit that makes it small.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::approach::derived;
use super::directions::said_ways;
use super::places::Places;
use super::rearranged::Rows;
use crate::case::{Change, Edit, Table};
use crate::count::{count, rms};
use crate::suspect::{Hypothesis, rows_left_out};

/// Readings one after the other that are the same to the last digit.
const FEWEST_STILL: usize = 6;
/// Standard deviations by which the repeats elsewhere are off a reading that stands still.
const APART: f64 = 10.0;
/// Times less that the repeats scatter where some cycles are counted the other way.
const TURNED: f64 = 3.0;
/// A finer unit that deviations may be in under the name of a coarser one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finer {
    /// Column that is said to be in the coarser one.
    pub(super) column: &'static str,
    said: &'static str,
    /// One of the finer unit in the column's.
    factor: f64,
    /// No axis comes back to a place as badly, in the column's unit: where the noise is declared that much too small, it does
    /// not look so.
    no_axis: f64,
}

/// Those that happen: µm for mm, seconds of arc for degrees.
pub(super) const FINER: [Finer; 2] = [
    Finer { column: "deviation_mm", said: "µm instead of mm", factor: 1e-3, no_axis: 0.02 },
    Finer {
        column: "deviation_deg",
        said: "seconds of arc instead of degrees",
        factor: 1.0 / 3600.0,
        no_axis: 0.05,
    },
];
/// Times the declared noise by which deviations scatter that are in a finer unit, over how many of it make the coarser one: as
/// well as the noise was known.
const AS_WELL_KNOWN: [f64; 2] = [0.25, 4.0];

/// Rows of each cycle.
type Cycles<'t> = BTreeMap<&'t str, Vec<usize>>;

/// Deviations with their place, a target come to from one side.
pub(super) struct Repeats {
    file: &'static str,
    read: &'static str,
    targets: Vec<f64>,
    values: Vec<f64>,
    places: Places,
}

impl Repeats {
    /// `None` where a number or direction is none.
    pub(super) fn of(
        (file, table): (&'static str, &Table),
        [target, read]: [&'static str; 2],
    ) -> Option<Self> {
        let targets = table.numbers(target)?;
        let said = said_ways(table).or_else(|| derived(&targets).into_iter().collect())?;
        let places = Places::of(&targets, &said);
        Some(Self { file, read, values: table.numbers(read)?, targets, places })
    }

    /// What the repeats say of the rows; `sigma` in the unit that the column says.
    pub(super) fn rows<'t>(&'t self, table: &'t Table, sigma: Option<f64>) -> Rows<'t> {
        let Self { file, read, targets, values, places } = self;
        Rows { file, table, read, values, targets, places, sigma }
    }

    /// A reading that stands still while the axis goes on, at places where all others are elsewhere.
    pub(super) fn standing_still(&self, table: &Table) -> Option<Hypothesis> {
        let rows: Vec<usize> = (0..self.values.len()).collect();
        let is_same = |a: &usize, b: &usize| self.values[*a].total_cmp(&self.values[*b]).is_eq();
        let run = rows.chunk_by(is_same).max_by_key(|run| run.len())?;
        let is_out = |row: usize| !run.contains(&row);
        let noise = self.places.scatter(&self.values, is_out)?;
        let means = self.places.means(&self.values, is_out);
        let mean = |row: &usize| means[self.places.of_row(*row)].map(|mean| mean.value);
        let known: Vec<f64> = run.iter().filter_map(mean).collect();
        let held = self.values[run[0]];
        let is_apart = rms(known.iter().map(|mean| mean - held)) > APART * noise;
        if known.len() < FEWEST_STILL || !is_apart {
            return None;
        }
        let description = format!(
            "the channel `{}` of {} is stuck: it reads {held} in {} rows one after the other, from line {}, while \
             the axis goes on, and otherwise in the other cycles there; repair the channel, or leave these rows out",
            self.read,
            self.file,
            run.len(),
            table.line(run[0])
        );
        let marked: Vec<bool> = rows.iter().map(|row| run.contains(row)).collect();
        let edits = vec![rows_left_out(self.file, &marked)];
        Some(Hypothesis::of("input:stuck", (self.file, &[self.read]), description, edits).certain())
    }

    /// Whole cycles that repeat the others with the opposite sign.
    pub(super) fn turned_cycles(&self, table: &Table) -> Option<Hypothesis> {
        let column = table.column("cycle")?;
        let mut cycles: Cycles<'_> = BTreeMap::new();
        for row in 0..self.values.len() {
            cycles.entry(table.cell(row, column)).or_default().push(row);
        }
        let names = self.opposed(&cycles).filter(|names| !names.is_empty())?;
        let mut rows: Vec<usize> = names.iter().flat_map(|name| cycles[name].clone()).collect();
        rows.sort_unstable();
        let mut values = self.values.clone();
        for row in &rows {
            values[*row] *= -1.0;
        }
        let falls = |of: &dyn Fn(&[f64]) -> Vec<f64>| {
            let [before, after] =
                [&self.values, &values].map(|v| self.places.scatter(&of(v), |_| true));
            before.zip(after).is_some_and(|(before, after)| before > TURNED * after)
        };
        // A zero that is elsewhere in these cycles may be so on the other side.
        if !falls(&<[f64]>::to_vec) || !falls(&|v| without_zeros(v, &cycles)) {
            return None;
        }
        let description = format!(
            "`{}` of {} has the opposite sign where `cycle` is {}: at every target it is what the other cycles \
             read, times −1; multiply it by −1 there",
            self.read,
            self.file,
            names.join(", ")
        );
        let change =
            Change::Scale { columns: vec![self.read.to_owned()], rows: Some(rows), factor: -1.0 };
        let edits = vec![Edit { file: self.file, change }];
        Some(Hypothesis::of("input:sign", (self.file, &[self.read]), description, edits).certain())
    }

    /// The cycles, fewer than half, that go against the others; `None` where half do.
    fn opposed<'t>(&self, cycles: &Cycles<'t>) -> Option<Vec<&'t str>> {
        let first = cycles.values().next()?;
        let means = self.places.means(&self.values, |row| first.contains(&row));
        let along = |row: &usize| {
            means[self.places.of_row(*row)].map_or(0.0, |mean| mean.value * self.values[*row])
        };
        let is_against = |name: &&str| cycles[name].iter().map(along).sum::<f64>() < 0.0;
        let (against, with): (Vec<&str>, Vec<&str>) = cycles.keys().copied().partition(is_against);
        match against.len().cmp(&with.len()) {
            Ordering::Less => Some(against),
            Ordering::Equal => None,
            Ordering::Greater => Some(with),
        }
    }

    /// Deviations whose repeats scatter as many times more than the noise as a unit holds of a finer one: that of
    /// this key of `[noise]`, in the unit that the column says.
    pub(super) fn in_a_finer_unit(
        &self,
        finer: &Finer,
        (key, sigma): (&str, f64),
    ) -> Option<Hypothesis> {
        let scatter = self.places.scatter(&self.values, |_| true)?;
        let times = scatter / sigma;
        let [low, high] = AS_WELL_KNOWN;
        if !(low..=high).contains(&(times * finer.factor)) || scatter < finer.no_axis {
            return None;
        }
        let Finer { said, factor, .. } = finer;
        let description = format!(
            "`{}` of {} is in another unit than its name says, {said}, as its repeats scatter {times:.0} times as \
             much as `[noise] {key}` says: divide by {:.0}",
            self.read,
            self.file,
            1.0 / factor
        );
        let columns = vec![self.read.to_owned()];
        let change = Change::Scale { columns, rows: None, factor: *factor };
        let edits = vec![Edit { file: self.file, change }];
        Some(Hypothesis::of("input:unit", (self.file, &[self.read]), description, edits).certain())
    }
}

/// What is left of the values without the mean of their cycles.
fn without_zeros(values: &[f64], cycles: &Cycles<'_>) -> Vec<f64> {
    let mut left = values.to_vec();
    for rows in cycles.values() {
        let mean = rows.iter().map(|row| values[*row]).sum::<f64>() / count(rows.len());
        for row in rows {
            left[*row] -= mean;
        }
    }
    left
}
