use super::hypothesis::{Hypothesis, listed};
use crate::case::{Edit, Table};
use crate::count::count;

/// Readings that are the one before to the last digit, from which on it is no accident.
const FEWEST: usize = 10;
/// One in so many readings at least is the one before: a few equal ones are rounded alike.
const ONE_IN: usize = 5;
/// Every reading that is held leaves one that is not.
const LEAST_NEW: f64 = 0.4;

/// Columns in which many readings are the one before over again, as a channel gives that is read faster than
/// it is filled: to be decided by the fit without these rows.
pub(crate) fn held(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let of_column = |name: &&str| {
        let values = table.numbers(name)?;
        let rows = held_rows(&values)?;
        let n = rows.iter().filter(|row| **row).count();
        let description = format!(
            "{n} readings of {} of {file} are the one before over again, from line {}: the channel is stuck for a \
             row or more at a time (held, read faster than it is filled); read it as fast as it gives, or leave \
             these rows out",
            listed(&[*name]),
            table.line(rows.iter().position(|row| *row)?)
        );
        let edits = without(table, &rows);
        Some(Hypothesis::of("input:stuck", (file, &[*name]), description, edits))
    };
    columns.iter().filter_map(of_column).collect()
}

/// The rows whose reading is the one before, where they are many and no design has them.
fn held_rows(values: &[f64]) -> Option<Vec<bool>> {
    let is_held = |row: usize| row > 0 && values[row].total_cmp(&values[row - 1]).is_eq();
    let rows: Vec<bool> = (0..values.len()).map(is_held).collect();
    let n = rows.iter().filter(|row| **row).count();
    let mut kept: Vec<f64> =
        values.iter().zip(&rows).filter(|(_, held)| !**held).map(|(v, _)| *v).collect();
    let left = kept.len();
    kept.sort_by(f64::total_cmp);
    kept.dedup();
    // Levels of a design come again, readings do not.
    let are_readings = 10 * kept.len() >= 9 * left;
    let is_left = count(left) >= LEAST_NEW * count(values.len());
    (n >= FEWEST && ONE_IN * n >= values.len() && are_readings && is_left).then_some(rows)
}

#[cfg(test)]
mod tests {
    use super::held_rows;

    #[test]
    fn every_second_reading_held_is_seen_and_levels_are_not() {
        let read: Vec<f64> = (0..40).map(|i| (f64::from(i / 2) * 0.7).sin()).collect();
        let rows = held_rows(&read).expect("twenty of forty");
        assert!(rows.iter().enumerate().all(|(row, held)| *held == (row % 2 == 1)));
        let levels: Vec<f64> = (0..40).map(|i| f64::from(i / 2 % 5)).collect();
        assert!(held_rows(&levels).is_none());
    }
}
