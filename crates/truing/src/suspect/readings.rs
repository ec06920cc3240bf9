//! Tables of which some rows may be wrong.

use std::collections::BTreeSet;

use super::unit::Dimension;
use crate::case::{Change, Edit, Folder, Table};

/// Columns that are read together.
pub(super) type Set = (&'static [&'static str], Dimension);

/// A table of readings of which a stretch may be wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Readings {
    pub(crate) file: &'static str,
    pub(crate) sets: &'static [Set],
    /// Rows of a stretch at least: where fewer are slips, which say so themselves, or bad readings.
    pub(crate) fewest: usize,
    /// Whether they are places that stay, which physics does not move one by one.
    pub(crate) are_places: bool,
    /// The samples that were recorded of each row, where there are any.
    pub(crate) samples: Option<Samples>,
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
        Self { file, sets, fewest: 3, are_places: false, samples: None }
    }

    /// The changes after which some rows are not there, nor their samples.
    pub(super) fn without(&self, folder: &Folder, rows: &[usize]) -> Option<Vec<Edit>> {
        let table = folder.table(self.file, &[]).ok()?;
        let kept = (0..table.n_rows()).filter(|row| rows.binary_search(row).is_err()).collect();
        let mut edits = vec![Edit { file: self.file, change: Change::Keep { rows: kept } }];
        if let Some(samples) = self.samples.filter(|samples| folder.has(samples.file)) {
            let of = folder.table(samples.file, &[]).ok()?;
            let gone = samples.of_rows([&table, &of], rows)?;
            let kept = (0..of.n_rows()).filter(|row| gone.binary_search(row).is_err()).collect();
            edits.push(Edit { file: samples.file, change: Change::Keep { rows: kept } });
        }
        Some(edits)
    }
}

impl Samples {
    /// Those of some rows, in ascending order.
    pub(super) fn of_rows(&self, [table, of]: [&Table; 2], rows: &[usize]) -> Option<Vec<usize>> {
        let [name, label] = [table.column(self.label)?, of.column(self.label)?];
        let names: BTreeSet<&str> = rows.iter().map(|row| table.cell(*row, name)).collect();
        Some((0..of.n_rows()).filter(|&row| names.contains(of.cell(row, label))).collect())
    }
}
