use truing_report::{COVERAGE, with_expanded};

use std::fmt::{self, Write as _};

/// Rows shown before a table is cut: one screen, and some.
const MAX_ROWS: usize = 40;

/// Significant digits of numbers for people; the JSON has all of them.
const DIGITS: i32 = 5;

/// A table for people: text to the left, numbers to the right.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    title: String,
    columns: Vec<&'static str>,
    rows: Vec<Vec<Cell>>,
    /// Whether the numbers of a column have one unit, and so as many decimals.
    is_uniform: bool,
}

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    Text(String),
    Number(Option<f64>),
    /// A value and its standard uncertainty, to whose digits it is shown.
    Known(f64, Option<f64>),
    /// The expanded uncertainty of a standard one.
    Expanded(Option<f64>),
}

/// Header of a column of expanded uncertainties.
pub(crate) const EXPANDED: &str = "U (k = 2)";

/// Least decimals of a column without uncertainties, by the unit that its header ends with: a
/// tenth of what the best instrument for it resolves, so that no difference that can be measured
/// is rounded away.
const LEAST_DECIMALS: &[(&str, i32)] =
    &[("mm", 5), ("µm", 2), ("°", 6), ("deg", 6), ("µrad", 2), ("N", 4), ("N·mm", 2), ("s", 4)];

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(Some(value))
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        Self::Number(value)
    }
}

impl TextTable {
    /// A table whose rows are things, and whose columns have one unit each.
    pub(crate) fn new(title: impl Into<String>, columns: &[&'static str]) -> Self {
        let (columns, rows) = (columns.to_vec(), Vec::new());
        Self { title: title.into(), columns, rows, is_uniform: true }
    }

    /// A table whose rows have a unit each.
    pub(crate) fn of_quantities(title: impl Into<String>, columns: &[&'static str]) -> Self {
        Self { is_uniform: false, ..Self::new(title, columns) }
    }

    pub(crate) fn push(&mut self, row: Vec<Cell>) {
        self.rows.push(row);
    }
}

impl TextTable {
    /// Decade of a column's largest number, where all of them are shown alike.
    fn decade_of(&self, column: usize) -> Option<i32> {
        let numbers = self.rows.iter().filter_map(|row| match row.get(column)? {
            Cell::Number(Some(value)) | Cell::Known(value, _) if value.is_finite() => {
                Some(value.abs())
            }
            _ => None,
        });
        let largest = numbers.fold(0.0, f64::max);
        (self.is_uniform && largest > 0.0).then(|| decade(largest))
    }
}

fn show(cell: &Cell, decade_of_column: Option<i32>, least: i32) -> String {
    match (cell, decade_of_column) {
        // A name out of a file may hold anything; a terminal must not obey it.
        (Cell::Text(text), _) => {
            text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
        }
        (Cell::Known(value, Some(std)), _) if value.is_finite() && *std > 0.0 => {
            plain(&with_expanded(*value, *std).0)
        }
        (Cell::Expanded(Some(std)), _) => plain(&with_expanded(0.0, *std).1),
        (Cell::Number(Some(value)) | Cell::Known(value, _), Some(decade)) if value.is_finite() => {
            in_decade(*value, decade, least)
        }
        (Cell::Known(value, _), _) => number(Some(*value)),
        (Cell::Number(value) | Cell::Expanded(value), _) => number(*value),
    }
}

/// With the minus of a keyboard, so that what a terminal shows can be pasted into a program.
pub(crate) fn plain(text: &str) -> String {
    text.replace('−', "-")
}

/// `value ± U (k = 2) unit` to the digits that the uncertainty supports.
pub(crate) fn with_uncertainty(value: f64, std: f64, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    if std > 0.0 && (COVERAGE * std).is_finite() && value.is_finite() {
        let (value, expanded) = with_expanded(value, std);
        plain(&format!("{value} ± {expanded}{space}{unit}"))
    } else {
        format!("{}{space}{unit}", number(Some(value)))
    }
}

/// Least decimals by the unit that a header ends with, in brackets or not.
fn least_decimals(header: &str) -> i32 {
    let unit = header.rsplit([' ', '(']).next().unwrap_or("").trim_end_matches(')');
    LEAST_DECIMALS.iter().find(|(known, _)| *known == unit).map_or(0, |(_, decimals)| *decimals)
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        let decades: Vec<Option<i32>> =
            (0..self.columns.len()).map(|column| self.decade_of(column)).collect();
        let least: Vec<i32> = self.columns.iter().map(|header| least_decimals(header)).collect();
        let shown: Vec<Vec<String>> = (self.rows.iter().take(MAX_ROWS))
            .map(|row| {
                let cells = row.iter().zip(decades.iter().zip(&least));
                cells.map(|(cell, (decade, least))| show(cell, *decade, *least)).collect()
            })
            .collect();
        let width = |column: usize| {
            let cells = shown.iter().map(|row| row.get(column).map_or(0, |c| c.chars().count()));
            cells.max().unwrap_or(0).max(self.columns[column].chars().count())
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let is_text = |column: usize| {
            self.rows.first().is_some_and(|row| matches!(row.get(column), Some(Cell::Text(_))))
        };
        let mut line = |cells: &[&str]| {
            let mut text = String::from(" ");
            for (column, cell) in cells.iter().enumerate() {
                let width = widths[column];
                text.push(' ');
                if is_text(column) {
                    write!(text, "{cell:<width$}")?;
                } else {
                    write!(text, "{cell:>width$}")?;
                }
            }
            writeln!(f, "{}", text.trim_end())
        };
        line(&self.columns)?;
        for row in &shown {
            line(&row.iter().map(String::as_str).collect::<Vec<_>>())?;
        }
        if self.rows.len() > MAX_ROWS {
            writeln!(f, "  … and {} more (all of them with --json)", self.rows.len() - MAX_ROWS)?;
        }
        Ok(())
    }
}

/// A number with a few significant digits; a dash where there is none.
pub(crate) fn number(value: Option<f64>) -> String {
    match value.filter(|v| v.is_finite()) {
        None => "–".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) => in_decade(value, decade(value), 0),
    }
}

/// `value` to the digits that a number of `decade` needs, and to no fewer decimals than `least`.
fn in_decade(value: f64, decade: i32, least: i32) -> String {
    if !(-7..DIGITS + 4).contains(&decade) {
        return format!("{value:.3e}");
    }
    let decimals = usize::try_from((DIGITS - 1 - decade).max(least).clamp(0, 12)).unwrap_or(0);
    format!("{value:.decimals$}")
}

/// Decimal exponent of a finite number other than zero.
#[expect(clippy::cast_possible_truncation, reason = "exponents of f64 lie within ±324")]
fn decade(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

#[cfg(test)]
mod tests {
    use super::{Cell, EXPANDED, TextTable, number, with_uncertainty};

    #[test]
    fn numbers_read_well() {
        assert_eq!(number(Some(0.279_734)), "0.27973");
        assert_eq!(number(Some(-1_234.567_89)), "-1234.6");
        assert_eq!(number(Some(1.5e-9)), "1.500e-9");
        assert_eq!(number(Some(f64::NAN)), "–");
        assert_eq!(number(None), "–");
    }

    #[test]
    fn a_value_is_shown_to_the_place_of_its_uncertainty() {
        assert_eq!(with_uncertainty(-285.803_412_7, 0.000_165, "mm"), "-285.80341 ± 0.00033 mm");
        assert_eq!(with_uncertainty(1.0, 0.0498, "N"), "1.00 ± 0.10 N");
        assert_eq!(with_uncertainty(123_456.0, 600.0, ""), "123500 ± 1200");
        let mut table = TextTable::new("t", &["z (mm)", "z known", EXPANDED]);
        table.push(vec![
            (-285.803_41).into(),
            Cell::Known(-285.803_41, Some(2e-5)),
            Cell::Expanded(Some(2e-5)),
        ]);
        let shown = table.to_string();
        assert!(shown.contains("-285.80341 -285.803410  0.000040"), "{shown}");
    }

    #[test]
    fn columns_line_up_and_share_their_decimals() {
        let mut table = TextTable::new("t", &["point", "dx"]);
        table.push(vec!["long name".into(), 1.0.into()]);
        table.push(vec!["p\u{1b}".into(), None.into()]);
        table.push(vec!["q".into(), (-0.001_26).into()]);
        assert_eq!(
            table.to_string(),
            "t\n  point          dx\n  long name  1.0000\n  p\u{fffd}              –\n  q         -0.0013\n"
        );
    }
}
