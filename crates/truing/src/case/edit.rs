use std::borrow::Cow;

use super::cells::Cells;
use super::order::Order;
use super::table::Table;

/// A change to one file of a case, tried before anyone makes it.
#[derive(Clone, Debug)]
pub(crate) struct Edit {
    pub(crate) file: &'static str,
    pub(crate) change: Change,
}

/// What is changed.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    /// Numbers of some columns, times a factor: in all rows, or in these, in ascending order.
    Scale { columns: Vec<String>, rows: Option<Vec<usize>>, factor: f64 },
    /// `columns[i]` gets the cells of `sources[i]`: in all rows, or in these, in ascending order.
    Permute { columns: Vec<String>, sources: Vec<String>, rows: Option<Vec<usize>> },
    /// Every row of some columns gets the cells of another.
    Rows { columns: Vec<String>, order: Order },
    /// Only these rows stay.
    Keep { rows: Vec<usize> },
    /// Other names in a column for some, of each pair the second for the first: in all rows, or in these, in
    /// ascending order.
    Rename { column: String, rows: Option<Vec<usize>>, names: Vec<[String; 2]> },
    /// A column of new numbers.
    Replace { column: String, values: Vec<f64> },
    /// Numbers added to those of a column, in the unit of its name; the table may have another.
    Add { column: String, values: Vec<f64> },
    /// Columns that the table does not have, with a cell for each of its rows, and rows at the end.
    Append { columns: Vec<(String, Vec<String>)>, rows: Vec<Vec<String>> },
    /// The file is not there; only for one that a case need not have.
    Omit,
    /// A setting of `case.toml`, by the path of its keys.
    Setting { path: Vec<&'static str>, value: toml::Value },
}

impl Change {
    /// The table with all of these changes, one after the other; columns that it does not have stay as
    /// they are.
    ///
    /// Of a change after which only some rows stay, no other rows are made.
    pub(crate) fn all_of_table<'e>(
        changes: impl Iterator<Item = &'e Self>,
        table: Cow<'_, Table>,
    ) -> Table {
        let mut table = table;
        let mut changes = changes.peekable();
        while let Some(change) = changes.next() {
            let kept = match changes.peek() {
                Some(Self::Keep { rows }) if change.keeps_all_rows() => {
                    changes.next();
                    Some(&rows[..])
                }
                _ => None,
            };
            table = Cow::Owned(change.of_rows(&table, kept));
        }
        table.into_owned()
    }

    /// One name stands for another and the other way round.
    pub(crate) fn swap(column: &str, [one, other]: [&str; 2]) -> Self {
        let names = [[one, other], [other, one]].map(|pair| pair.map(str::to_owned));
        Self::Rename { column: column.to_owned(), rows: None, names: names.to_vec() }
    }

    fn keeps_all_rows(&self) -> bool {
        !matches!(self, Self::Keep { .. } | Self::Append { .. } | Self::Omit | Self::Setting { .. })
    }

    /// These rows of the table with the change, or all.
    fn of_rows(&self, table: &Table, kept: Option<&[usize]>) -> Table {
        let index = |name: &String| table.read_as(name).map(|(column, _)| column);
        let all: Vec<usize> = (0..table.n_rows()).collect();
        let of_all = kept.unwrap_or(&all);
        let rows_of = || of_all.iter().copied();
        match self {
            Self::Scale { columns, rows, factor } => {
                let columns: Vec<_> = columns.iter().filter_map(index).collect();
                let is_of = |row| is_among(rows.as_deref(), row);
                let scaled = |row, value: f64| is_of(row).then_some(value * factor);
                table.with(kept, |column| {
                    let is_scaled = columns.contains(&column);
                    is_scaled.then(|| table.cells(column).changed(of_all, scaled).into())
                })
            }
            Self::Permute { columns, sources, rows } => {
                let both = columns.iter().zip(sources);
                let moves: Vec<_> =
                    both.filter_map(|(c, s)| Some((index(c)?, index(s)?))).collect();
                table.with(kept, |column| {
                    let (_, from) = moves.iter().find(|(to, _)| *to == column)?;
                    let Some(rows) = rows else { return Some(table.of_rows(kept, *from)) };
                    let of = |row| if is_among(Some(rows), row) { *from } else { column };
                    let picked = rows_of().map(|row| (table.cells(of(row)), row));
                    Some(Cells::picked(picked).into())
                })
            }
            Self::Rows { columns, order } => {
                let columns: Vec<_> = columns.iter().filter_map(index).collect();
                table.with(kept, |column| {
                    let picked = rows_of().map(|row| (table.cells(column), order.of(row)));
                    columns.contains(&column).then(|| Cells::picked(picked).into())
                })
            }
            Self::Keep { rows } => table.with(Some(rows), |_| None),
            Self::Rename { column, rows, names } => {
                let of = table.column(column);
                let is_of = |row| is_among(rows.as_deref(), row);
                table.with(kept, |column| {
                    let renamed = |row| {
                        let cell = table.cell(row, column);
                        let other = names.iter().find(|[one, _]| one == cell);
                        other.filter(|_| is_of(row)).map_or(cell, |[_, other]| other)
                    };
                    (of == Some(column)).then(|| Cells::of_texts(rows_of().map(renamed)).into())
                })
            }
            Self::Replace { column, values } => {
                let found = index(column).zip(table.unit_of(&[column]));
                table.with(kept, |column| {
                    let (_, unit) = found.filter(|(at, _)| *at == column)?;
                    let numbers = rows_of().map(|row| values[row] / unit).collect();
                    Some(Cells::of_numbers(numbers).into())
                })
            }
            Self::Add { column, values } => {
                let found = index(column).zip(table.unit_of(&[column]));
                table.with(kept, |column| {
                    let (_, unit) = found.filter(|(at, _)| *at == column)?;
                    let sum = |row: usize, value: f64| Some(value + values[row] / unit);
                    Some(table.cells(column).changed(of_all, sum).into())
                })
            }
            Self::Append { columns, rows } => table.appended(columns, rows),
            Self::Omit | Self::Setting { .. } => table.clone(),
        }
    }

    /// The text of `case.toml` with the change; `None` where it is about a table.
    pub(crate) fn of_settings(&self, text: &str) -> Option<String> {
        let Self::Setting { path, value } = self else { return None };
        let mut document: toml::Table = text.parse().ok()?;
        let (last, sections) = path.split_last()?;
        let mut section = &mut document;
        for key in sections {
            let new = || toml::Value::Table(toml::Table::new());
            section = section.entry(*key).or_insert_with(new).as_table_mut()?;
        }
        section.insert((*last).to_owned(), value.clone());
        toml::to_string(&document).ok()
    }
}

/// Whether a row is one of some in ascending order, or all are.
fn is_among(rows: Option<&[usize]>, row: usize) -> bool {
    rows.is_none_or(|rows| rows.binary_search(&row).is_ok())
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::{Change, Order, Table};
    use crate::case::{Ledger, Location};

    impl Change {
        fn of_table(&self, table: &Table) -> Table {
            Self::all_of_table([self].into_iter(), Cow::Borrowed(table))
        }
    }

    fn cells(table: &Table) -> Vec<Vec<&str>> {
        let columns = 0..table.names().len();
        let row = |row| columns.clone().map(|column| table.cell(row, column)).collect();
        (0..table.n_rows()).map(row).collect()
    }

    fn table() -> Table {
        let text = "id,x,y\na,1,10\nb,2,20\nc,3,30\n";
        Table::read(Location::file("t.csv"), text, &[], &Ledger::default()).unwrap()
    }

    fn names(of: &[&str]) -> Vec<String> {
        of.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn a_scale_touches_numbers_of_its_columns_alone() {
        let columns = names(&["id", "x"]);
        let scaled = Change::Scale { columns, rows: None, factor: 0.5 }.of_table(&table());
        assert_eq!(cells(&scaled), [["a", "0.5", "10"], ["b", "1.0", "20"], ["c", "1.5", "30"]]);
        let (columns, rows) = (names(&["x"]), Some(vec![2]));
        let one = Change::Scale { columns, rows, factor: -1.0 }.of_table(&table());
        assert_eq!(cells(&one), [["a", "1", "10"], ["b", "2", "20"], ["c", "-3.0", "30"]]);
    }

    #[test]
    fn columns_rows_and_names_change_places() {
        let [columns, sources] = [names(&["x", "y"]), names(&["y", "x"])];
        let permuted = |rows| {
            let (columns, sources) = (columns.clone(), sources.clone());
            Change::Permute { columns, sources, rows }.of_table(&table())
        };
        assert_eq!(cells(&permuted(None))[0], ["a", "10", "1"]);
        assert_eq!(cells(&permuted(Some(vec![1]))).concat().join(" "), "a 1 10 b 20 2 c 3 30");
        let order = Order::Listed(vec![1, 2, 0]);
        let rows = Change::Rows { columns: names(&["x"]), order }.of_table(&table());
        assert_eq!(cells(&rows), [["a", "2", "10"], ["b", "3", "20"], ["c", "1", "30"]]);
        let swap = Change::swap("id", ["a", "c"]).of_table(&table());
        assert_eq!(cells(&swap).concat().join(" "), "c 1 10 b 2 20 a 3 30");
        let names = vec![["a", "c"].map(str::to_owned), ["c", "a"].map(str::to_owned)];
        let of_some = Change::Rename { column: "id".to_owned(), rows: Some(vec![1, 2]), names };
        assert_eq!(cells(&of_some.of_table(&table())).concat().join(" "), "a 1 10 b 2 20 a 3 30");
    }

    #[test]
    fn rows_that_go_take_their_lines_with_them() {
        let kept = Change::Keep { rows: vec![0, 2] }.of_table(&table());
        assert_eq!(cells(&kept), [["a", "1", "10"], ["c", "3", "30"]]);
        assert_eq!([kept.line(0), kept.line(1)], [2, 4]);
    }

    #[test]
    fn a_change_of_few_rows_is_that_of_all_of_which_they_are_kept() {
        let order = Order::Listed(vec![1, 2, 0]);
        let moved = Change::Rows { columns: names(&["x"]), order };
        let keep = Change::Keep { rows: vec![0, 2] };
        let both = Change::all_of_table([&moved, &keep].into_iter(), Cow::Owned(table()));
        assert_eq!(cells(&both), cells(&keep.of_table(&moved.of_table(&table()))));
        assert_eq!(cells(&both), [["a", "2", "10"], ["c", "1", "30"]]);
    }

    #[test]
    fn rows_and_columns_are_added_at_the_end() {
        let columns = vec![("z".to_owned(), names(&["7", "8", "9"]))];
        let rows = vec![names(&["d", "4", "40", "10"])];
        let longer = Change::Append { columns, rows }.of_table(&table());
        assert_eq!(longer.names(), ["id", "x", "y", "z"]);
        assert_eq!(cells(&longer)[2], ["c", "3", "30", "9"]);
        assert_eq!(cells(&longer)[3], ["d", "4", "40", "10"]);
        assert_eq!([longer.line(2), longer.line(3)], [4, 5]);
    }

    #[test]
    fn a_setting_is_replaced_or_added() {
        let value = toml::Value::Float(2.0);
        let change = Change::Setting { path: vec!["probe", "tip"], value };
        let changed = change.of_settings("kind = \"k\"\n[probe]\ntip = 4.0\n").unwrap();
        assert!(changed.contains("tip = 2.0") && !changed.contains("4.0"), "{changed}");
        assert!(change.of_settings("kind = \"k\"\n").unwrap().contains("[probe]"));
    }
}
