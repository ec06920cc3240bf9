//! Numbers that do not go with those in the rows beside them.

use super::factor::Factor;
use super::hypothesis::Hypothesis;
use super::some_rows::Rows;
use super::unit::Dimension;
use crate::case::Table;

/// Rows of a table in which numbers are held against those beside them, at least, and how many of these on either side.
const LONG: usize = 12;
const BESIDE: usize = 3;
/// Times the median distance of a number from those beside it, of one that is odd, and of one that is not; or the share
/// of what it was off by.
const FAR_OFF: f64 = 8.0;
const NEAR: f64 = 4.0;
const HARDLY: f64 = 0.1;
/// Odd numbers at least: of fewer each is a slip.
const FEWEST_ODD: usize = 3;

/// Numbers of a column here and there that lie far from those of the rows beside them, and among them once they are
/// multiplied by the same factor.
pub(super) fn odd_among_neighbours(
    file: &'static str,
    table: &Table,
    column: &str,
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let known = table.numbers(column).zip(table.unit_of(&[column]));
    let Some((values, declared)) = known.filter(|(values, _)| values.len() >= LONG) else {
        return Vec::new();
    };
    let middle: Vec<f64> = (0..values.len()).map(|row| among_neighbours(&values, row)).collect();
    let off: Vec<f64> = values.iter().zip(&middle).map(|(v, m)| (v - m).abs()).collect();
    let usual = median(off.clone());
    let of_factor = |Factor { effect, what, by }: Factor| {
        let is_odd = |row: &usize| {
            let left = (by * values[*row] - middle[*row]).abs();
            off[*row] > FAR_OFF * usual && left <= (NEAR * usual).max(HARDLY * off[*row])
        };
        let these: Vec<usize> = (0..values.len()).filter(is_odd).collect();
        (FEWEST_ODD..=values.len() / 3)
            .contains(&these.len())
            .then(|| Rows { file, table, these }.scaled(effect, (&[column], &what), by))
    };
    Factor::all(dimension, declared).into_iter().filter_map(of_factor).collect()
}

/// How far each number of a record lies above or below both that before and that after it; zero between the two, as on a
/// step.
pub(super) fn heights(values: &[f64]) -> Vec<f64> {
    let height = |[before, after]: [f64; 2]| {
        if before * after > 0.0 { before.abs().min(after.abs()) } else { 0.0 }
    };
    (0..values.len()).map(|row| height(from_beside(values, row))).collect()
}

/// The same in medians of the distance of a number from the middle between those beside it.
pub(super) fn jumps(values: &[f64]) -> Vec<f64> {
    if values.is_empty() {
        return Vec::new();
    }
    let off = from_the_middle(values).into_iter().map(f64::abs);
    // A number that stands like both its neighbours does not jump, however still all others stand.
    let usual = median(off.collect()).max(f64::MIN_POSITIVE);
    heights(values).into_iter().map(|height| height / usual).collect()
}

/// How far each number of a record lies from the middle between that before and that after it.
pub(super) fn from_the_middle(values: &[f64]) -> Vec<f64> {
    let off = |row| {
        let [before, after] = from_beside(values, row);
        f64::midpoint(before, after)
    };
    (0..values.len()).map(off).collect()
}

/// A number less that before and that after it; at either end one is where the two next to it lead.
fn from_beside(values: &[f64], row: usize) -> [f64; 2] {
    let at = |row: Option<usize>| values.get(row?).copied();
    let [before, after] = [at(row.checked_sub(1)), at(Some(row + 1))];
    let led = || match (before, after) {
        (Some(one), None) => Some(2.0 * one - at(row.checked_sub(2))?),
        (None, Some(one)) => Some(2.0 * one - at(Some(row + 2))?),
        _ => None,
    };
    let led = led().unwrap_or(values[row]);
    [before.unwrap_or(led), after.unwrap_or(led)].map(|other| values[row] - other)
}

/// Whether a number of a record goes on as those before and after it do.
pub(super) fn goes_on(jumps: &[f64], row: usize) -> bool {
    jumps.get(row).is_some_and(|jump| *jump < FAR_OFF)
}

/// The middle one of the numbers in the rows beside a row.
fn among_neighbours(values: &[f64], row: usize) -> f64 {
    let beside = row.saturating_sub(BESIDE)..(row + BESIDE + 1).min(values.len());
    median(beside.filter(|other| *other != row).map(|other| values[other]).collect())
}

/// The middle of some numbers, of which there is one at least.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}
