use super::hypothesis::{Hypothesis, Proof, listed, present};
use crate::case::{Edit, Table};

/// Rows that read nothing but zeros in some columns, as an export writes what was not recorded; one may be the
/// origin.
const FEWEST: usize = 2;

/// The same of one column, which may go through zero.
const FEWEST_OF_ONE: usize = 3;

/// Readings that were not recorded and stand in the table as zeros.
pub(crate) fn zeros(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    without: impl Fn(&Table, &[bool]) -> Vec<Edit>,
) -> Option<Hypothesis> {
    let there = present(table, columns);
    let table = table?;
    let fewest = if there.len() > 1 { FEWEST } else { FEWEST_OF_ONE };
    let read: Vec<Vec<f64>> = there.iter().filter_map(|name| table.numbers(name)).collect();
    let is_zero = |row: usize| read.iter().all(|values| values[row] == 0.0);
    let rows: Vec<bool> = (0..table.n_rows()).map(is_zero).collect();
    let n = rows.iter().filter(|row| **row).count();
    if n < fewest || 2 * n > rows.len() || read.len() < there.len() {
        return None;
    }
    if let [alone] = &read[..]
        && is_a_place_as_others(alone, n)
    {
        return None;
    }
    let first = rows.iter().position(|row| *row)?;
    let description = format!(
        "{n} rows of {file} read 0 in all of {}, from line {}: what was missing was written as zeros; leave these \
         rows out",
        listed(&there),
        table.line(first)
    );
    let edits = without(table, &rows);
    let found = Hypothesis::of("input:missing", (file, &there), description, edits);
    Some(Hypothesis { proof: Proof::Gross, ..found })
}

/// Whether a column of places that come again has 0 among them, no more often than half of the others come.
fn is_a_place_as_others(values: &[f64], n_zeros: usize) -> bool {
    let mut others: Vec<f64> = values.iter().copied().filter(|value| *value != 0.0).collect();
    others.sort_by(f64::total_cmp);
    let mut times: Vec<usize> =
        others.chunk_by(|a, b| a.total_cmp(b).is_eq()).map(<[f64]>::len).collect();
    times.sort_unstable();
    times.get(times.len() / 2).is_some_and(|&middle| middle >= n_zeros)
}
