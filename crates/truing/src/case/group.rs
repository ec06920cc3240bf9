use toml::Spanned;

use super::document::Document;
use super::nearest::nearest;
use super::table::Table;
use super::{Location, Problem};
use crate::Error;

/// The group of each row, from the column named by `[loop] group`; `None` where none is named.
pub(crate) fn group_names(
    setting: Option<&Spanned<String>>,
    table: &Table,
    document: &Document,
) -> Result<Option<Vec<String>>, Error> {
    let Some(setting) = setting else { return Ok(None) };
    let Some(column) = table.column(setting.get_ref()) else {
        return Err(no_column(setting, &[table], document.at(&setting.span())));
    };
    (0..table.n_rows())
        .map(|row| group_name(table, row, column))
        .collect::<Result<_, _>>()
        .map(Some)
}

/// Equal numbers are one group however they are written.
pub(crate) fn group_name(table: &Table, row: usize, column: usize) -> Result<String, Error> {
    let cell = table.cell(row, column);
    if cell.is_empty() {
        let expected = "the name of a group".to_owned();
        return Err(Error::case(table.at_cell(row, column), Problem::EmptyCell { expected }));
    }
    Ok(cell.parse::<f64>().map_or_else(|_| cell.to_owned(), |value| value.to_string()))
}

pub(crate) fn no_column(setting: &Spanned<String>, tables: &[&Table], at: Location) -> Error {
    let columns: Vec<String> = tables.iter().flat_map(|t| t.names()).cloned().collect();
    let column = setting.get_ref().clone();
    let nearest = nearest(&column, columns.iter().map(String::as_str)).map(str::to_owned);
    Error::case(at, Problem::NoGroupColumn { column, nearest, columns })
}
