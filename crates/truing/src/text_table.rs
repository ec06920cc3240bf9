use std::fmt::{self, Write as _};

use truing_report::{COVERAGE, after_number, with_expanded};

use crate::{Detail, Layout};

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
    let unit = after_number(unit);
    if std > 0.0 && (COVERAGE * std).is_finite() && value.is_finite() {
        let (value, expanded) = with_expanded(value, std);
        plain(&format!("{value} ± {expanded}{unit}"))
    } else {
        format!("{}{unit}", number(Some(value)))
    }
}

/// Least decimals by the unit that a header ends with, in brackets or not.
fn least_decimals(header: &str) -> i32 {
    let unit = header.rsplit([' ', '(']).next().unwrap_or("").trim_end_matches(')');
    LEAST_DECIMALS.iter().find(|(known, _)| *known == unit).map_or(0, |(_, decimals)| *decimals)
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout { detail: Detail::Full, columns: None })
    }
}

impl TextTable {
    /// Writes the table; one that is wider than the layout goes on below, under its first column.
    pub(crate) fn write(&self, out: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        writeln!(out, "{}", self.title)?;
        let shown = self.cells(layout.most_rows());
        let width = |column: usize| {
            let cells = shown.iter().map(|row| row.get(column).map_or(0, |c| c.chars().count()));
            cells.max().unwrap_or(0).max(self.columns[column].chars().count())
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        for (n, columns) in in_parts(&widths, layout.columns).iter().enumerate() {
            if n > 0 {
                writeln!(out)?;
            }
            self.write_line(out, &self.columns, (columns, &widths))?;
            for row in &shown {
                let row: Vec<&str> = row.iter().map(String::as_str).collect();
                self.write_line(out, &row, (columns, &widths))?;
            }
        }
        let more = self.rows.len() - shown.len();
        let all = if layout.detail == Detail::Full { "--json" } else { "-v or --json" };
        if more > 0 {
            writeln!(out, "  … and {more} more ({all})")?;
        }
        Ok(())
    }

    /// The first rows as they are shown.
    fn cells(&self, most_rows: usize) -> Vec<Vec<String>> {
        let decades: Vec<Option<i32>> =
            (0..self.columns.len()).map(|column| self.decade_of(column)).collect();
        let least: Vec<i32> = self.columns.iter().map(|header| least_decimals(header)).collect();
        // To leave out one or two takes as much room as they do.
        let rows = if self.rows.len() <= most_rows + 2 { self.rows.len() } else { most_rows };
        (self.rows.iter().take(rows))
            .map(|row| {
                let cells = row.iter().zip(decades.iter().zip(&least));
                cells.map(|(cell, (decade, least))| show(cell, *decade, *least)).collect()
            })
            .collect()
    }

    fn write_line(
        &self,
        out: &mut dyn fmt::Write,
        cells: &[&str],
        (columns, widths): (&[usize], &[usize]),
    ) -> fmt::Result {
        let is_text = |column: usize| {
            self.rows.first().is_some_and(|row| matches!(row.get(column), Some(Cell::Text(_))))
        };
        let mut text = String::from(" ");
        for &column in columns {
            let (cell, width) = (cells.get(column).copied().unwrap_or(""), widths[column]);
            text.push(' ');
            if is_text(column) {
                write!(text, "{cell:<width$}")?;
            } else {
                write!(text, "{cell:>width$}")?;
            }
        }
        writeln!(out, "{}", text.trim_end())
    }
}

/// Columns that stand beside one another, the first one in every part.
fn in_parts(widths: &[usize], limit: Option<usize>) -> Vec<Vec<usize>> {
    let limit = limit.unwrap_or(usize::MAX);
    // A space before the first column, and one before each.
    let width = |columns: &[usize]| 1 + columns.iter().map(|&c| 1 + widths[c]).sum::<usize>();
    let mut parts = vec![vec![0]];
    for column in 1..widths.len() {
        let last = parts.last_mut().expect("never empty");
        last.push(column);
        if width(last) > limit && last.len() > 2 {
            last.pop();
            parts.push(vec![0, column]);
        }
    }
    parts
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
    let text = format!("{value:.decimals$}");
    // What is rounded to nothing has no sign.
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        _ => text,
    }
}

/// Decimal exponent of a finite number other than zero.
#[expect(clippy::cast_possible_truncation, reason = "exponents of f64 lie within ±324")]
fn decade(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

#[cfg(test)]
mod tests {
    use super::{Cell, EXPANDED, TextTable, in_decade, number, with_uncertainty};
    use crate::{Detail, Layout};

    #[test]
    fn numbers_read_well() {
        assert_eq!(number(Some(0.279_734)), "0.27973");
        assert_eq!(number(Some(-1_234.567_89)), "-1234.6");
        assert_eq!(number(Some(1.5e-9)), "1.500e-9");
        assert_eq!(in_decade(-4e-7, 0, 4), "0.0000");
        assert_eq!(in_decade(-6e-5, 0, 4), "-0.0001");
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

    #[test]
    fn a_table_that_is_too_wide_goes_on_below_under_its_first_column() {
        let mut table = TextTable::new("t", &["point", "dx", "dy", "dz"]);
        for point in ["a", "b"] {
            table.push(vec![point.into(), 1.0.into(), 2.0.into(), 3.0.into()]);
        }
        let written = |columns: usize| {
            let mut text = String::new();
            table
                .write(&mut text, Layout { detail: Detail::Full, columns: Some(columns) })
                .unwrap();
            text
        };
        assert_eq!(written(28), table.to_string());
        let below = "t\n  point     dx     dy\n  a     1.0000 2.0000\n  b     1.0000 2.0000\n\n  \
                     point     dz\n  a     3.0000\n  b     3.0000\n";
        assert_eq!(written(27), below);
        // No width is too small for a column beside the first.
        assert_eq!(written(1).lines().count(), 1 + 3 * 3 + 2);
    }

    #[test]
    fn long_tables_are_cut_and_say_so() {
        let mut table = TextTable::new("t", &["point"]);
        for i in 0..15 {
            table.push(vec![format!("p{i}").into()]);
        }
        let mut text = String::new();
        table.write(&mut text, Layout::default()).unwrap();
        assert!(text.contains("p11\n") && !text.contains("p12\n"), "{text}");
        assert!(text.ends_with("… and 3 more (-v or --json)\n"), "{text}");
    }
}
