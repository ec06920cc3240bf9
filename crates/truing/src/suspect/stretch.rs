//! A stretch of rows that does not fit the others: where it lies is known by leaving it out, what is wrong with it
//! by changing it.

use std::collections::BTreeSet;
use std::ops::Range;

use rayon::prelude::*;

use super::hypothesis::{Hypothesis, listed, owned, pairs, present};
use super::misfit::Misfit;
use super::order::blocks_shifted;
use super::search::{Found, misfit_with};
use super::unit::{Dimension, all_and_each, shown};
use crate::case::{Change, Edit, Order, Table};
use crate::kind::Files;

/// Parts of the rows that are left out to find a stretch, in sixteenths: each is tried from every half of it on.
const PARTS: [usize; 5] = [1, 2, 4, 8, 12];
/// Rows of a table in which a stretch is looked for, at most: each part costs a fit.
const MOST_ROWS: usize = 5000;
/// Rows with one value that are no accident where they do not fit.
const FEWEST_FILLED: usize = 3;
/// Stretches looked at, at most: where half of the rows are wrong, the others are as likely.
const MOST: usize = 2;

/// By how much either end of a stretch is moved to see whether that leaves less, and how often.
const MOVES: [[isize; 2]; 16] = [
    [-8, 0],
    [-4, 0],
    [-2, 0],
    [-1, 0],
    [1, 0],
    [2, 0],
    [4, 0],
    [8, 0],
    [0, -8],
    [0, -4],
    [0, -2],
    [0, -1],
    [0, 1],
    [0, 2],
    [0, 4],
    [0, 8],
];
const MOST_MOVES: usize = 24;

/// Columns that are read together.
type Set = (&'static [&'static str], Dimension);

/// A table of readings of which a stretch may be wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Readings {
    pub(crate) file: &'static str,
    pub(crate) sets: &'static [Set],
    /// Rows of a stretch at least: where fewer are slips, which say so themselves, or bad readings.
    pub(crate) fewest: usize,
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
    /// The changes after which some rows are not there, nor their samples.
    fn without(&self, files: &Files, rows: &Range<usize>) -> Option<Vec<Edit>> {
        let table = files.folder.table(self.file, &[]).ok()?;
        let kept = (0..table.n_rows()).filter(|row| !rows.contains(row)).collect();
        let mut edits = vec![Edit { file: self.file, change: Change::Keep { rows: kept } }];
        if let Some(samples) = self.samples {
            let of = files.folder.table(samples.file, &[]).ok()?;
            let gone = samples.of_rows([&table, &of], rows)?;
            let kept = (0..of.n_rows()).filter(|row| gone.binary_search(row).is_err()).collect();
            edits.push(Edit { file: samples.file, change: Change::Keep { rows: kept } });
        }
        Some(edits)
    }
}

impl Samples {
    /// Those of some rows, in ascending order.
    fn of_rows(&self, [table, of]: [&Table; 2], rows: &Range<usize>) -> Option<Vec<usize>> {
        let [name, label] = [table.column(self.label)?, of.column(self.label)?];
        let names: BTreeSet<&str> = rows.clone().map(|row| table.cell(row, name)).collect();
        Some((0..of.n_rows()).filter(|&row| names.contains(of.cell(row, label))).collect())
    }
}

/// Rows without which the others fit.
#[derive(Debug)]
pub(super) struct Stretch {
    of: Readings,
    rows: Range<usize>,
}

impl Stretch {
    /// All of a case, which `fits` without each of them.
    pub(super) fn all_of(files: &Files, fits: &(impl Fn(&Misfit) -> bool + Sync)) -> Vec<Self> {
        let of_table = |of: &Readings| {
            let n = files.folder.table(of.file, &[]).ok()?.n_rows();
            let without = |rows: &Range<usize>| {
                let left = of.without(files, rows).and_then(|edits| misfit_with(files, &edits));
                left.is_some_and(|misfit| fits(&misfit))
            };
            let is_looked_at = (of.fewest + 1..=MOST_ROWS).contains(&n);
            let all = is_looked_at.then(|| shortest((n, of.fewest), &without))?;
            Some(all.into_iter().map(|rows| Self { of: *of, rows }).collect::<Vec<_>>())
        };
        let has = |file: &str| files.folder.has(file);
        let is_there = |of: &&Readings| has(of.file) && of.samples.is_none_or(|s| has(s.file));
        files.kind.readings.iter().filter(is_there).filter_map(of_table).flatten().collect()
    }

    /// What may be wrong with these rows.
    pub(super) fn changes(&self, files: &Files) -> Vec<Hypothesis> {
        let Ok(table) = files.folder.table(self.of.file, &[]) else { return Vec::new() };
        let rows = Rows { file: self.of.file, table: &table, rows: self.rows.clone().collect() };
        let mut all = Vec::new();
        for (columns, dimension) in self.of.sets {
            let columns = present(Some(&table), columns);
            all.extend(rows.changes(&columns, *dimension));
            if self.of.fewest > 1 {
                all.extend(all_and_each(&columns).iter().flat_map(|set| self.orders(&rows, set)));
            }
        }
        let read =
            |samples: &Samples| Some((*samples, files.folder.table(samples.file, &[]).ok()?));
        if let Some((samples, of)) = self.of.samples.as_ref().and_then(read) {
            let rows = samples.of_rows([&table, &of], &self.rows).unwrap_or_default();
            let rows = Rows { file: samples.file, table: &of, rows };
            for (columns, dimension) in samples.sets {
                all.extend(rows.changes(&present(Some(&of), columns), *dimension));
            }
        }
        for (columns, _) in self.of.sets {
            let columns = present(Some(&table), columns);
            all.extend(self.pasted(files, &rows, &columns));
            all.extend(columns.iter().filter_map(|column| self.filled(files, &rows, column)));
        }
        all
    }

    /// One of its changes, of the rows at its ends with which it leaves the least.
    pub(super) fn sharpened(&self, files: &Files, found: Found) -> Found {
        let is_left_out = |edit: &Edit| matches!(edit.change, Change::Keep { .. });
        if found.named.edits.first().is_none_or(is_left_out) {
            return found;
        }
        let is_it = |change: &Hypothesis| change.description == found.named.description;
        let Some(index) = self.changes(files).iter().position(is_it) else { return found };
        let (mut best, mut at) = (found, self.rows.clone());
        for _ in 0..MOST_MOVES {
            let moved = |[start, end]: [isize; 2]| {
                let rows = at.start.checked_add_signed(start)?..at.end.checked_add_signed(end)?;
                let change = Self { of: self.of, rows: rows.clone() }.change(files, index)?;
                Some((misfit_with(files, &change.edits)?, change, rows))
            };
            let tried = MOVES.into_par_iter().filter_map(moved);
            let Some((left, named, rows)) = tried.min_by(|a, b| a.0.share.total_cmp(&b.0.share))
            else {
                break;
            };
            if best.after.is_none_or(|after| left.share >= after.share) {
                break;
            }
            (best, at) = (Found { named, after: Some(left), ..best }, rows);
        }
        best
    }

    fn change(&self, files: &Files, index: usize) -> Option<Hypothesis> {
        let n = files.folder.table(self.of.file, &[]).ok()?.n_rows();
        let is_within = self.rows.len() >= self.of.fewest && self.rows.end <= n;
        is_within.then(|| self.changes(files).into_iter().nth(index)).flatten()
    }

    /// Whether its rows are places, which physics does not move one by one.
    pub(super) fn is_of_places(&self) -> bool {
        self.of.fewest == 1
    }

    /// That the rows are not of this table, whatever is wrong with them.
    pub(super) fn misplaced(&self, files: &Files) -> Option<Hypothesis> {
        let Readings { file, sets, .. } = self.of;
        let table = files.folder.table(file, &[]).ok()?;
        let columns = present(Some(&table), sets.first()?.0);
        let rows = Rows { file, table: &table, rows: self.rows.clone().collect() };
        let those = if self.rows.len() == 1 { "a row" } else { "the rows" };
        let description = format!(
            "{those} of {file}{} do not fit the others, which fit without them: they are of another session, \
             set-up or part, were displaced, shifted, mistyped or exchanged, or pasted from elsewhere{}; look at them, and leave \
             them out if they are",
            rows.said(),
            self.read_there().or_else(|| rows.shared()).unwrap_or_default()
        );
        let edits = self.of.without(files, &self.rows)?;
        Some(Hypothesis::of("input:misplaced", (file, &columns), description, edits))
    }

    /// What may be wrong instead of a place.
    fn read_there(&self) -> Option<String> {
        let samples = self.of.samples.filter(|_| self.is_of_places())?;
        Some(format!(
            ", or what {} has of them is wrong (stuck, exchanged, in another unit)",
            samples.file
        ))
    }

    /// One row further down or up, in reverse order, and neighbours exchanged.
    fn orders(&self, rows: &Rows<'_>, set: &[&str]) -> Vec<Hypothesis> {
        let Range { start, end } = self.rows;
        let said = rows.said();
        let block = (std::slice::from_ref(&self.rows), &*said);
        let mut all =
            [1, -1].map(|by| blocks_shifted((rows.file, rows.table), set, block, by)).concat();
        let listed = |within: &dyn Fn(usize) -> usize| {
            let of = |row| if self.rows.contains(&row) { start + within(row - start) } else { row };
            let order = Order::Listed((0..rows.table.n_rows()).map(of).collect());
            Change::Rows { columns: owned(set), order }
        };
        let turned = listed(&|at| end - start - 1 - at);
        let said = (set, "in reverse order against the other columns", "turn them round");
        all.push(rows.hypothesis("input:row-shift", said, turned));
        let neighbours = listed(&|at| if at ^ 1 < end - start { at ^ 1 } else { at });
        let said = (set, "exchanged between neighbouring rows (swapped)", "exchange them");
        all.push(rows.hypothesis("input:labels", said, neighbours));
        all
    }

    /// One value in all rows, as a spreadsheet fills them down.
    fn filled(&self, files: &Files, rows: &Rows<'_>, column: &str) -> Option<Hypothesis> {
        let (at, _) = rows.table.read_as(column)?;
        let value = rows.table.cell(self.rows.start, at);
        let is_same = |row: usize| rows.table.cell(row, at) == value;
        if self.rows.len() < FEWEST_FILLED || !self.rows.clone().all(is_same) {
            return None;
        }
        let description = format!(
            "`{column}` of {} is {value}{}: it stands still (stuck, or filled down); put back what it was, or leave \
             these rows out",
            rows.file,
            rows.said()
        );
        let edits = self.of.without(files, &self.rows)?;
        Some(Hypothesis::of("input:stuck", (rows.file, &[column]), description, edits))
    }

    /// The same readings as in other rows, to the last digit.
    fn pasted(&self, files: &Files, rows: &Rows<'_>, columns: &[&str]) -> Option<Hypothesis> {
        let (file, table) = (rows.file, rows.table);
        let Range { start, end } = self.rows;
        let of_name = |name: &&str| table.read_as(name).map(|(column, _)| column);
        let read: Vec<usize> = columns.iter().filter_map(of_name).collect();
        let is_same = |other: &usize| {
            let cell = |row: usize| read.iter().map(move |column| table.cell(row, *column));
            !self.rows.contains(other)
                && (0..end - start).all(|at| cell(start + at).eq(cell(other + at)))
        };
        let other =
            (0..=table.n_rows() - (end - start)).find(is_same).filter(|_| !read.is_empty())?;
        let description = format!(
            "{} of {file}{} repeat those from line {} on to the last digit: a block was copied (pasted twice); put \
             back what was read there",
            listed(columns),
            rows.said(),
            table.line(other)
        );
        let edits = self.of.without(files, &self.rows)?;
        Some(Hypothesis::of("input:copied", (file, columns), description, edits))
    }
}

/// Some rows of a table, in ascending order.
struct Rows<'t> {
    file: &'static str,
    table: &'t Table,
    rows: Vec<usize>,
}

impl Rows<'_> {
    fn said(&self) -> String {
        let line = |row: Option<&usize>| row.map_or(0, |row| self.table.line(*row));
        match (line(self.rows.first()), line(self.rows.last())) {
            (first, last) if first == last => format!(" in line {first}"),
            (first, last) => format!(" from line {first} to line {last}"),
        }
    }

    /// What these rows have in common and few others have: those at the ends may fit by accident.
    fn shared(&self) -> Option<String> {
        let of_column = |column: usize| {
            let name = self.table.cell(*self.rows.first()?, column);
            let has = |row: usize| self.table.cell(row, column) == name;
            let all = (0..self.table.n_rows()).filter(|row| has(*row)).count();
            let is_theirs = self.rows.iter().all(|row| has(*row)) && 4 * all <= 5 * self.rows.len();
            is_theirs.then(|| {
                format!(
                    ", or a number of another table (a typo, a wrong digit) that belongs to `{}` = `{name}` is wrong",
                    self.table.names()[column]
                )
            })
        };
        (0..self.table.names().len()).find_map(of_column)
    }

    fn hypothesis(
        &self,
        effect: &'static str,
        (columns, what, cure): (&[&str], &str, &str),
        change: Change,
    ) -> Hypothesis {
        let file = self.file;
        let description =
            format!("{} of {file} {what}{}: {cure} there", listed(columns), self.said());
        Hypothesis::of(effect, (file, columns), description, vec![Edit { file, change }])
    }

    /// Signs, units and factors of all columns and of each, and any two of them exchanged.
    fn changes(&self, columns: &[&str], dimension: Dimension) -> Vec<Hypothesis> {
        let sets = all_and_each(columns);
        let mut all: Vec<_> = sets.iter().flat_map(|set| self.factors(set, dimension)).collect();
        all.extend(pairs(columns).map(|pair| self.exchanged(pair)));
        all
    }

    fn factors(&self, set: &[&str], dimension: Dimension) -> Vec<Hypothesis> {
        let Some(declared) = self.table.unit_of(set) else { return Vec::new() };
        let one = |effect, what: &str, factor: f64| {
            let rows = Some(self.rows.clone());
            let change = Change::Scale { columns: owned(set), rows, factor };
            let cure = format!("multiply by {}", shown(factor));
            self.hypothesis(effect, (set, what, &cure), change)
        };
        let own = dimension.name_of(declared);
        let mut all = vec![one("input:sign", "with the opposite sign", -1.0)];
        all.extend(dimension.instead_of(declared).map(|(unit, factor)| {
            one("input:unit", &format!("in another unit, {unit} instead of {own},"), factor)
        }));
        let twice = "twice or half of what it is elsewhere (another gain, a diameter for a radius)";
        all.extend([0.5, 2.0].map(|factor| one("input:gain", twice, factor)));
        all
    }

    fn exchanged(&self, pair: [&str; 2]) -> Hypothesis {
        let rows = Some(self.rows.clone());
        let sources = owned(&[pair[1], pair[0]]);
        let change = Change::Permute { columns: owned(&pair), sources, rows };
        let said = (&pair[..], "exchanged (swapped)", "exchange them");
        self.hypothesis("input:exchanged", said, change)
    }
}

/// The shortest stretches of `n` rows that are known to be wrong, as the others are right `without` them.
fn shortest(
    (n, fewest): (usize, usize),
    without: &(impl Fn(&Range<usize>) -> bool + Sync),
) -> Vec<Range<usize>> {
    for part in PARTS {
        let length = (n * part / 16).max(fewest + usize::from(fewest > 1)).min(n - 1);
        let step = (length / 2).min(n / 8).max(1);
        let starts = (0..n - length).step_by(step).chain([n - length]);
        let parts: Vec<_> = starts.map(|start| start..start + length).collect();
        let mut known: Vec<Range<usize>> = parts.into_par_iter().filter(without).collect();
        known.truncate(MOST);
        if !known.is_empty() {
            let mut all: Vec<_> = known.into_iter().map(|rows| cut_down(rows, without)).collect();
            all.retain(|rows| rows.len() >= fewest);
            all.dedup();
            return all;
        }
    }
    Vec::new()
}

/// A stretch without the rows at its ends that need not be left out.
fn cut_down(rows: Range<usize>, without: &impl Fn(&Range<usize>) -> bool) -> Range<usize> {
    // The last start and the first end with which the others are right.
    let (mut low, mut high) = (rows.start, rows.end);
    while low + 1 < high {
        let middle = low.midpoint(high);
        if without(&(middle..rows.end)) { low = middle } else { high = middle }
    }
    let start = low;
    let (mut low, mut high) = (start, rows.end);
    while low + 1 < high {
        let middle = low.midpoint(high);
        if without(&(start..middle)) { high = middle } else { low = middle }
    }
    start..high
}

#[cfg(test)]
mod tests {
    use super::shortest;

    #[test]
    fn a_stretch_is_found_to_the_row_wherever_it_lies() {
        for wrong in [0..4, 3..7, 11..16, 20..40, 36..40, 5..35] {
            let without = |rows: &std::ops::Range<usize>| {
                rows.start <= wrong.start && rows.end >= wrong.end && rows.len() < 39
            };
            assert_eq!(shortest((40, 3), &without), [wrong.clone()], "{wrong:?}");
        }
    }

    #[test]
    fn one_row_is_no_stretch() {
        let without = |rows: &std::ops::Range<usize>| rows.contains(&9);
        assert!(shortest((40, 3), &without).is_empty());
    }
}
