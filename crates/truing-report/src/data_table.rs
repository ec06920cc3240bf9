//! The numbers behind a picture, as a file for a spreadsheet that the page itself holds.

use std::fmt::Write as _;

use super::markup::Markup;
use super::number::count;
use super::slug::slug;
use super::thin;

/// Cells of one table: of more, so few rows are kept that a page of many stays below 2 MB.
const MOST_CELLS: usize = 8_000;

/// Columns with their units, and rows as long as there are columns.
#[derive(Clone, Debug)]
pub(crate) struct DataTable {
    columns: Vec<String>,
    rows: Vec<Vec<Datum>>,
}

/// One cell.
#[derive(Clone, Debug)]
pub(crate) enum Datum {
    /// Written with the digits below; empty where it is no number.
    Number(f64),
    Text(String),
}

impl From<f64> for Datum {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for Datum {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl DataTable {
    pub(crate) fn new<C: Into<String>>(columns: impl IntoIterator<Item = C>) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    pub(crate) fn push(&mut self, row: impl IntoIterator<Item = Datum>) {
        self.rows.push(row.into_iter().collect());
    }

    /// A link that saves the table under the name of its picture. It needs neither a network nor
    /// JavaScript; nothing is written of a table without rows.
    pub(crate) fn link(&self, out: &mut Markup, picture: &str) {
        if self.rows.is_empty() {
            return;
        }
        let stride = thin::stride(self.rows.len() * self.columns.len(), MOST_CELLS);
        let address = format!("data:text/csv;charset=utf-8,{}", encoded(&self.csv(stride)));
        let name = format!("{}.csv", slug(picture));
        out.open("p", &[("class", &"data")]);
        out.element("a", &[("download", &name), ("href", &address)], "data as CSV");
        if stride > 1 {
            out.text(&format!(" (one row in {stride} of {})", count(self.rows.len())));
        }
        out.close("p");
    }

    /// The head and every `stride`-th row.
    fn csv(&self, stride: usize) -> String {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let head = line(self.columns.iter().map(|title| quoted(title)).collect());
        let rows = self.rows.iter().step_by(stride);
        rows.fold(head, |csv, row| csv + &line(row.iter().map(Datum::cell).collect()))
    }
}

/// Digits after the first of a number: a part in ten million of what is drawn to a part in a
/// thousand.
const DECIMALS: usize = 6;

impl Datum {
    fn cell(&self) -> String {
        match self {
            Self::Text(text) => quoted(text),
            Self::Number(value) if value.is_finite() => {
                let rounded: f64 = format!("{value:.DECIMALS$e}").parse().unwrap_or(*value);
                // `-0` and hundreds of zeros are written by nobody.
                let size = rounded.abs();
                if (1e-4..1e7).contains(&size) || size == 0.0 {
                    format!("{}", rounded + 0.0)
                } else {
                    format!("{rounded:e}")
                }
            }
            Self::Number(_) => String::new(),
        }
    }
}

/// A cell of text, between double quotes where it needs them.
fn quoted(text: &str) -> String {
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if line.contains(['"', ',', ';']) { format!("\"{}\"", line.replace('"', "\"\"")) } else { line }
}

/// Text as a `data:` address holds it: everything with a meaning of its own as `%…`.
fn encoded(text: &str) -> String {
    text.bytes().fold(String::with_capacity(2 * text.len()), |mut address, byte| {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b',' | b'_') {
            address.push(char::from(byte));
        } else {
            write!(address, "%{byte:02X}").expect("a String takes any text");
        }
        address
    })
}

#[cfg(test)]
mod tests {
    use super::{DataTable, Datum, encoded};

    #[test]
    fn cells_are_what_a_spreadsheet_reads() {
        let mut table = DataTable::new(["name", "x, mm"]);
        table.push(["a \"b\", c".into(), Datum::Number(1.0 / 3.0)]);
        table.push(["d\ne".into(), f64::NAN.into()]);
        table.push(["".into(), Datum::Number(-1.25e-9)]);
        let csv = "name,\"x, mm\"\n\"a \"\"b\"\", c\",0.3333333\nd e,\n,-1.25e-9\n";
        assert_eq!(table.csv(1), csv);
        assert_eq!(table.csv(2).lines().count(), 3);
    }

    #[test]
    fn addresses_hold_nothing_with_a_meaning_of_its_own() {
        assert_eq!(encoded("µ <&\"'%#\n"), "%C2%B5%20%3C%26%22%27%25%23%0A");
    }
}
