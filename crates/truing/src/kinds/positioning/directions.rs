//! Directions of approach that the targets or the readings contradict.

use std::ops::Range;

use ft_center::Approach;

use super::approach::{DIRECTION, approach_of, derived, way};
use super::places::{Mean, Places};
use crate::case::{Change, Edit, Table};
use crate::count::{count, rms};
use crate::suspect::Hypothesis;

/// Moves either way from which directions are known to be turned.
const FEWEST_EITHER_WAY: usize = 4;
/// Targets read from both sides from which on these are compared.
const FEWEST_TARGETS: usize = 5;
/// Standard deviations by which readings from either side differ that were not taken from one.
const APART: f64 = 10.0;
/// Times its standard uncertainty that the sum of both sides may vary from target to target, root mean square, and be
/// the same.
const NOTHING: f64 = 2.0;

/// The direction of every row; `None` where one is none.
pub(super) fn said_ways(table: &Table) -> Option<Vec<Approach>> {
    let column = table.column(DIRECTION)?;
    (0..table.n_rows()).map(|row| approach_of(table.cell(row, column))).collect()
}

/// The other direction in some rows.
pub(super) fn said_otherwise(
    file: &'static str,
    said: &[Approach],
    is_other: impl Fn(usize) -> bool,
) -> Edit {
    let sign = |(row, way): (usize, &Approach)| way.sign() * if is_other(row) { -1.0 } else { 1.0 };
    let values = said.iter().enumerate().map(sign).collect();
    Edit { file, change: Change::Replace { column: DIRECTION.to_owned(), values } }
}

/// Rows whose direction contradicts the way from the target before.
pub(super) fn contradictions(targets: &[f64], said: &[Approach]) -> usize {
    let came = (1..targets.len()).map(|row| way(targets[row - 1], targets[row]));
    came.zip(&said[1..]).filter(|(came, said)| came.is_some_and(|came| came != **said)).count()
}

/// Directions of which every one contradicts the way from the target before, or every one of some runs of rows.
pub(super) fn turned_directions(
    (file, table): (&'static str, &Table),
    target: &str,
) -> Option<Hypothesis> {
    let targets = table.numbers(target)?;
    let said = said_ways(table)?;
    let came = |row: usize| way(targets[row - 1], targets[row]);
    let n = targets.len();
    let contradicts = |row: usize| came(row).is_some_and(|came| came != said[row]);
    let known: Vec<usize> = (1..n).filter(|row| came(*row).is_some()).collect();
    let runs: Vec<&[usize]> = known.chunk_by(|a, b| contradicts(*a) == contradicts(*b)).collect();
    let is_turned = |run: &&&[usize]| contradicts(run[0]);
    let both = [Approach::Rising, Approach::Falling];
    let go_both_ways = |rows: &[usize]| {
        let going = |way| rows.iter().filter(|row| came(**row) == Some(way)).count();
        both.iter().all(|way| going(*way) >= FEWEST_EITHER_WAY)
    };
    let others: Vec<usize> =
        runs.iter().filter(|run| !is_turned(run)).flat_map(|run| run.iter().copied()).collect();
    // Of a few that agree the column may mean another thing.
    let between = runs.get(1..runs.len().max(2) - 1).unwrap_or(&[]);
    let are_clear = runs.iter().filter(is_turned).chain(between).all(|run| go_both_ways(run));
    if !are_clear || !(others.is_empty() || go_both_ways(&others)) {
        return None;
    }
    // How the first target of a pass was come to is not recorded: it is as the rest of the pass.
    let whole = |run: &&[usize]| {
        let (first, last) = (run[0], run[run.len() - 1]);
        let begins = |row: &usize| (*row == 0 || came(*row).is_none()) && said[*row] == said[first];
        let start = (0..first).rev().take_while(begins).last().unwrap_or(first);
        start..if last == known[known.len() - 1] { n } else { last + 1 }
    };
    let turned: Vec<Range<usize>> = runs.iter().filter(is_turned).map(whole).collect();
    let counted = known.len() - others.len();
    let which = match &turned[..] {
        [] => return None,
        [all] if all.len() == n => format!("every one of {counted} targets"),
        some => {
            let lines = |run: &Range<usize>| {
                format!("{} to {}", table.line(run.start), table.line(run.end - 1))
            };
            format!(
                "of lines {}, and of these alone, every one of {counted} targets",
                some.iter().map(lines).collect::<Vec<_>>().join(", ")
            )
        }
    };
    let description = format!(
        "`{DIRECTION}` of {file} has the opposite sign: {which} was reached the other way than it says; \
         exchange +1 and -1 there"
    );
    let edits =
        vec![said_otherwise(file, &said, |row| turned.iter().any(|run| run.contains(&row)))];
    Some(Hypothesis::of("input:sign", (file, &[DIRECTION]), description, edits).certain())
}

/// One direction in every row of an axis that went both ways, and reads otherwise from either side: of one that is
/// come to from one side alone, wherever it goes next, the readings would agree.
pub(super) fn filled_directions(
    (file, table): (&'static str, &Table),
    [target, read]: [&'static str; 2],
) -> Option<Hypothesis> {
    let said = said_ways(table)?;
    let first = *said.first()?;
    let targets = table.numbers(target)?;
    let came: Vec<Approach> = derived(&targets).into_iter().collect::<Option<_>>()?;
    let other = came.iter().filter(|way| **way != first).count();
    if said.iter().any(|way| *way != first) || other < FEWEST_EITHER_WAY {
        return None;
    }
    let sides = Sides::of(&targets, &table.numbers(read)?, &came)?;
    if rms(sides.differences()) < APART * sides.noise {
        return None;
    }
    let description = format!(
        "`{DIRECTION}` of {file} stands still (filled down, or of another table): it says the same in every row, \
         while in {other} of them the target was come to from the other side, where the axis stops elsewhere; write down \
         how each was come to"
    );
    let turned = |row: usize| came[row] != first;
    let edits = vec![said_otherwise(file, &said, turned)];
    Some(Hypothesis::of("input:stuck", (file, &[DIRECTION]), description, edits).certain())
}

/// Deviations of one direction that are, at every target, those of the other with the opposite sign, but for a reversal,
/// and not the same at all: target less reading for reading less target.
pub(super) fn turned_sign(
    (file, table): (&'static str, &Table),
    [target, read]: [&'static str; 2],
) -> Option<Hypothesis> {
    let said = said_ways(table)?;
    let values = table.numbers(read)?;
    let sides = Sides::of(&table.numbers(target)?, &values, &said)?;
    // What is the same everywhere is a reversal.
    if variation(sides.sums()) >= NOTHING * sides.noise
        || variation(sides.differences()) < APART * sides.noise
    {
        return None;
    }
    let falling = |row: usize| said[row] == Approach::Falling;
    let rows: Vec<usize> = (0..said.len()).filter(|row| falling(*row)).collect();
    let description = format!(
        "`{read}` of {file} has the opposite sign in the {} rows of one direction: at every target it is what it \
         is from the other side, times −1, as where the reading was taken off the target and not the target off the \
         reading; multiply it by −1 where the axis was falling (or, as likely, rising)",
        rows.len()
    );
    let change = Change::Scale { columns: vec![read.to_owned()], rows: Some(rows), factor: -1.0 };
    let edits = vec![Edit { file, change }];
    Some(Hypothesis::of("input:sign", (file, &[read]), description, edits).certain())
}

/// Root mean square about the mean.
pub(super) fn variation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let (n, sum) = values.clone().fold((0, 0.0), |(n, sum), value| (n + 1, sum + value));
    let mean = sum / count(n);
    rms(values.map(|value| value - mean))
}

/// Mean readings of the targets that were come to from both sides.
struct Sides {
    means: Vec<[Mean; 2]>,
    /// Standard uncertainty of a sum or difference of two means, from the scatter of the repeats.
    noise: f64,
}

impl Sides {
    /// `None` where too few were, or were read again.
    fn of(targets: &[f64], read: &[f64], ways: &[Approach]) -> Option<Self> {
        let places = Places::of(targets, ways);
        let means = places.both_sides(read);
        if means.len() < FEWEST_TARGETS {
            return None;
        }
        let of_means: f64 = means.iter().flatten().map(|mean| count(mean.of).recip()).sum();
        let noise = places.scatter(read, |_| true)? * (of_means / count(means.len())).sqrt();
        Some(Self { means, noise })
    }

    fn differences(&self) -> impl Iterator<Item = f64> + Clone {
        self.means.iter().map(|[rising, falling]| rising.value - falling.value)
    }

    fn sums(&self) -> impl Iterator<Item = f64> + Clone {
        self.means.iter().map(|[rising, falling]| rising.value + falling.value)
    }
}
