use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use super::cells::Cells;
use super::dialect::{MixedSeparators, Separator, Writing, separator, with_point, writing};
use super::ledger::Ledger;
use super::unit::{Conversion, conversion};
use super::{Location, Problem};
use crate::Error;

/// Widest table read: every further column is one more thing to search the residual for.
const MAX_COLUMNS: usize = 512;

/// A table: the header and columns of as many cells, trimmed. One made of another shares the columns that it
/// leaves as they are.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    file: Location,
    names: Vec<String>,
    header_line: usize,
    lines: Arc<Vec<usize>>,
    columns: Vec<Arc<Cells>>,
    ledger: Ledger,
}

impl Table {
    /// Reads `text`; `columns` are the ones to name when the file is empty.
    pub(crate) fn read(
        file: Location,
        text: &str,
        columns: &[&str],
        ledger: &Ledger,
    ) -> Result<Self, Error> {
        let separator = separator(text).map_err(|MixedSeparators { first, second }| {
            Error::case(file.clone(), Problem::MixedSeparators { first, second })
        })?;
        let start = separator.declared.unwrap_or(0);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .delimiter(u8::try_from(separator.character).unwrap_or(b','))
            .from_reader(&text.as_bytes()[start..]);
        let mut lines = LineCounter { text: text.as_bytes(), offset: 0, line: 1 };
        let mut record = csv::StringRecord::new();
        let mut rows: Option<Rows> = None;
        while next_record(&mut reader, &mut record, &file)? {
            let at = record.position().map_or(0, csv::Position::byte);
            let line = lines.line_of_record(start + usize::try_from(at).unwrap_or(usize::MAX));
            if record.iter().all(|cell| cell.trim().is_empty()) {
                if let Some(rows) = &mut rows {
                    rows.n_empty += usize::from(record.len() > 1);
                }
                continue;
            }
            match &mut rows {
                None => rows = Some(Rows::below(file.clone(), &record, line, separator)?),
                Some(rows) => rows.push(&record, line)?,
            }
        }
        let columns = columns.iter().map(|c| (*c).to_owned()).collect();
        let rows =
            rows.ok_or_else(|| Error::case(file.clone().line(1), Problem::EmptyTable { columns }))?;
        if rows.table.lines.is_empty() {
            return Err(Error::case(file.line(rows.table.header_line), Problem::NoRows));
        }
        rows.finish(ledger)
    }

    /// Puts a point for the comma of every number.
    fn write_points(&mut self) {
        fn of(cell: &str) -> Cow<'_, str> {
            if writing(cell) == Writing::Plain { cell.into() } else { with_point(cell).into() }
        }
        let n_rows = self.lines.len();
        for cells in &mut self.columns {
            let with_points = Cells::of_texts((0..n_rows).map(|row| of(cells.text(row))));
            *cells = Arc::new(with_points);
        }
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.lines.len()
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    pub(crate) fn cell(&self, row: usize, column: usize) -> &str {
        self.columns[column].text(row)
    }

    /// A cell as a number, where it is one.
    pub(crate) fn number(&self, row: usize, column: usize) -> Option<f64> {
        self.columns[column].number(row)
    }

    /// The column of that name, or of the same quantity in another unit, with how it is read.
    pub(crate) fn read_as(&self, name: &str) -> Option<(usize, Option<Conversion>)> {
        let exact = self.column(name).map(|column| (column, None));
        let in_another = || {
            let mut found = self.names.iter().enumerate();
            found.find_map(|(column, found)| Some((column, Some(conversion(found, name)?))))
        };
        exact.or_else(in_another)
    }

    /// What one of the unit in which the table has some columns is in that of their names; `None` where it has
    /// them in different ones, or not all of them.
    pub(crate) fn unit_of(&self, names: &[&str]) -> Option<f64> {
        let one = |name: &&str| {
            let (_, conversion) = self.read_as(name)?;
            Some(conversion.map_or(1.0, |conversion| conversion.of(1.0)))
        };
        let first = one(names.first()?)?;
        names.iter().all(|name| one(name) == Some(first)).then_some(first)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.read_as(name).is_some()
    }

    /// The numbers of a column, in the unit of the name; `None` where there is no such column, or a cell is not
    /// a number.
    pub(crate) fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let (column, conversion) = self.read_as(name)?;
        let of = |value: f64| conversion.map_or(value, |conversion| conversion.of(value));
        Some(self.columns[column].numbers()?.iter().copied().map(of).collect())
    }

    /// All rows with the cells that `cell` gives.
    pub(crate) fn rewritten(
        &self,
        cell: impl for<'c> Fn(&'c Self, usize, usize) -> Cow<'c, str>,
    ) -> Self {
        let column = |column| {
            Arc::new(Cells::of_texts((0..self.n_rows()).map(|row| cell(self, row, column))))
        };
        Self { columns: (0..self.names.len()).map(column).collect(), ..self.clone() }
    }

    /// The rows listed, in that order, or all; with other columns in them where `other` gives them.
    pub(super) fn with(
        &self,
        kept: Option<&[usize]>,
        other: impl Fn(usize) -> Option<Arc<Cells>>,
    ) -> Self {
        let column = |column| other(column).unwrap_or_else(|| self.of_rows(kept, column));
        Self {
            lines: kept.map_or_else(
                || Arc::clone(&self.lines),
                |rows| Arc::new(rows.iter().map(|&row| self.lines[row]).collect()),
            ),
            columns: (0..self.names.len()).map(column).collect(),
            file: self.file.clone(),
            names: self.names.clone(),
            header_line: self.header_line,
            ledger: self.ledger.clone(),
        }
    }

    /// A column of the rows listed, in that order, or of all.
    pub(super) fn of_rows(&self, kept: Option<&[usize]>, column: usize) -> Arc<Cells> {
        let cells = &self.columns[column];
        kept.map_or_else(
            || Arc::clone(cells),
            |rows| Arc::new(Cells::picked(rows.iter().map(|row| (&**cells, *row)))),
        )
    }

    /// The cells of a column.
    pub(super) fn cells(&self, column: usize) -> &Cells {
        &self.columns[column]
    }

    /// The table with further columns, of one cell per row that it has, and further rows, of one
    /// cell per column; these have the lines below the last.
    pub(crate) fn appended(&self, columns: &[(String, Vec<String>)], rows: &[Vec<String>]) -> Self {
        let added = columns.iter().map(|(_, cells)| Arc::new(Cells::of_texts(cells)));
        let mut all: Vec<Arc<Cells>> = self.columns.iter().cloned().chain(added).collect();
        for row in rows {
            for (cells, cell) in all.iter_mut().zip(row) {
                Arc::make_mut(cells).push(cell);
            }
        }
        let last = self.lines.last().copied().unwrap_or(self.header_line);
        let lines = self.lines.iter().copied().chain((1..=rows.len()).map(|n| last + n));
        let names = self.names.iter().chain(columns.iter().map(|(name, _)| name));
        Self {
            names: names.cloned().collect(),
            lines: Arc::new(lines.collect()),
            columns: all,
            ..self.clone()
        }
    }

    /// The table as text, its cells separated by commas.
    pub(crate) fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let written = "a table in memory takes what is written";
        writer.write_record(&self.names).expect(written);
        for row in 0..self.n_rows() {
            let cells = (0..self.names.len()).map(|column| self.cell(row, column));
            writer.write_record(cells).expect(written);
        }
        let bytes = writer.into_inner().expect(written);
        String::from_utf8(bytes).expect("cells are text")
    }

    pub(crate) fn line(&self, row: usize) -> usize {
        self.lines[row]
    }

    /// Says what was understood of this table.
    pub(crate) fn note(&self, note: String) {
        self.ledger.note(&self.file, note);
    }

    pub(crate) fn at_file(&self) -> Location {
        self.file.clone()
    }

    pub(crate) fn at_header(&self) -> Location {
        self.file.clone().line(self.header_line)
    }

    pub(crate) fn at_row(&self, row: usize) -> Location {
        self.file.clone().line(self.lines[row])
    }

    pub(crate) fn at_column(&self, column: usize) -> Location {
        self.at_header().column(column + 1)
    }

    pub(crate) fn at_cell(&self, row: usize, column: usize) -> Location {
        self.at_row(row).column(column + 1).name(&self.names[column])
    }
}

/// A table on the way in.
struct Rows {
    table: Table,
    separator: Separator,
    /// Cells of the header, those without a name at its end included.
    width: usize,
    /// Rows in which nothing stands.
    n_empty: usize,
    has_empty_columns: bool,
}

impl Rows {
    fn below(
        file: Location,
        record: &csv::StringRecord,
        line: usize,
        separator: Separator,
    ) -> Result<Self, Error> {
        let at = file.clone().line(line);
        let mut names: Vec<String> = record.iter().map(|cell| cell.trim().to_owned()).collect();
        let named = names.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1);
        names.truncate(named);
        check_header(&at, &names)?;
        let columns = names.iter().map(|_| Arc::default()).collect();
        let table = Table {
            file,
            names,
            header_line: line,
            lines: Arc::default(),
            columns,
            ledger: Ledger::default(),
        };
        let (width, has_empty_columns) = (record.len(), record.len() > named);
        Ok(Self { table, separator, width, n_empty: 0, has_empty_columns })
    }

    fn push(&mut self, record: &csv::StringRecord, line: usize) -> Result<(), Error> {
        let table = &mut self.table;
        let named = table.names.len();
        let at = || table.file.clone().line(line);
        if let Some(column) = record.iter().position(|cell| cell.contains(['\n', '\r'])) {
            return Err(Error::case(at().column(column + 1), Problem::LineBreakInCell));
        }
        let beyond = record.iter().skip(named).position(|cell| !cell.trim().is_empty());
        if let Some(beyond) = beyond.filter(|beyond| named + beyond < self.width) {
            return Err(Error::case(table.at_column(named + beyond), Problem::UnnamedColumn));
        }
        if record.len() < named || beyond.is_some() {
            let (expected, found) = (named, record.len());
            let column = expected.min(found) + 1;
            let separator = self.separator.name;
            let problem = Problem::RaggedRow { expected, found, separator };
            return Err(Error::case(at().column(column), problem));
        }
        self.has_empty_columns |= record.len() > named;
        for (cells, cell) in table.columns.iter_mut().zip(record) {
            Arc::make_mut(cells).push(cell.trim());
        }
        Arc::make_mut(&mut table.lines).push(line);
        Ok(())
    }

    fn finish(mut self, ledger: &Ledger) -> Result<Table, Error> {
        self.table.ledger = ledger.clone();
        let has_comma = self.separator.character != ',' && decimals_have_comma(&self.table)?;
        if self.separator.declared.is_some() || self.separator.character != ',' {
            let decimals = if has_comma { ", decimals with a comma" } else { "" };
            self.table.note(format!("cells separated by {}s{decimals}", self.separator.name));
        }
        if has_comma {
            self.table.write_points();
        }
        let rows = match self.n_empty {
            0 => None,
            1 => Some("1 empty row".to_owned()),
            n => Some(format!("{n} empty rows")),
        };
        let columns = self.has_empty_columns.then(|| "empty columns at the right".to_owned());
        let left: Vec<String> = rows.into_iter().chain(columns).collect();
        if !left.is_empty() {
            self.table.note(format!("{} left aside", left.join(" and ")));
        }
        Ok(self.table)
    }
}

/// Whether the numbers have a comma before their decimals; an error where that cannot be told.
fn decimals_have_comma(table: &Table) -> Result<bool, Error> {
    let (mut point, mut comma, mut either) = (None, None, None);
    for row in 0..table.n_rows() {
        for column in 0..table.names.len() {
            let first = match writing(table.cell(row, column)) {
                Writing::Plain => continue,
                Writing::Groups => {
                    let found = table.cell(row, column).to_owned();
                    let problem = Problem::GroupedDigits { found };
                    return Err(Error::case(table.at_cell(row, column), problem));
                }
                Writing::Point => &mut point,
                Writing::Comma => &mut comma,
                Writing::CommaOrGroups => &mut either,
            };
            *first = first.or(Some((row, column)));
        }
    }
    let cell = |(row, column): (usize, usize)| table.cell(row, column).to_owned();
    let Some(with_comma) = comma.or(either) else { return Ok(false) };
    if let Some((row, column)) = point {
        let (found, other) = (cell((row, column)), cell(with_comma));
        let problem = Problem::MixedDecimals { found, other, line: table.line(with_comma.0) };
        return Err(Error::case(table.at_cell(row, column), problem));
    }
    if comma.is_none() {
        let (row, column) = with_comma;
        let problem = Problem::CommaOrGroups { found: cell(with_comma) };
        return Err(Error::case(table.at_cell(row, column), problem));
    }
    Ok(true)
}

fn next_record(
    reader: &mut csv::Reader<&[u8]>,
    record: &mut csv::StringRecord,
    file: &Location,
) -> Result<bool, Error> {
    reader
        .read_record(record)
        .map_err(|e| Error::case(file.clone(), Problem::WrongValue { message: e.to_string() }))
}

fn check_header(at: &Location, names: &[String]) -> Result<(), Error> {
    if names.len() > MAX_COLUMNS {
        let problem = Problem::TooManyColumns { got: names.len(), limit: MAX_COLUMNS };
        return Err(Error::case(at.clone(), problem));
    }
    if names.iter().all(|name| with_point(name).parse::<f64>().is_ok()) {
        return Err(Error::case(at.clone(), Problem::NoHeader));
    }
    let mut first_use = HashMap::new();
    for (i, name) in names.iter().enumerate() {
        let at = || at.clone().column(i + 1);
        if name.is_empty() {
            return Err(Error::case(at(), Problem::UnnamedColumn));
        }
        if name.contains(['\n', '\r']) {
            return Err(Error::case(at(), Problem::LineBreakInCell));
        }
        if let Some(first) = first_use.insert(name.as_str(), i + 1) {
            let problem = Problem::DuplicateColumn { column: name.clone(), first };
            return Err(Error::case(at(), problem));
        }
    }
    Ok(())
}

/// Line numbers of records: the reader's own count stops at the comments before a record.
struct LineCounter<'t> {
    text: &'t [u8],
    offset: usize,
    line: usize,
}

impl LineCounter<'_> {
    fn line_of_record(&mut self, start: usize) -> usize {
        self.advance_to(start.min(self.text.len()));
        loop {
            match self.text.get(self.offset) {
                Some(b'\n' | b'\r') => self.advance_to(self.offset + 1),
                Some(b'#') => {
                    let rest = &self.text[self.offset..];
                    let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
                    self.advance_to(self.offset + length.unwrap_or(rest.len()));
                }
                _ => return self.line,
            }
        }
    }

    fn advance_to(&mut self, offset: usize) {
        while self.offset < offset {
            let byte = self.text[self.offset];
            self.offset += 1;
            let ends_line =
                byte == b'\n' || byte == b'\r' && self.text.get(self.offset) != Some(&b'\n');
            self.line += usize::from(ends_line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Ledger, Location, Table};

    fn read(text: &str) -> Table {
        Table::read(Location::file("t.csv"), text, &["a"], &Ledger::default()).unwrap()
    }

    #[test]
    fn lines_are_counted_through_comments_blank_lines_and_any_line_end() {
        let text = "# one\n\n#three\r\na, b \r\n1,2\r\n\r\n# seven\n 3 ,4\r5,6";
        let table = read(text);
        assert_eq!(table.names(), ["a", "b"]);
        assert_eq!(table.at_header().line, Some(4));
        assert_eq!([0, 1, 2].map(|row| table.line(row)), [5, 8, 9]);
        assert_eq!([table.cell(1, 0), table.cell(2, 1)], ["3", "6"]);
    }

    #[test]
    fn lines_are_counted_below_a_declared_separator() {
        let table = read("sep=;\r\n# two\r\na;b\r\n\r\n1,5;2\r\n");
        assert_eq!((table.at_header().line, table.line(0)), (Some(3), 5));
        assert_eq!([table.cell(0, 0), table.cell(0, 1)], ["1.5", "2"]);
    }

    #[test]
    fn quoted_cells_keep_their_commas_and_lose_their_quotes() {
        let table = read("a,b\n\"x, \"\"y\"\"\",2\n");
        assert_eq!(table.cell(0, 0), "x, \"y\"");
        assert_eq!(table.cell(0, 1), "2");
    }
}
