use std::collections::BTreeSet;

use model_discrepancy::{Covariate, Quantity};

use super::column_kinds::ColumnKinds;
use super::quote::quote;
use super::table::Table;
use crate::count::count;

/// Largest covariate: a clock in nanoseconds fits, and squares stay far inside an `f64`.
const MAX_COVARIATE: f64 = 1e30;

/// Columns that the declared model does not use.
#[derive(Clone, Debug, Default)]
pub(crate) struct Extras {
    /// Numbers in every row, and the names of labels that come and go.
    pub(crate) covariates: Vec<NumberColumn>,
    /// Text: possible groupings.
    pub(crate) labels: Vec<String>,
    /// Columns dropped or doubtful.
    pub(crate) warnings: Vec<String>,
}

/// One numeric column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NumberColumn {
    pub(crate) name: String,
    pub(crate) values: Vec<f64>,
    pub(crate) quantity: Quantity,
}

impl NumberColumn {
    /// As the loop takes it.
    pub(crate) fn covariate(&self) -> Covariate {
        self.with(self.values.clone())
    }

    /// The same with other values.
    pub(crate) fn with(&self, values: Vec<f64>) -> Covariate {
        Covariate::recorded(self.name.as_str(), self.quantity, values)
    }
}

impl Extras {
    /// Sorts a column into covariates and labels.
    pub(crate) fn add(&mut self, table: &Table, column: usize, kinds: &ColumnKinds) {
        let name = &table.names()[column];
        let mut values = Vec::with_capacity(table.n_rows());
        let mut first_text = None;
        let mut first_gap = None;
        for row in 0..table.n_rows() {
            match sorted(table, row, column) {
                Cell::Number(value) => values.push(value),
                Cell::Gap => first_gap = first_gap.or(Some(row)),
                Cell::Text => first_text = first_text.or(Some(row)),
            }
        }
        match (first_text, first_gap) {
            (None, None) => {
                let quantity = kinds.of(name);
                self.covariates.push(NumberColumn { name: name.clone(), values, quantity });
            }
            (None, Some(row)) => self.warnings.push(format!(
                "{}: {}, so the covariate is left out",
                table.at_cell(row, column),
                match table.cell(row, column) {
                    "" => "the cell is empty".to_owned(),
                    cell => format!("{} is no finite number below {MAX_COVARIATE:e}", quote(cell)),
                }
            )),
            (Some(row), _) => {
                self.labels.push(name.clone());
                self.covariates.extend(by_name(table, column));
                if 2 * values.len() > table.n_rows() {
                    self.warnings.push(format!(
                        "{}: not a number, so the whole column is taken for a label",
                        table.at_cell(row, column)
                    ));
                }
            }
        }
    }
}

/// Names of a label at most for which each is a covariate, and rows of each at least.
const MOST_NAMES: usize = 12;
const FEWEST_ROWS: usize = 3;

/// Label of what was measured together, warmer than the rest or set up anew.
pub(crate) const SESSION: &str = "session";

/// Of each name of a label that comes and goes, as the nest or the stylus that was used; of two names of the second. Sessions,
/// and where each name stands in one piece what may be one, have effects of their own.
fn by_name(table: &Table, column: usize) -> Vec<NumberColumn> {
    let label = &table.names()[column];
    let all = of_names(table, column, |name| format!("{label}: {name}"));
    let cells: Vec<&str> = (0..table.n_rows()).map(|row| table.cell(row, column)).collect();
    let pieces = cells.chunk_by(|a, b| a == b).count();
    let is_recorded = !cells.contains(&"")
        && all.iter().all(|one| one.values.iter().sum::<f64>() >= count(FEWEST_ROWS));
    if label == SESSION || !is_recorded || pieces == all.len() {
        return Vec::new();
    }
    let first = usize::from(all.len() == 2);
    all.into_iter().skip(first).collect()
}

/// For each name of a label that has two or more, and not too many: 1 in its rows, else 0.
pub(crate) fn of_names(
    table: &Table,
    column: usize,
    titled: impl Fn(&str) -> String,
) -> Vec<NumberColumn> {
    let cells: Vec<&str> = (0..table.n_rows()).map(|row| table.cell(row, column)).collect();
    let names: BTreeSet<&str> = cells.iter().copied().collect();
    if !(2..=MOST_NAMES).contains(&names.len()) {
        return Vec::new();
    }
    let of = |name: &str| NumberColumn {
        name: titled(name),
        values: cells.iter().map(|cell| f64::from(u8::from(*cell == name))).collect(),
        quantity: Quantity::Other,
    };
    names.into_iter().map(of).collect()
}

enum Cell {
    Number(f64),
    Gap,
    Text,
}

fn sorted(table: &Table, row: usize, column: usize) -> Cell {
    match table.number(row, column) {
        Some(value) if value.abs() < MAX_COVARIATE => Cell::Number(value),
        Some(_) => Cell::Gap,
        None if table.cell(row, column).is_empty() => Cell::Gap,
        None => Cell::Text,
    }
}
