//! What a planned probing program logged, in the rows that were planned.

use std::borrow::Cow;
use std::path::Path;

use super::probe_log::centers_mm;
use crate::case::{Folder, Problem, ReadOptions};
use crate::{Error, OutputFile};

/// Tables of touches, one of which a plan has.
const TABLES: [&str; 2] = ["touches.csv", "points.csv"];
/// Where the ball was: what a plan leaves open.
const READINGS: [&str; 3] = ["x_mm", "y_mm", "z_mm"];

/// A plan's table with what the controller logged in the rows that were left open, in the order of
/// both, and how many they are; the other rows stay as they are, comments go.
///
/// # Errors
///
/// [`Error::NotRead`]; [`Error::Case`] with the line of the log that is no such record, for a folder
/// without a table of touches, and where not as many are open as the log has.
pub fn import_planned_log(
    log: &Path,
    plan: &Path,
    unit_mm: f64,
) -> Result<(OutputFile, usize), Error> {
    let centers = centers_mm(log, unit_mm)?;
    let folder = Folder::open(plan, ReadOptions::default())?;
    let file = TABLES.into_iter().find(|file| folder.has(file)).unwrap_or(TABLES[0]);
    let table = folder.table(file, &READINGS)?;
    let mut columns = [0; 3];
    for (column, name) in columns.iter_mut().zip(READINGS) {
        *column = table.column(name).ok_or_else(|| {
            let problem = Problem::MissingColumn { column: name.to_owned(), nearest: None };
            Error::case(table.at_header(), problem)
        })?;
    }
    let is_open = |row: &usize| columns.iter().all(|column| table.cell(*row, *column).is_empty());
    let open: Vec<usize> = (0..table.n_rows()).filter(is_open).collect();
    if open.len() != centers.len() {
        let message = format!(
            "{} rows wait for a touch, and {} holds {}; a plan and its log have as many",
            open.len(),
            log.display(),
            centers.len()
        );
        return Err(Error::case(table.at_file(), Problem::WrongValue { message }));
    }
    let filled = table.rewritten(|table, row, column| {
        let touch = open.binary_search(&row).ok();
        let axis = columns.iter().position(|of| *of == column);
        match touch.zip(axis) {
            Some((touch, axis)) => Cow::Owned(centers[touch][axis].to_string()),
            None => table.cell(row, column).into(),
        }
    });
    Ok((OutputFile { path: plan.join(file), content: filled.csv() }, centers.len()))
}
