//! Planned measurements as rows of the tables that they belong to.

use std::collections::HashSet;

use crate::Error;
use crate::case::{Change, Edit, Folder, Problem, Table};
use crate::kinds::{Cells, Offer};

/// Column that says when.
const TIME: &str = "time_s";
/// Column that says what a row is for.
const USE: &str = "use";

/// Tables with planned rows at their end.
pub(super) struct Rows {
    /// Of the measurements.
    pub(super) names: Vec<String>,
    /// Rows of each measurement in the first table.
    pub(super) sizes: Vec<usize>,
    /// The table that measurements are rows of, and those beside it.
    tables: Vec<Longer>,
}

/// One table with planned rows.
struct Longer {
    file: &'static str,
    table: Table,
    columns: Vec<(String, Vec<String>)>,
    /// As the model reads them: readings nominal, conditions as before.
    filled: Vec<Vec<String>>,
    /// As they are handed out: what is to be measured is empty.
    empty: Vec<Vec<String>>,
    /// Whether its rows are a record, and so no part of what is handed out.
    are_readings: bool,
    /// Time from row to row, of the mean of those that there were.
    pace: f64,
}

impl Rows {
    /// The offered measurements of these indices, in this order.
    pub(super) fn of(folder: &Folder, offer: &Offer, chosen: &[usize]) -> Result<Self, Error> {
        Self::paced(folder, offer, chosen, chosen.len())
    }

    /// The same in the time that `n_made` of them take.
    pub(super) fn paced(
        folder: &Folder,
        offer: &Offer,
        chosen: &[usize],
        n_made: usize,
    ) -> Result<Self, Error> {
        let pace = as_f64(n_made) / as_f64(chosen.len().max(1));
        let table = folder.table(offer.table, &[])?;
        let mut known: HashSet<String> = HashSet::new();
        for column in chosen.iter().map(|&i| offer.offered[i].names) {
            let index = table.column(column);
            known.extend(
                (0..table.n_rows()).filter_map(|row| Some(table.cell(row, index?).to_owned())),
            );
        }
        let free = (1..).map(|n| format!("N{n}")).filter(|name| !known.contains(name));
        let names: Vec<String> = free.take(chosen.len()).collect();

        let mut first =
            Longer::of(offer.table, table, offer.columns.clone(), offer.is_record, pace);
        let mut others: Vec<Longer> = Vec::new();
        for (&index, name) in chosen.iter().zip(&names) {
            let offered = &offer.offered[index];
            for row in &offered.rows {
                first.push(row, (offered.names, name), &offer.readings)?;
            }
            for beside in &offered.beside {
                let place = others.iter().position(|other| other.file == beside.table);
                let place = if let Some(place) = place {
                    place
                } else {
                    let table = folder.table(beside.table, &[])?;
                    others.push(Longer::of(
                        beside.table,
                        table,
                        Vec::new(),
                        beside.are_readings,
                        pace,
                    ));
                    others.len() - 1
                };
                for row in &beside.rows {
                    others[place].push(row, (offered.names, name), &[])?;
                }
            }
        }
        let sizes = chosen.iter().map(|&i| offer.offered[i].rows.len()).collect();
        Ok(Self { names, sizes, tables: std::iter::once(first).chain(others).collect() })
    }

    /// Whether the table of the measurements has times.
    pub(super) fn are_timed(&self) -> bool {
        self.tables[0].table.column(TIME).is_some()
    }

    /// The changes of the case that add the filled rows.
    pub(super) fn edits(&self) -> Vec<Edit> {
        let edit = |longer: &Longer| Edit {
            file: longer.file,
            change: Change::Append { columns: longer.columns.clone(), rows: longer.filled.clone() },
        };
        self.tables.iter().map(edit).collect()
    }

    /// The tables with the rows that are handed out, by file.
    pub(super) fn csv(&self) -> Vec<(&'static str, String)> {
        let handed = self.tables.iter().filter(|longer| !longer.are_readings);
        handed.map(|longer| (longer.file, longer.csv())).collect()
    }

    /// The rows handed out of the first table: its columns, and the cells of each.
    pub(super) fn handed(&self) -> (Vec<String>, Vec<Vec<String>>) {
        (self.tables[0].names().cloned().collect(), self.tables[0].empty.clone())
    }
}

impl Longer {
    fn of(
        file: &'static str,
        table: Table,
        columns: Vec<(String, Vec<String>)>,
        are_readings: bool,
        pace: f64,
    ) -> Self {
        Self { file, table, columns, filled: Vec::new(), empty: Vec::new(), are_readings, pace }
    }

    fn names(&self) -> impl Iterator<Item = &String> {
        self.table.names().iter().chain(self.columns.iter().map(|(name, _)| name))
    }

    /// Adds a row of these cells, by the name of its measurement.
    fn push(
        &mut self,
        cells: &Cells,
        (names, own): (&str, &String),
        readings: &[&str],
    ) -> Result<(), Error> {
        let missing = |(name, _): &&(&str, String)| !self.names().any(|column| column == name);
        if let Some((name, _)) = cells.iter().find(missing) {
            // Written in another unit.
            let problem = Problem::MissingColumn { column: (*name).to_owned(), nearest: None };
            return Err(Error::case(self.table.at_header(), problem));
        }
        let (n, old) = (self.filled.len(), self.table.n_rows());
        let (mut full, mut open) = (Vec::new(), Vec::new());
        for (column, name) in self.names().enumerate() {
            let planned = cells.iter().find(|(known, _)| *known == name.as_str());
            let is_reading = readings.contains(&name.as_str());
            // Another row stands for what is not planned: a group, a temperature.
            let is_old = column < self.table.names().len();
            let like = if is_old { self.table.cell(n % old, column) } else { "" };
            let (value, is_open) = match (planned, name.as_str()) {
                (Some((_, cell)), _) => (cell.clone(), is_reading),
                (None, name) if name == names => (own.clone(), false),
                (None, USE) => ("fit".to_owned(), false),
                (None, TIME) => (later(&self.table, n, self.pace), true),
                (None, name) => {
                    let is_number = like.parse::<f64>().is_ok();
                    (like.to_owned(), is_number && !name.starts_with("sigma"))
                }
            };
            open.push(if is_open { String::new() } else { value.clone() });
            full.push(value);
        }
        self.filled.push(full);
        self.empty.push(open);
        Ok(())
    }

    /// The whole table with the rows handed out.
    fn csv(&self) -> String {
        self.table.appended(&self.columns, &self.empty).csv()
    }
}

/// The time of the `n`th row after the last, at `pace` times the mean pace; empty where the table has no times.
fn later(table: &Table, n: usize, pace: f64) -> String {
    let Some(column) = table.column(TIME) else { return String::new() };
    let time = |row: usize| table.cell(row, column).parse::<f64>().ok();
    let rows = 0..table.n_rows();
    let (first, last) = (rows.clone().find_map(time), rows.rev().find_map(time));
    let steps = as_f64(table.n_rows().max(2) - 1);
    first.zip(last).map_or_else(String::new, |(first, last)| {
        format!("{:.6}", last + (last - first) / steps * pace * as_f64(n + 1))
    })
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
