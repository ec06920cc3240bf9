//! What may be wrong with any table of readings, whatever it holds.

use super::hypothesis::{Hypothesis, Proof, present};
use super::odd::odd_among_neighbours;
use super::order::{exchanges, farthest, rows_shifted, rows_shifted_by, sorted_as_row_numbers};
use super::readings::{Readings, Set};
use super::sign::signs_of_the_fewer;
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

/// Numbers that are written down wrong, and zeros for what was not recorded, of every table of readings of a case.
pub(super) fn numbers_of_every_table(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let of_one = |(of, table): (&Readings, Table)| numbers(files, (of, &table), fitted);
    tables_of(files).into_iter().flat_map(of_one).collect()
}

/// Columns in other rows than the others, of every table of readings of a case.
pub(super) fn other_rows_of_every_table(files: &Files) -> Vec<Hypothesis> {
    let of_set = |of: &Readings, table: &Table, columns: &[&str]| -> Vec<Hypothesis> {
        let sets = all_and_each(&present(Some(table), columns));
        sets.iter().flat_map(|set| in_other_rows(of, table, set)).collect()
    };
    let of_one = |(of, table): (&Readings, Table)| {
        let sets = without_deviations(of.sets);
        let mut all: Vec<_> = sets.flat_map(|(columns, _)| of_set(of, &table, columns)).collect();
        all.extend(exchanged_with_conditions(of, &table));
        all
    };
    tables_of(files).into_iter().flat_map(of_one).collect()
}

/// Columns of readings under the headings of columns that take no part in the model, and the other way round.
fn exchanged_with_conditions(of: &Readings, table: &Table) -> Vec<Hypothesis> {
    let read: Vec<&str> =
        of.sets.iter().flat_map(|(columns, _)| present(Some(table), columns)).collect();
    let is_number = |name: &&&str| {
        let column = table.column(name);
        let is_read =
            |row: usize| column.is_some_and(|c| table.cell(row, c).parse::<f64>().is_ok());
        !read.contains(*name) && (0..table.n_rows()).all(is_read)
    };
    let names: Vec<&str> = table.names().iter().map(|name| &**name).collect();
    let others: Vec<&str> = names.iter().filter(is_number).copied().collect();
    let of_both = |[one, other]: [&str; 2]| exchanges(of.file, Some(table), &[one, other]);
    let both = read.iter().flat_map(|one| others.iter().map(move |other| [*one, *other]));
    let found = both.flat_map(of_both);
    found.map(|found| Hypothesis { proof: Proof::FitIfGross, ..found }).collect()
}

/// The tables that are there, each once.
fn tables_of(files: &Files) -> Vec<(&Readings, Table)> {
    let mut tables: Vec<&Readings> = files.kind.readings.iter().collect();
    tables.dedup_by_key(|of| of.file);
    let read = |of: &Readings| files.folder.table(of.file, &[]).ok();
    let is_there = |of: &&Readings| files.folder.has(of.file);
    tables.into_iter().filter(is_there).filter_map(|of| Some((of, read(of)?))).collect()
}

/// Sets of columns of which a number may be wrong by itself: a deviation is small in any row and any unit that makes
/// it so, and one that is far off may be any other.
fn without_deviations(sets: &[Set]) -> impl Iterator<Item = &Set> {
    sets.iter().filter(|(_, of)| *of != Dimension::Deviation)
}

fn numbers(
    files: &Files,
    (of, table): (&Readings, &Table),
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let far = fitted.filter(|fitted| !of.are_places && fitted.observations.len() >= table.n_rows());
    let far = far.map(|fitted| (fitted, farthest(fitted, FARTHEST)));
    let far = far.as_ref().map(|(fitted, rows)| (*fitted, &rows[..]));
    let columns = columns_of(table, of.sets);
    let mut all = slips((of.file, Some(table)), &columns, of.is_record, far);
    all.extend(signs_of_the_fewer(of.file, table, &columns));
    for (columns, dimension) in without_deviations(of.sets) {
        let columns = present(Some(table), columns);
        let odd = |column: &&str| odd_among_neighbours(of.file, table, column, *dimension);
        all.extend(columns.iter().flat_map(odd));
    }
    let sets = of.sets.iter().flat_map(|(columns, _)| present(Some(table), columns));
    all.extend(sets.filter_map(|column| unrecorded(files, of, table, column)));
    if let Some(samples) = of.samples.filter(|samples| files.folder.has(samples.file))
        && let Ok(table) = files.folder.table(samples.file, &[])
    {
        let columns = columns_of(&table, samples.sets);
        all.extend(slips((samples.file, Some(&table)), &columns, false, None));
    }
    all
}

fn columns_of(table: &Table, sets: &[Set]) -> Vec<&'static str> {
    without_deviations(sets).flat_map(|(columns, _)| present(Some(table), columns)).collect()
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

/// Zeros of one column, which may go through zero: the fit without them decides.
fn unrecorded(files: &Files, of: &Readings, table: &Table, column: &str) -> Option<Hypothesis> {
    let without = |_: &Table, marked: &[bool]| {
        let rows: Vec<usize> = (0..marked.len()).filter(|row| marked[*row]).collect();
        of.without(&files.folder, &rows).unwrap_or_default()
    };
    let found = zeros(of.file, Some(table), &[column], without)?;
    Some(Hypothesis { proof: Proof::Fit, ..found })
}
