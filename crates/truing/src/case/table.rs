use std::collections::HashMap;

use super::{Location, Problem};
use crate::Error;

/// Widest table read: every further column is one more thing to search the residual for.
const MAX_COLUMNS: usize = 512;

/// A table as text: the header and rows of as many cells, trimmed.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    file: Location,
    names: Vec<String>,
    header_line: usize,
    lines: Vec<usize>,
    text: String,
    /// End of every cell in `text`, row by row.
    ends: Vec<usize>,
}

impl Table {
    /// Reads `text`; `columns` are the ones to name when the file is empty.
    pub(crate) fn read(file: Location, text: &str, columns: &[&str]) -> Result<Self, Error> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let mut lines = LineCounter { text: text.as_bytes(), offset: 0, line: 1 };
        let mut record = csv::StringRecord::new();
        let mut table: Option<Self> = None;
        while next_record(&mut reader, &mut record, &file)? {
            let start = record.position().map_or(0, csv::Position::byte);
            let line = lines.line_of_record(usize::try_from(start).unwrap_or(usize::MAX));
            if record.len() == 1 && record[0].trim().is_empty() {
                continue;
            }
            match &mut table {
                None => table = Some(Self::with_header(file.clone(), &record, line)?),
                Some(table) => table.push(&record, line)?,
            }
        }
        let columns = columns.iter().map(|c| (*c).to_owned()).collect();
        let table = table
            .ok_or_else(|| Error::case(file.clone().line(1), Problem::EmptyTable { columns }))?;
        if table.lines.is_empty() {
            return Err(Error::case(file.line(table.header_line), Problem::NoRows));
        }
        Ok(table)
    }

    fn with_header(file: Location, record: &csv::StringRecord, line: usize) -> Result<Self, Error> {
        let at = file.clone().line(line);
        let names: Vec<String> = record.iter().map(|cell| cell.trim().to_owned()).collect();
        check_header(&at, &names)?;
        Ok(Self {
            file,
            names,
            header_line: line,
            lines: Vec::new(),
            text: String::new(),
            ends: Vec::new(),
        })
    }

    fn push(&mut self, record: &csv::StringRecord, line: usize) -> Result<(), Error> {
        let at = || self.file.clone().line(line);
        if let Some(column) = record.iter().position(|cell| cell.contains(['\n', '\r'])) {
            return Err(Error::case(at().column(column + 1), Problem::LineBreakInCell));
        }
        if record.len() != self.names.len() {
            let (expected, found) = (self.names.len(), record.len());
            let column = expected.min(found) + 1;
            return Err(Error::case(at().column(column), Problem::RaggedRow { expected, found }));
        }
        for cell in record {
            self.text.push_str(cell.trim());
            self.ends.push(self.text.len());
        }
        self.lines.push(line);
        Ok(())
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
        let index = row * self.names.len() + column;
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        &self.text[start..self.ends[index]]
    }

    pub(crate) fn line(&self, row: usize) -> usize {
        self.lines[row]
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
    if let [only] = names
        && let Some(separator) = [(';', "semicolon"), ('\t', "tab")]
            .into_iter()
            .find_map(|(c, name)| only.contains(c).then_some(name))
    {
        return Err(Error::case(at.clone().column(1), Problem::WrongSeparator { separator }));
    }
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
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
    use super::{Location, Table};

    fn read(text: &str) -> Table {
        Table::read(Location::file("t.csv"), text, &["a"]).unwrap()
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
    fn quoted_cells_keep_their_commas_and_lose_their_quotes() {
        let table = read("a,b\n\"x, \"\"y\"\"\",2\n");
        assert_eq!(table.cell(0, 0), "x, \"y\"");
        assert_eq!(table.cell(0, 1), "2");
    }
}
