//! Readings that lie at other targets than those of their rows, targets for deviations, and signs that were left out.

use super::directions::{contradictions, said_ways};
use crate::case::{Change, Edit, Table};
use crate::count::count;
use crate::suspect::{Hypothesis, Proof, lines_of, rows_left_out, step_of, stretches_of};

/// Share of the smallest step between targets within which a reading is at one.
const NEAR: f64 = 0.1;
/// Share of the readings that must be at some target.
const AT_SOME: f64 = 0.8;
/// Fewest readings that are not at their own: fewer are slips or bad readings.
const FEWEST: usize = 3;
const THOUSAND: f64 = 1000.0;
/// By what a number is multiplied that has its decimal point in another place.
const POWERS: [f64; 6] = [0.1, 0.01, 0.001, 10.0, 100.0, 1000.0];
const DECIMAL_POINT: &str = "input:decimal-point";
/// Standard deviations of the declared noise beyond which a step of the last digit hides it: readings of one place then
/// are all the same, or two.
const COARSE: f64 = 5.0;
const FEWEST_COARSE: usize = 10;

/// Every reading put to the target that it is at; those that are at none go.
pub(super) fn at_other_targets(
    (file, table): (&'static str, &Table),
    [target, reached]: [&'static str; 2],
) -> Option<Hypothesis> {
    let (targets, readings) = (table.numbers(target)?, table.numbers(reached)?);
    let n = targets.len();
    let mut known = targets.clone();
    known.sort_by(f64::total_cmp);
    known.dedup();
    let step = known.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let at = |reading: f64| {
        let next = known.partition_point(|t| *t < reading);
        let nearby = known[next.saturating_sub(1)..(next + 1).min(known.len())].iter().copied();
        let distance = |t: &f64| (t - reading).abs();
        nearby
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .filter(|t| distance(t) < NEAR * step)
    };
    let found: Vec<Option<f64>> = readings.iter().map(|reading| at(*reading)).collect();
    let is_own = |row: usize| found[row].is_some_and(|t| t.total_cmp(&targets[row]).is_eq());
    let wrong: Vec<usize> = (0..n).filter(|row| !is_own(*row)).collect();
    let kept: Vec<usize> = (0..n).filter(|row| found[*row].is_some()).collect();
    if wrong.len() < FEWEST || count(kept.len()) < AT_SOME * count(n) {
        return None;
    }
    let lines: Vec<usize> = wrong.iter().map(|row| table.line(*row)).collect();
    let row = wrong[0];
    let is_near = |other: f64| (other - readings[row]).abs() < NEAR * step;
    let is_difference = |row: &usize| readings[*row].abs() < NEAR * step;
    let are_differences = wrong.iter().all(is_difference);
    let is_same = |other: &usize| readings[*other].total_cmp(&readings[row]).is_eq();
    let is_one = wrong.iter().all(is_same)
        || !are_differences && wrong.iter().all(|other| is_near(readings[*other]));
    // What others read beyond it is no limit.
    let [beyond, below] = [1.0, -1.0].map(|way| {
        readings.iter().any(|other| way * (other - readings[row]) > 0.0 && !is_near(*other))
    });
    // With which each would be at its own.
    let power = |row: &usize| {
        let moved = |power: &f64| (readings[*row] * power - targets[*row]).abs() < NEAR * step;
        POWERS.into_iter().find(moved)
    };
    let powers: Option<Vec<f64>> = wrong.iter().map(power).collect();
    let (effect, as_where, cure) = if is_one && beyond && below {
        (
            "input:stuck",
            "all read the same, which is no limit of the others: the channel stands still",
            "leave these rows out, or measure them again",
        )
    } else if is_one {
        (
            "input:saturation",
            "all read the same: the reading clips (saturated, out of its range, stuck)",
            "leave these rows out, or measure them again",
        )
    } else if are_differences {
        (
            "input:increments",
            "they are deviations, differences of position and target, and the other rows positions (relative)",
            "add the target there",
        )
    } else if powers.is_some() {
        (DECIMAL_POINT, "their decimal point stands in another place", "put it where it belongs")
    } else {
        (
            "input:labels",
            "as where rows are shifted, exchanged or in another order, or a target was skipped, repeated or mistyped",
            "put each reading to the target that it was taken at",
        )
    };
    let description = format!(
        "{} readings of {file} are not at the targets of their rows, {as_where} (lines {}): in line {} `{reached}` is \
         {} at `{target}` {}; {cure}",
        wrong.len(),
        stretches_of(&lines),
        lines[0],
        readings[row],
        targets[row]
    );
    if let Some(powers) = powers.filter(|_| effect == DECIMAL_POINT) {
        let mut values = readings.clone();
        wrong.iter().zip(powers).for_each(|(row, power)| values[*row] *= power);
        let change = Change::Replace { column: reached.to_owned(), values };
        let found =
            Hypothesis::of(effect, (file, &[reached]), description, vec![Edit { file, change }]);
        return Some(Hypothesis { proof: Proof::FitIfNoOther, ..found });
    }
    let is_of_others = effect != "input:labels";
    let kept = if is_of_others { (0..n).filter(|row| is_own(*row)).collect() } else { kept };
    let values = (0..n).map(|row| found[row].unwrap_or(targets[row])).collect();
    let change = Change::Replace { column: target.to_owned(), values };
    let mut edits = vec![Edit { file, change }];
    if kept.len() < n {
        edits.push(Edit { file, change: Change::Keep { rows: kept } });
    }
    let found = Hypothesis::of(effect, (file, &[target, reached]), description, edits);
    Some(Hypothesis { proof: Proof::FitIfNoOther, ..found })
}

/// A column without any sign, where the other has both and is as large in every row.
pub(super) fn signs_lost(
    (file, table): (&'static str, &Table),
    columns: [&'static str; 2],
) -> Option<Hypothesis> {
    let both = columns.map(|column| table.numbers(column));
    let [Some(targets), Some(readings)] = &both else { return None };
    let said = said_ways(table);
    let of = |column: &'static str, mine: &[f64], other: &[f64]| {
        let largest = largest(mine);
        let is_as_large = |(a, b): (&f64, &f64)| (a - b.abs()).abs() < NEAR * largest;
        let negative = other.iter().filter(|value| **value < -NEAR * largest).count();
        let values: Vec<f64> = mine.iter().zip(other).map(|(a, b)| a.copysign(*b)).collect();
        // Of targets that their directions agree with none has lost its sign.
        let contradicts = said.as_ref().is_some_and(|said| {
            column == columns[0] && contradictions(&values, said) > contradictions(mine, said)
        });
        let lost = mine.iter().all(|value| *value >= 0.0)
            && negative >= FEWEST
            && mine.iter().zip(other).all(is_as_large)
            && !contradicts;
        let description = format!(
            "`{column}` of {file} has lost its minus signs (absolute values) in {negative} rows where the \
             other column is negative: put them back"
        );
        let change = Change::Replace { column: column.to_owned(), values };
        let edits = vec![Edit { file, change }];
        lost.then(|| Hypothesis::of("input:sign", (file, &[column]), description, edits))
    };
    of(columns[0], targets, readings).or_else(|| of(columns[1], readings, targets))
}

/// Readings beyond a thousand that are a thousandth of their targets: the separator of thousands was read as a
/// decimal point.
pub(super) fn thousands(
    (file, table): (&'static str, &Table),
    [target, reached]: [&'static str; 2],
) -> Option<Hypothesis> {
    let (targets, readings) = (table.numbers(target)?, table.numbers(reached)?);
    let is_cut = |row: &usize| {
        let whole = THOUSAND * readings[*row];
        targets[*row].abs() >= THOUSAND
            && (whole - targets[*row]).abs() < NEAR * targets[*row].abs()
    };
    let rows: Vec<usize> = (0..targets.len()).filter(is_cut).collect();
    let lines: Vec<usize> = rows.iter().map(|row| table.line(*row)).collect();
    let first = *lines.first()?;
    let description = format!(
        "`{reached}` of {file} is a thousandth of `{target}` in {} rows, all beyond a thousand, from line {first}: a \
         separator of thousands (a comma) was read as a decimal point; multiply by 1000 there",
        rows.len()
    );
    let columns = vec![reached.to_owned()];
    let change = Change::Scale { columns, rows: Some(rows), factor: THOUSAND };
    let edits = vec![Edit { file, change }];
    Some(Hypothesis::of("input:decimal-point", (file, &[reached]), description, edits))
}

/// Share of the travel within which half of the readings are at their targets, where they follow these at all.
const FOLLOWS: f64 = 0.01;

/// Readings whose last digit is many times the declared noise: at each target they are the same in every cycle, as of an
/// axis with a profile.
pub(super) fn coarser_than_noise(
    (file, table): (&'static str, &Table),
    [target, reached]: [&'static str; 2],
    sigma: Option<f64>,
) -> Option<Hypothesis> {
    let step = step_of(table, reached)?;
    let is_coarse = sigma.is_some_and(|sigma| step > COARSE * sigma);
    // What does not follow the targets at all is worse than coarse.
    let (targets, read) = table.numbers(target).zip(table.numbers(reached))?;
    let mut beside: Vec<f64> = targets.iter().zip(&read).map(|(t, r)| (r - t).abs()).collect();
    beside.sort_by(f64::total_cmp);
    let follows = *beside.get(beside.len() / 2)? < FOLLOWS * largest(&targets);
    if !is_coarse || !follows || table.n_rows() < FEWEST_COARSE {
        return None;
    }
    let description = format!(
        "`{reached}` of {file} is rounded to steps of {step}, more than {COARSE} times the declared noise (a resolution too \
         coarse, digits cut off): what is left is the rounding; record all digits, or declare `[noise]` with the rounding in it"
    );
    let found = Hypothesis::of("input:rounded", (file, &[reached]), description, Vec::new());
    Some(found.certain())
}

/// Deviations that are the targets of their rows, of some rows: these were copied over them.
pub(super) fn targets_as_deviations(
    (file, table): (&'static str, &Table),
    [target, deviation]: [&'static str; 2],
) -> Option<Hypothesis> {
    let (targets, read) = table.numbers(target).zip(table.numbers(deviation))?;
    let is_copy = |row: usize| targets[row].total_cmp(&read[row]).is_eq();
    let copies = (0..read.len()).filter(|&row| targets[row] != 0.0 && is_copy(row)).count();
    if copies < FEWEST {
        return None;
    }
    let rows: Vec<bool> = (0..read.len()).map(is_copy).collect();
    let description = format!(
        "`{deviation}` of {file} is the target itself in lines {}: `{target}` was copied over it; put back what was \
         read there, or leave these rows out",
        lines_of(table, &rows)
    );
    let edits = vec![rows_left_out(file, &rows)];
    let found = Hypothesis::of("input:copied", (file, &[deviation]), description, edits);
    Some(found.certain())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}
