use std::collections::HashMap;

use super::column_kinds::ColumnKinds;
use super::extras::Extras;
use super::nearest::{distance, nearest};
use super::number::{MAX_MAGNITUDE, MIN_POSITIVE};
use super::quote::quote;
use super::table::Table;
use super::unit::{Conversion, conversion, differs_in_unit, unit_of};
use super::{Location, Problem};
use crate::Error;

/// Takes the columns that a kind knows out of a table; what is left is covariates and labels.
#[derive(Debug)]
pub(crate) struct Columns<'t> {
    table: &'t Table,
    known: &'static [&'static str],
    taken: Vec<bool>,
    /// How the values of a column become those of the known one that it stands for.
    conversions: Vec<Option<Conversion>>,
}

impl<'t> Columns<'t> {
    /// `known` are all the columns that the kind may ask for.
    pub(crate) fn new(table: &'t Table, known: &'static [&'static str]) -> Self {
        let of = |found: &String| known.iter().find_map(|known| conversion(found, known));
        let conversions = table.names().iter().map(of).collect();
        Self { table, known, taken: vec![false; table.names().len()], conversions }
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    /// The column called `name`, or else one of the same quantity in a unit that is converted.
    fn find(&self, name: &str) -> Option<usize> {
        self.table.read_as(name).map(|(column, _)| column)
    }

    fn in_other_units(&self, name: &str) -> impl Iterator<Item = usize> {
        let names = self.table.names().iter().enumerate();
        names.filter(move |(_, found)| conversion(found, name).is_some()).map(|(column, _)| column)
    }

    /// Where the column called `name` stands in the header.
    pub(crate) fn at(&self, name: &str) -> Location {
        match self.find(name) {
            Some(column) => self.table.at_column(column),
            None => self.table.at_header(),
        }
    }

    /// A column of finite numbers.
    pub(crate) fn numbers(&mut self, name: &'static str) -> Result<Vec<f64>, Error> {
        let column = self.take(name)?;
        (0..self.table.n_rows()).map(|row| self.number(row, column)).collect()
    }

    /// A column of standard uncertainties.
    pub(crate) fn positives(&mut self, name: &'static str) -> Result<Vec<f64>, Error> {
        let column = self.take(name)?;
        let positive = |row| {
            let value = self.number(row, column)?;
            if value > MIN_POSITIVE {
                return Ok(value);
            }
            let found = self.table.cell(row, column).to_owned();
            let expected = format!("a positive number{}", in_unit(name));
            let problem = Problem::NotPositive { found, expected, limit: MIN_POSITIVE };
            Err(Error::case(self.table.at_cell(row, column), problem))
        };
        (0..self.table.n_rows()).map(positive).collect()
    }

    /// A column of text without empty cells.
    pub(crate) fn texts(&mut self, name: &'static str) -> Result<Vec<&'t str>, Error> {
        let column = self.take(name)?;
        let table = self.table;
        let text = |row| match table.cell(row, column) {
            "" => {
                let expected = format!("the name of a {name}");
                Err(Error::case(table.at_cell(row, column), Problem::EmptyCell { expected }))
            }
            text => Ok(text),
        };
        (0..table.n_rows()).map(text).collect()
    }

    /// A column of names of which none may occur twice.
    pub(crate) fn ids(&mut self, name: &'static str) -> Result<Vec<&'t str>, Error> {
        let ids = self.texts(name)?;
        let mut first_use = HashMap::new();
        for (row, id) in ids.iter().enumerate() {
            if let Some(first) = first_use.insert(*id, row) {
                let column = self.table.column(name).unwrap_or_default();
                let (id, first) = ((*id).to_owned(), self.table.line(first));
                let problem = Problem::DuplicateId { what: name, id, first };
                return Err(Error::case(self.table.at_cell(row, column), problem));
            }
        }
        Ok(ids)
    }

    /// A column of words from a list; empty cells, and a column that is absent, mean `default`.
    pub(crate) fn words<T: Copy>(
        &mut self,
        name: &'static str,
        words: &[(&str, T)],
        default: Option<T>,
    ) -> Result<Vec<T>, Error> {
        let table = self.table;
        let column = match (self.table.column(name), default) {
            (None, Some(default)) => return Ok(vec![default; table.n_rows()]),
            _ => self.take(name)?,
        };
        let word = |row| {
            let cell = table.cell(row, column);
            let found = words.iter().find(|(word, _)| *word == cell).map(|(_, value)| *value);
            found
                .or(if cell.is_empty() { default } else { None })
                .ok_or_else(|| Error::case(table.at_cell(row, column), unknown_word(cell, words)))
        };
        (0..table.n_rows()).map(word).collect()
    }

    /// The columns nobody asked for.
    ///
    /// One whose name is that of an absent known column but for the unit or the letter case
    /// is an error; one with a similar name is a warning. `kinds` say what the others hold.
    pub(crate) fn rest(self, kinds: &ColumnKinds) -> Result<Extras, Error> {
        let mut extras = Extras::default();
        for (column, name) in self.table.names().iter().enumerate() {
            if self.taken[column] {
                continue;
            }
            let absent = || self.known.iter().copied().filter(|known| !self.has(known));
            if let Some(problem) = absent().find_map(|known| slip(name, known)) {
                return Err(Error::case(self.table.at_column(column), problem));
            }
            if let Some(known) = absent().find(|known| distance_is_small(name, known)) {
                extras.warnings.push(format!(
                    "{}: column `{name}` is none of this table's own; did you mean `{known}`?",
                    self.table.at_column(column)
                ));
            }
            extras.add(self.table, column, kinds);
        }
        Ok(extras)
    }

    fn take(&mut self, name: &'static str) -> Result<usize, Error> {
        let column = self.find(name).ok_or_else(|| self.missing(name))?;
        if let Some(other) = self.in_other_units(name).find(|other| *other != column) {
            let names = self.table.names();
            let (column, other) = (names[column].clone(), names[other].clone());
            let at = self.table.at_column(self.table.column(&other).unwrap_or_default());
            return Err(Error::case(at, Problem::ExclusiveColumns { column, other }));
        }
        if let Some(conversion) = self.conversions[column] {
            let found = quote(&self.table.names()[column]);
            self.table.note(format!("{found} read as `{name}`, {conversion}"));
        }
        self.taken[column] = true;
        Ok(column)
    }

    /// A cell as a number in the unit of the known column.
    fn number(&self, row: usize, column: usize) -> Result<f64, Error> {
        number(self.table, row, column, self.conversions[column])
    }

    fn missing(&self, name: &'static str) -> Error {
        let names = self.table.names();
        let free = || names.iter().enumerate().filter(|(_, n)| !self.known.contains(&n.as_str()));
        if let Some((column, found)) = free().find(|(_, n)| differs_in_unit(n, name)) {
            let problem = Problem::WrongUnit { found: found.clone(), expected: name.to_owned() };
            return Error::case(self.table.at_column(column), problem);
        }
        let nearest = nearest(name, free().map(|(_, n)| n.as_str()));
        let at = nearest.map_or_else(|| self.table.at_header(), |n| self.at(n));
        let nearest = nearest.map(str::to_owned);
        Error::case(at, Problem::MissingColumn { column: name.to_owned(), nearest })
    }
}

fn number(
    table: &Table,
    row: usize,
    column: usize,
    conversion: Option<Conversion>,
) -> Result<f64, Error> {
    let converted = |value| conversion.map_or(value, |conversion| conversion.of(value));
    let number = table.number(row, column).map(converted);
    if let Some(value) = number.filter(|value| value.abs() < MAX_MAGNITUDE) {
        return Ok(value);
    }
    let found = table.cell(row, column).to_owned();
    let expected = format!("a number{}", in_unit(&table.names()[column]));
    let problem = match number {
        Some(_) => Problem::OutOfRange { found, expected, limit: MAX_MAGNITUDE },
        None if found.is_empty() => Problem::EmptyCell { expected },
        None => Problem::NotANumber { found, expected },
    };
    Err(Error::case(table.at_cell(row, column), problem))
}

fn in_unit(name: &str) -> String {
    unit_of(name).map_or_else(String::new, |unit| format!(" in {unit}"))
}

fn unknown_word<T>(cell: &str, words: &[(&str, T)]) -> Problem {
    let expected: Vec<String> = words.iter().map(|(word, _)| (*word).to_owned()).collect();
    if cell.is_empty() {
        return Problem::EmptyCell { expected: expected.join(" or ") };
    }
    let nearest = nearest(cell, words.iter().map(|(word, _)| *word)).map(str::to_owned);
    Problem::UnknownWord { found: cell.to_owned(), nearest, expected }
}

fn slip(found: &str, known: &str) -> Option<Problem> {
    let (found, expected) = (found.to_owned(), known.to_owned());
    if differs_in_unit(&found, known) {
        Some(Problem::WrongUnit { found, expected })
    } else if found.eq_ignore_ascii_case(known) {
        Some(Problem::WrongCase { found, expected })
    } else {
        None
    }
}

/// One slip of the keyboard in a name long enough for it not to be another word.
fn distance_is_small(found: &str, known: &str) -> bool {
    known.len() > 2 && found.len() <= known.len() + 1 && distance(found, known) == 1
}
