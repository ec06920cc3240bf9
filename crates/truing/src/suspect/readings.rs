//! Tables of which some rows may be wrong.

use std::collections::BTreeSet;

use super::unit::Dimension;
use crate::case::{Change, Edit, Folder, Table};

/// Columns that are read together.
pub(crate) type Set = (&'static [&'static str], Dimension);

/// A table of readings of which a stretch may be wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Readings {
    pub(crate) file: &'static str,
    pub(crate) sets: &'static [Set],
    /// Rows of a stretch at least: where fewer are slips, which say so themselves, or bad readings.
    pub(crate) fewest: usize,
    /// Whether they are places that stay, which physics does not move one by one.
    pub(crate) are_places: bool,
    /// Whether they follow each other without a pause, where one of two instruments may come late.
    pub(crate) is_record: bool,
    /// What the column `use` says of rows that are fitted, where others are set aside.
    pub(crate) fitted: &'static str,
    /// The samples that were recorded of each row, where there are any.
    pub(crate) samples: Option<Samples>,
    /// Tables of what is read, by file and by the column that names it in both: what no row reads any more goes.
    pub(crate) of: &'static [(&'static str, &'static str)],
    /// Columns of names that may have been exchanged in some rows.
    pub(crate) labels: &'static [&'static str],
    /// Columns by which the rows are put in other orders than that of the table, in which those that are wrong may
    /// follow each other.
    pub(crate) orders: &'static [&'static [&'static str]],
}

/// A table of samples, each of the row that has the same name in a column of both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    pub(crate) file: &'static str,
    pub(crate) label: &'static str,
    pub(crate) sets: &'static [Set],
}

impl Readings {
    /// Of a table that stands for itself.
    pub(crate) const fn of(file: &'static str, sets: &'static [Set]) -> Self {
        Self {
            file,
            sets,
            fewest: 3,
            are_places: false,
            is_record: false,
            fitted: "fit",
            samples: None,
            of: &[],
            labels: &[],
            orders: &[],
        }
    }

    /// The changes after which some rows are not there, nor their samples.
    pub(super) fn without(&self, folder: &Folder, rows: &[usize]) -> Option<Vec<Edit>> {
        let table = folder.table(self.file, &[]).ok()?;
        let kept: Vec<usize> =
            (0..table.n_rows()).filter(|row| rows.binary_search(row).is_err()).collect();
        let unread = self.of.iter().filter_map(|of| unread(folder, (&table, &kept), *of));
        let mut edits: Vec<Edit> = unread.collect();
        edits.push(Edit { file: self.file, change: Change::Keep { rows: kept } });
        if let Some(samples) = self.samples.filter(|samples| folder.has(samples.file)) {
            let of = folder.table(samples.file, &[]).ok()?;
            let gone = samples.of_rows([&table, &of], rows)?;
            let kept = (0..of.n_rows()).filter(|row| gone.binary_search(row).is_err()).collect();
            edits.push(Edit { file: samples.file, change: Change::Keep { rows: kept } });
        }
        Some(edits)
    }
}

/// What only those are left of that these rows read; `None` where they read all.
fn unread(
    folder: &Folder,
    (table, kept): (&Table, &[usize]),
    (file, name): (&'static str, &'static str),
) -> Option<Edit> {
    let of = folder.table(file, &[]).ok()?;
    let [read, named] = [table.column(name)?, of.column(name)?];
    let names: BTreeSet<&str> = kept.iter().map(|row| table.cell(*row, read)).collect();
    let rows: Vec<usize> =
        (0..of.n_rows()).filter(|row| names.contains(of.cell(*row, named))).collect();
    (rows.len() < of.n_rows()).then_some(Edit { file, change: Change::Keep { rows } })
}

impl Samples {
    /// Those of some rows, in ascending order.
    pub(super) fn of_rows(&self, [table, of]: [&Table; 2], rows: &[usize]) -> Option<Vec<usize>> {
        let [name, label] = [table.column(self.label)?, of.column(self.label)?];
        let names: BTreeSet<&str> = rows.iter().map(|row| table.cell(*row, name)).collect();
        Some((0..of.n_rows()).filter(|&row| names.contains(of.cell(row, label))).collect())
    }
}
