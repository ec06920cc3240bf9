//! What may be wrong with any table of readings, whatever it holds.

use super::hypothesis::{Hypothesis, Proof, present};
use super::order::{farthest, rows_shifted, rows_shifted_by, sorted_as_row_numbers};
use super::readings::{Readings, Set};
use super::slip::slips;
use super::unit::{Dimension, all_and_each};
use super::zeros::zeros;
use crate::case::Table;
use crate::kind::Files;
use crate::measured::Fitted;

/// Rows looked at for a slip, the farthest off first.
const FARTHEST: usize = 6;
/// Rows by which columns may be further down than the others, besides one.
const SHIFTS: [isize; 4] = [2, -2, 3, -3];

/// Single numbers that are written down wrong, columns in other rows or in the order of row numbers sorted as text, and
/// zeros for what was not recorded, of every table of readings of a case.
pub(super) fn of_every_table(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let mut tables: Vec<&Readings> =
        files.kind.readings.iter().filter(|of| files.folder.has(of.file)).collect();
    tables.dedup_by_key(|of| of.file);
    tables.into_iter().flat_map(|of| of_table(files, of, fitted)).collect()
}

fn of_table(files: &Files, of: &Readings, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let Ok(table) = files.folder.table(of.file, &[]) else { return Vec::new() };
    let far = fitted.filter(|fitted| !of.are_places && fitted.observations.len() >= table.n_rows());
    let far = far.map(|fitted| (fitted, farthest(fitted, FARTHEST)));
    let far = far.as_ref().map(|(fitted, rows)| (*fitted, &rows[..]));
    let mut all = slips(of.file, Some(&table), &numbers_of(&table, of.sets), far);
    for (columns, dimension) in of.sets {
        let columns = present(Some(&table), columns);
        let sets =
            if *dimension == Dimension::Deviation { Vec::new() } else { all_and_each(&columns) };
        all.extend(sets.iter().flat_map(|set| in_other_rows(of, &table, set)));
        all.extend(columns.iter().filter_map(|column| unrecorded(files, of, &table, column)));
    }
    if let Some(samples) = of.samples.filter(|samples| files.folder.has(samples.file))
        && let Ok(table) = files.folder.table(samples.file, &[])
    {
        all.extend(slips(samples.file, Some(&table), &numbers_of(&table, samples.sets), None));
    }
    all
}

/// Columns further down or up than the others, in reverse order, or sorted as text.
fn in_other_rows(of: &Readings, table: &Table, set: &[&str]) -> Vec<Hypothesis> {
    let mut all: Vec<_> = sorted_as_row_numbers(of.file, table, set).into_iter().collect();
    // Of what was recorded without a pause physics may come late.
    if !of.is_record {
        all.extend(rows_shifted(of.file, Some(table), set, None));
        let farther = |by| rows_shifted_by(of.file, Some(table), set, None, by);
        all.extend(SHIFTS.into_iter().flat_map(farther));
    }
    all
}

/// Columns of which a number may be written down wrong: a deviation that is far off may be any other.
fn numbers_of(table: &Table, sets: &[Set]) -> Vec<&'static str> {
    let sets = sets.iter().filter(|(_, of)| *of != Dimension::Deviation);
    sets.flat_map(|(columns, _)| present(Some(table), columns)).collect()
}

/// Zeros of one column, which may go through zero: the fit without them decides.
fn unrecorded(files: &Files, of: &Readings, table: &Table, column: &str) -> Option<Hypothesis> {
    let without = |_: &Table, marked: &[bool]| {
        let rows: Vec<usize> = (0..marked.len()).filter(|row| marked[*row]).collect();
        of.without(&files.folder, &rows).unwrap_or_default()
    };
    let found = zeros(of.file, Some(table), &[column], without)?;
    Some(Hypothesis { proof: Proof::Fit, ..found })
}
