//! Numbers that are written with few digits.

use std::collections::BTreeSet;

use super::hypothesis::{Hypothesis, Proof, present};
use crate::case::Table;
use crate::count::count;

/// Rows with so few digits, at least.
const FEWEST: usize = 8;
/// Rows beside which so few digits are no chance: of random ones one in ten has a digit less.
const BEYOND_CHANCE: f64 = 3.0;
/// Standard deviations by which one digit may come more often than a tenth of the time: of ten, one does by chance once
/// in a hundred columns.
const MOST_SIGMAS: f64 = 3.0;

/// Digits that a coordinate lacks in every row which the others have, where it was cut.
const FEWER: usize = 3;

/// Some rows of a column that have no digits beyond a decimal.
pub(super) struct Coarse<'c> {
    pub(super) column: &'c str,
    pub(super) decimals: usize,
    pub(super) rows: Vec<usize>,
    /// Whether every digit comes as often as in readings: in places that were planned a few come over and over.
    pub(super) is_read: bool,
}

/// The rows of a column without digits beyond so many decimals, where they are more than by chance and some have as many.
pub(super) fn coarse<'c>(table: &Table, column: &'c str, decimals: usize) -> Option<Coarse<'c>> {
    let (at, _) = table.read_as(column)?;
    let digits: Vec<usize> =
        (0..table.n_rows()).map(|row| decimals_of(table.cell(row, at))).collect();
    let most = digits.iter().copied().max()?;
    let rows: Vec<usize> = (0..digits.len()).filter(|row| digits[*row] <= decimals).collect();
    // Fewer digits still would be another candidate; ten of those have one that has them all.
    let is_finest = rows.iter().any(|row| digits[*row] == decimals);
    let finer = i32::try_from(most.saturating_sub(decimals)).ok()?;
    let by_chance = if finer == 0 { 0.0 } else { count(digits.len()) * 10f64.powi(-finer) };
    let is_much = rows.len() >= FEWEST && count(rows.len()) >= BEYOND_CHANCE * by_chance;
    // What is nothing, as before the first move, has no digits; what comes again has them once.
    let written = rows.iter().map(|row| table.cell(*row, at));
    let distinct: BTreeSet<&str> = written.filter(|cell| cell.parse() != Ok(0.0)).collect();
    let is_read = distinct.len() >= FEWEST
        && !are_planned(&distinct, decimals)
        && are_even(distinct.iter().map(|cell| last_digit(cell, decimals)));
    (is_finest && is_much).then_some(Coarse { column, decimals, rows, is_read })
}

/// A column without the last digits that all others have: of one instrument they have as many.
pub(crate) fn coarser_than_others(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
) -> Option<Hypothesis> {
    let table = table?;
    let there = present(Some(table), columns);
    let most = |column: &str| {
        let (at, _) = table.read_as(column)?;
        (0..table.n_rows()).map(|row| decimals_of(table.cell(row, at))).max()
    };
    let decimals: Vec<usize> = there.iter().map(|column| most(column)).collect::<Option<_>>()?;
    let is_cut = |at: &usize| {
        let others = decimals.iter().enumerate().filter(|(other, _)| other != at);
        let least = others.map(|(_, digits)| *digits).min();
        least.is_some_and(|least| least >= decimals[*at] + FEWER)
            && coarse(table, there[*at], decimals[*at]).is_some_and(|coarse| coarse.is_read)
    };
    let at = (0..there.len()).find(is_cut)?;
    let description = format!(
        "`{}` of {file} is rounded: it has {} decimals where the other coordinates have {} and more (a resolution too \
         coarse, digits cut off); record all digits",
        there[at],
        decimals[at],
        decimals[at] + FEWER
    );
    let found = Hypothesis::of("input:rounded", (file, &[there[at]]), description, Vec::new());
    Some(Hypothesis { proof: Proof::Gross, ..found })
}

/// The step of the last digit that any number of a column has, in the unit of its name.
pub(crate) fn step_of(table: &Table, column: &str) -> Option<f64> {
    let (at, _) = table.read_as(column)?;
    let most = (0..table.n_rows()).map(|row| decimals_of(table.cell(row, at))).max()?;
    Some(table.unit_of(&[column])? * 10f64.powi(-i32::try_from(most).ok()?))
}

/// The digit at a decimal of a number as it is written.
fn last_digit(cell: &str, decimals: usize) -> usize {
    let (whole, after) = cell.split_once('.').unwrap_or((cell, ""));
    let digit = match decimals.checked_sub(1) {
        None => whole.bytes().last(),
        Some(at) => after.as_bytes().get(at).copied(),
    };
    digit.filter(u8::is_ascii_digit).map_or(0, |digit| usize::from(digit - b'0'))
}

/// Whether no digit comes more often than by chance.
fn are_even(digits: impl Iterator<Item = usize>) -> bool {
    let mut each = [0; 10];
    digits.for_each(|digit| each[digit] += 1);
    let n = count(each.iter().sum());
    let most = n / 10.0 + MOST_SIGMAS * (0.09 * n).sqrt();
    each.iter().all(|times| count(*times) <= most)
}

/// Whether numbers lie as far apart, each from the next, by more than one of their last digit: that is how places are planned.
fn are_planned(distinct: &BTreeSet<&str>, decimals: usize) -> bool {
    let mut values: Vec<f64> = distinct.iter().filter_map(|cell| cell.parse().ok()).collect();
    values.sort_by(f64::total_cmp);
    let Ok(decimals) = i32::try_from(decimals) else { return false };
    // In steps of the last digit, as whole numbers.
    let steps = values.windows(2).map(|pair| ((pair[1] - pair[0]) * 10f64.powi(decimals)).round());
    let (least, most) =
        steps.fold((f64::INFINITY, 0.0), |(a, b), s| (f64::min(a, s), f64::max(b, s)));
    least > 1.0 && least.total_cmp(&most).is_eq()
}

/// Decimals of a number as it is written, without zeros at the end.
fn decimals_of(cell: &str) -> usize {
    let decimals = cell.split_once('.').map_or("", |(_, decimals)| decimals);
    decimals.trim_end_matches('0').len()
}

#[cfg(test)]
mod tests {
    use super::{are_even, are_planned, decimals_of, last_digit};

    #[test]
    fn digits_are_those_that_are_written() {
        let all = [("-186.6670", 3, 7), ("0.30", 1, 3), ("-12", 0, 2), ("4.000", 0, 4)];
        for (cell, decimals, last) in all {
            assert_eq!((decimals_of(cell), last_digit(cell, decimals)), (decimals, last), "{cell}");
        }
    }

    #[test]
    fn readings_have_every_digit_and_planned_places_a_few() {
        assert!(are_even((0..30).map(|i| i * 7 % 10)));
        assert!(!are_even((0..30).map(|i| i % 2 * 5)));
        let planned: Vec<String> = (0..12).map(|i| format!("{:.1}", 1.7 * f64::from(i))).collect();
        assert!(are_planned(&planned.iter().map(String::as_str).collect(), 1));
        let read: Vec<String> = planned.iter().map(|cell| format!("{cell}3")).collect();
        assert!(!are_planned(&read[..2].iter().chain(&planned).map(String::as_str).collect(), 2));
    }
}
