//! Planned measurements as rows of the table that they belong to.

use std::collections::HashSet;

use crate::Error;
use crate::case::{Change, Edit, Problem, Table};
use crate::kinds::Offer;

/// Column that says when.
const TIME: &str = "time_s";
/// Column that says what a row is for.
const USE: &str = "use";

/// A table with planned rows at its end.
pub(super) struct Rows {
    pub(super) names: Vec<String>,
    /// As the model reads them: readings nominal, conditions as before.
    pub(super) filled: Vec<Vec<String>>,
    /// As they are handed out: what is to be measured is empty.
    pub(super) empty: Vec<Vec<String>>,
}

impl Rows {
    /// The offered rows of these indices, in this order.
    pub(super) fn of(table: &Table, offer: &Offer, chosen: &[usize]) -> Result<Self, Error> {
        let new = offer.columns.iter().map(|(name, _)| name);
        let columns: Vec<&String> = table.names().iter().chain(new).collect();
        let has = |name: &str| columns.iter().any(|column| *column == name);
        let mut cells = offer.offered.iter().flat_map(|offered| &offered.cells);
        if let Some((name, _)) = cells.find(|(name, _)| !has(name)) {
            // Written in another unit.
            let problem = Problem::MissingColumn { column: (*name).to_owned(), nearest: None };
            return Err(Error::case(table.at_header(), problem));
        }
        let names = new_names(table, offer.names, chosen.len());
        let old = table.n_rows();
        let pace = pace(table);
        let (mut filled, mut empty) = (Vec::new(), Vec::new());
        for (n, &index) in chosen.iter().enumerate() {
            let cells = &offer.offered[index].cells;
            let (mut full, mut open) = (Vec::new(), Vec::new());
            for (column, name) in columns.iter().enumerate() {
                let planned = cells.iter().find(|(known, _)| *known == name.as_str());
                let is_reading = offer.readings.contains(&name.as_str());
                // Another row stands for what is not planned: a group, a temperature.
                let like = || {
                    if column < table.names().len() { table.cell(n % old, column) } else { "" }
                };
                let (value, is_open) = match (planned, name.as_str()) {
                    (Some((_, cell)), _) => (cell.clone(), is_reading),
                    (None, name) if name == offer.names => (names[n].clone(), false),
                    (None, USE) => ("fit".to_owned(), false),
                    (None, TIME) => (later(pace, n), true),
                    (None, name) => {
                        let is_number = like().parse::<f64>().is_ok();
                        (like().to_owned(), is_number && !name.starts_with("sigma"))
                    }
                };
                open.push(if is_open { String::new() } else { value.clone() });
                full.push(value);
            }
            filled.push(full);
            empty.push(open);
        }
        Ok(Self { names, filled, empty })
    }

    /// The change of the case that adds the filled rows.
    pub(super) fn edit(self, offer: &Offer) -> Edit {
        let change = Change::Append { columns: offer.columns.clone(), rows: self.filled };
        Edit { file: offer.table, change }
    }

    /// The whole table with the rows handed out.
    pub(super) fn csv(&self, table: &Table, offer: &Offer) -> String {
        table.appended(&offer.columns, &self.empty).csv()
    }
}

/// Names that no row has.
fn new_names(table: &Table, column: &str, count: usize) -> Vec<String> {
    let index = table.column(column);
    let known: HashSet<&str> =
        (0..table.n_rows()).filter_map(|row| Some(table.cell(row, index?))).collect();
    let free = (1..).map(|n| format!("N{n}")).filter(|name| !known.contains(name.as_str()));
    free.take(count).collect()
}

/// The last time and the mean pace.
fn pace(table: &Table) -> Option<[f64; 2]> {
    let column = table.column(TIME)?;
    let times: Vec<f64> =
        (0..table.n_rows()).filter_map(|row| table.cell(row, column).parse().ok()).collect();
    let (first, last) = (times.first()?, times.last()?);
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let steps = times.len().max(2) as f64 - 1.0;
    Some([*last, (last - first) / steps])
}

fn later(pace: Option<[f64; 2]>, n: usize) -> String {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    pace.map_or_else(String::new, |[last, step]| format!("{:.6}", last + step * (n as f64 + 1.0)))
}
