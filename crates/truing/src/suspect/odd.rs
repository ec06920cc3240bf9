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

/// How far each number of a record lies above or below both that before and that after it, in medians of its distance from
/// the middle between them; zero between the two, as on a step.
pub(super) fn jumps(values: &[f64]) -> Vec<f64> {
    let from_beside = |row: usize| {
        let other = |at: Option<usize>| Some(values[row] - values.get(at?)?);
        let [before, after] = [other(row.checked_sub(1)), other(Some(row + 1))];
        let one = before.or(after).unwrap_or(0.0);
        [before.unwrap_or(one), after.unwrap_or(one)]
    };
    let all: Vec<[f64; 2]> = (0..values.len()).map(from_beside).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let off = all.iter().map(|[before, after]| f64::midpoint(*before, *after).abs());
    // A number that stands like both its neighbours does not jump, however still all others stand.
    let usual = median(off.collect()).max(f64::MIN_POSITIVE);
    let height = |[before, after]: [f64; 2]| {
        if before * after > 0.0 { before.abs().min(after.abs()) } else { 0.0 }
    };
    all.into_iter().map(|pair| height(pair) / usual).collect()
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

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    f64::midpoint(values[(n - 1) / 2], values[n / 2])
}
