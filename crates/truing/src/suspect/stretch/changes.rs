//! What may be wrong with the rows of a stretch: each is known by changing it.

use std::collections::BTreeSet;
use std::ops::Range;

use rayon::prelude::*;

use super::{Stretch, in_order};
use crate::case::{Change, Edit, Order, Table};
use crate::kind::Files;
use crate::suspect::hypothesis::{Hypothesis, leaves_out, listed, owned, pairs, present};
use crate::suspect::order::{blocks_shifted, exchanged_rows};
use crate::suspect::readings::{Samples, Set};
use crate::suspect::search::{Found, misfit_with};
use crate::suspect::some_rows::Rows;
use crate::suspect::unit::{Dimension, all_and_each};

/// Rows with one value that are no accident where they do not fit.
const FEWEST_FILLED: usize = 3;
/// Rows that were pasted, at least: one place may be that of another.
const FEWEST_PASTED: usize = 2;
/// Rows by which a stretch may be shifted, and rows of a record, of which it may be by more than one.
const FARTHEST_SHIFT: isize = 12;
const LONG: usize = 200;
/// Rows that are in the order of their numbers by no accident, at least.
const FEWEST_SORTED: usize = 6;
/// One place in so many of a table where as many rows are in that order, at most: elsewhere it is their nature.
const MOST_SORTED: usize = 20;
/// Wrong rows of which every two may be exchanged, at most.
const MOST_EXCHANGED: usize = 8;

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

impl Stretch {
    /// What may be wrong with these rows.
    pub(in crate::suspect) fn changes(&self, files: &Files) -> Vec<Hypothesis> {
        let Ok(table) = files.folder.table(self.of.file, &[]) else { return Vec::new() };
        let rows = Rows { file: self.of.file, table: &table, these: self.all() };
        let mut all = Vec::new();
        // What makes deviations small mends nothing.
        let sets = self.of.sets.iter().filter(|(_, of)| *of != Dimension::Deviation);
        for (columns, dimension) in sets.clone() {
            let columns = present(Some(&table), columns);
            all.extend(rows.changes(&columns, *dimension));
            if !self.of.are_places {
                all.extend(all_and_each(&columns).iter().flat_map(|set| self.orders(&rows, set)));
            }
            all.extend(self.sorted(files, &rows, &columns));
        }
        all.extend(self.sets_exchanged(&rows));
        let read =
            |samples: &Samples| Some((*samples, files.folder.table(samples.file, &[]).ok()?));
        if let Some((samples, of)) = self.of.samples.as_ref().and_then(read) {
            let rows = samples.of_rows([&table, &of], &self.all()).unwrap_or_default();
            let rows = Rows { file: samples.file, table: &of, these: rows };
            for (columns, dimension) in samples.sets {
                all.extend(rows.changes(&present(Some(&of), columns), *dimension));
            }
        }
        all.extend(self.of.labels.iter().flat_map(|column| rows.names_exchanged(column)));
        for (columns, _) in self.of.sets.iter().filter(|_| self.order.is_none()) {
            let columns = present(Some(&table), columns);
            let pairs = pairs(&columns).map(|pair| pair.to_vec());
            let sets = all_and_each(&columns).into_iter().chain(pairs);
            all.extend(sets.filter_map(|set| self.pasted(files, &rows, &set)));
            all.extend(columns.iter().filter_map(|column| self.filled(files, &rows, column)));
        }
        if self.wrong.len() < self.rows.len() {
            let rows = Rows { file: self.of.file, table: &table, these: self.wrong.clone() };
            for (columns, dimension) in sets {
                let columns = present(Some(&table), columns);
                if self.wrong.len() <= MOST_EXCHANGED {
                    all.extend(exchanged_rows(rows.file, Some(&table), &columns, &self.wrong));
                }
                all.extend(rows.changes(&columns, *dimension));
            }
        }
        for whole in self.of_whole_labels(&table) {
            let rows = Rows { these: whole.all(), ..rows };
            for (columns, _) in self.of.sets {
                let columns = present(Some(&table), columns);
                all.extend(all_and_each(&columns).iter().flat_map(|set| whole.orders(&rows, set)));
            }
        }
        all
    }

    /// All rows one after the other that have one label with it, as those of one station have: some of what was
    /// shifted happens to fit.
    fn of_whole_labels(&self, table: &Table) -> Vec<Self> {
        let may_be = self.order.is_none() && !self.of.are_places;
        let labels = self.of.labels.iter().filter_map(|name| table.column(name));
        let widened = |column: usize| {
            let label = table.cell(self.rows.start, column);
            let has_it = |row: &usize| table.cell(*row, column) == label;
            if !self.rows.clone().all(|row| has_it(&row)) {
                return None;
            }
            let start = (0..self.rows.start).rev().take_while(has_it).last();
            let end = (self.rows.end..self.n).take_while(has_it).last();
            let rows = start.unwrap_or(self.rows.start)..end.map_or(self.rows.end, |last| last + 1);
            let wrong = self.wrong.clone();
            (rows != self.rows).then_some(Self { rows, wrong, order: None, ..*self })
        };
        labels.filter(|_| may_be).filter_map(widened).collect()
    }

    /// One of its changes, of the rows at its ends with which it leaves the least.
    pub(in crate::suspect) fn sharpened(&self, files: &Files, found: Found) -> Found {
        if found.named.edits.first().is_none_or(leaves_out) {
            return found;
        }
        let is_it = |change: &Hypothesis| change.description == found.named.description;
        if !self.changes(files).iter().any(is_it) {
            return found;
        }
        let words = without_numbers_of_lines(&found.named.description);
        let (mut best, mut at) = (found, self.rows.clone());
        for _ in 0..MOST_MOVES {
            let moved = |[start, end]: [isize; 2]| {
                let rows = at.start.checked_add_signed(start)?..at.end.checked_add_signed(end)?;
                let wrong = in_order(self.order.as_deref(), &rows);
                let stretch =
                    Self { order: self.order.clone(), rows: rows.clone(), wrong, ..*self };
                let change = stretch.change(files, &words)?;
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

    /// The change of these rows that is said in the same words.
    fn change(&self, files: &Files, words: &str) -> Option<Hypothesis> {
        let is_within = self.rows.len() >= self.of.fewest && self.rows.end <= self.n;
        let is_it = |change: &Hypothesis| without_numbers_of_lines(&change.description) == words;
        is_within.then(|| self.changes(files).into_iter().find(is_it)).flatten()
    }

    /// One row further down or up, in reverse order, and neighbours exchanged.
    fn orders(&self, rows: &Rows<'_>, set: &[&str]) -> Vec<Hypothesis> {
        let n = self.rows.len();
        let mut all: Vec<Hypothesis> = match &self.order {
            None => {
                let said = rows.said();
                let block = (std::slice::from_ref(&self.rows), &*said);
                let farthest = if rows.table.n_rows() < LONG { 1 } else { FARTHEST_SHIFT };
                let shifts = (1..=farthest).flat_map(|by| [by, -by]);
                shifts
                    .flat_map(|by| blocks_shifted((rows.file, rows.table), set, block, by))
                    .collect()
            }
            Some(places) => [(1, "down"), (n - 1, "up")]
                .into_iter()
                .flat_map(|(by, way)| {
                    let what = format!("shifted one row {way} against the other columns");
                    let order = self.listed(rows.table.n_rows(), &|at| (at + by) % n);
                    let change = Change::Rows { columns: owned(set), order };
                    let said = (set, &*what, "shift them back");
                    let rolled = rows.hypothesis("input:row-shift", said, change);
                    // Of those that came from beyond nothing is known.
                    let Range { start, end } = self.rows;
                    let lost = places[if by == 1 { end - 1 } else { start }];
                    let kept = (0..rows.table.n_rows()).filter(|row| *row != lost).collect();
                    let kept = Edit { file: rows.file, change: Change::Keep { rows: kept } };
                    let edits = [rolled.edits.clone(), vec![kept]].concat();
                    [rolled.clone(), Hypothesis { edits, ..rolled }]
                })
                .collect(),
        };
        let listed = |within: &dyn Fn(usize) -> usize| {
            let order = self.listed(rows.table.n_rows(), within);
            Change::Rows { columns: owned(set), order }
        };
        let turned = listed(&|at| n - 1 - at);
        let said = (set, "in reverse order against the other columns", "turn them round");
        all.push(rows.hypothesis("input:row-shift", said, turned));
        let neighbours = listed(&|at| if at ^ 1 < n { at ^ 1 } else { at });
        let said = (set, "exchanged between neighbouring rows (swapped)", "exchange them");
        all.push(rows.hypothesis("input:labels", said, neighbours));
        all
    }

    /// The order in which its rows come from elsewhere `within` it, counted from its first.
    fn listed(&self, n: usize, within: &dyn Fn(usize) -> usize) -> Order {
        let mut order: Vec<usize> = (0..n).collect();
        let at = |index: usize| self.order.as_ref().map_or(index, |order| order[index]);
        for index in self.rows.clone() {
            order[at(index)] = at(self.rows.start + within(index - self.rows.start));
        }
        Order::Listed(order)
    }

    /// Numbers of one column in the order of their size, of rows that follow each other in another order.
    fn sorted(&self, files: &Files, rows: &Rows<'_>, columns: &[&str]) -> Option<Hypothesis> {
        let order = self.order.as_ref()?;
        let [column] = columns else { return None };
        let values = rows.table.numbers(column)?;
        let in_order: Vec<f64> = order.iter().map(|row| values[*row]).collect();
        let goes =
            |own: &[f64], way: f64| own.windows(2).all(|pair| way * (pair[1] - pair[0]) > 0.0);
        let is_sorted = |own: &&[f64]| goes(own, 1.0) || goes(own, -1.0);
        let (own, n) = (&in_order[self.rows.clone()], self.rows.len());
        // What rises or falls all along, as a path does that is followed, was not sorted.
        let are_sorted = in_order.windows(n).filter(is_sorted).count();
        let is_accident = MOST_SORTED * are_sorted <= in_order.len();
        if n < FEWEST_SORTED || !is_sorted(&own) || !is_accident {
            return None;
        }
        let description = format!(
            "`{column}` of {} is in the order of its size{} (sorted without the other columns): put back the order in \
             which it was read, or leave these rows out",
            rows.file,
            rows.said()
        );
        let edits = self.of.without(&files.folder, &self.all())?;
        Some(Hypothesis::of("input:row-shift", (rows.file, columns), description, edits))
    }

    /// One value in all rows, as a spreadsheet fills them down.
    fn filled(&self, files: &Files, rows: &Rows<'_>, column: &str) -> Option<Hypothesis> {
        let (at, _) = rows.table.read_as(column)?;
        let value = rows.table.cell(self.rows.start, at);
        let is_same = |row: usize| rows.table.cell(row, at) == value;
        let is_filled = self.rows.clone().all(is_same) && !is_repeated(rows.table, &[at]);
        if self.rows.len() < FEWEST_FILLED || !is_filled {
            return None;
        }
        let description = format!(
            "`{column}` of {} is {value}{}: it stands still (stuck, or filled down); put back what it was, or leave \
             these rows out",
            rows.file,
            rows.said()
        );
        let edits = self.of.without(&files.folder, &self.all())?;
        Some(Hypothesis::of("input:stuck", (rows.file, &[column]), description, edits))
    }

    /// All columns of one set exchanged for those of another of as many, as where two tables are mixed up.
    fn sets_exchanged(&self, rows: &Rows<'_>) -> Vec<Hypothesis> {
        let there = |(columns, of): &Set| (present(Some(rows.table), columns), *of);
        let sets: Vec<(Vec<&str>, Dimension)> = self.of.sets.iter().map(there).collect();
        let of_two = |(i, j): (usize, usize)| {
            let ([one, other], is_like) = ([&sets[i].0, &sets[j].0], sets[i].1 == sets[j].1);
            let n = one.len().min(other.len());
            (is_like && n > 0).then(|| {
                (1..=n).map(|n| rows.sets_exchanged(&one[..n], &other[..n])).collect::<Vec<_>>()
            })
        };
        let later = |i: usize| (i + 1..sets.len()).map(move |j| (i, j));
        (0..sets.len()).flat_map(later).filter_map(of_two).flatten().collect()
    }

    /// The same readings as in other rows, to the last digit.
    fn pasted(&self, files: &Files, rows: &Rows<'_>, columns: &[&str]) -> Option<Hypothesis> {
        let (file, table) = (rows.file, rows.table);
        let Range { start, end } = self.rows;
        let of_name = |name: &&str| table.read_as(name).map(|(column, _)| column);
        let read: Vec<usize> = columns.iter().filter_map(of_name).collect();
        let cell = |row: usize| read.iter().map(move |column| table.cell(row, *column));
        // One value over and over stands still, wherever else it stands.
        let is_one = self.rows.clone().all(|row| cell(row).eq(cell(start)));
        if self.rows.len() < FEWEST_PASTED || is_one || is_repeated(table, &read) {
            return None;
        }
        let is_same = |other: &usize| {
            !self.rows.contains(other)
                && (0..end - start).all(|at| cell(start + at).eq(cell(other + at)))
        };
        let other =
            (0..=table.n_rows() - (end - start)).find(is_same).filter(|_| !read.is_empty())?;
        // Rows beside it may be copies, too, that fit where they are.
        let (n, length) = (table.n_rows(), end - start);
        let is_equal = |row: usize, of: usize| row < n && of < n && cell(row).eq(cell(of));
        let after = (0..n).take_while(|by| is_equal(end + by, other + length + by)).count();
        let before =
            (1..=start.min(other)).take_while(|by| is_equal(start - by, other - by)).count();
        let (start, other, end) = (start - before, other - before, end + after);
        let these = Rows { file, table, these: (start..end).collect() };
        let description = format!(
            "{} of {file}{} repeat those from line {} on to the last digit: a block was copied (pasted twice); put \
             back what was read there",
            listed(columns),
            these.said(),
            table.line(other)
        );
        let edits = self.of.without(&files.folder, &these.these)?;
        Some(Hypothesis::of("input:copied", (file, columns), description, edits))
    }
}

/// A description of whatever lines.
fn without_numbers_of_lines(description: &str) -> String {
    let mut parts = description.split("line");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let is_of_lines = |c: char| c.is_ascii_digit() || "s –,".contains(c);
        text + part.trim_start_matches(is_of_lines)
    })
}

/// Whether a design repeats what stands in some columns, which then was neither pasted nor filled down.
fn is_repeated(table: &Table, columns: &[usize]) -> bool {
    let cells = |row: usize| columns.iter().map(move |column| table.cell(row, *column));
    let distinct: BTreeSet<Vec<&str>> =
        (0..table.n_rows()).map(|row| cells(row).collect()).collect();
    2 * distinct.len() <= table.n_rows()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_of_other_lines_are_the_same_words() {
        let said =
            |lines: &str| format!("`f3_n` of log.csv is in kgf{lines}: multiply by 9.80665 there");
        let words = without_numbers_of_lines(&said(" from line 23 to line 56"));
        assert_eq!(without_numbers_of_lines(&said(" from line 22 to line 56")), words);
        assert_ne!(
            without_numbers_of_lines(&said(" from line 22 to line 56").replace('9', "8")),
            words
        );
        let some = without_numbers_of_lines(&said(" in lines 4, 7–9"));
        assert_eq!(without_numbers_of_lines(&said(" in lines 5, 8–11")), some);
    }
}
