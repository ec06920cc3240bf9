//! A stretch of rows that does not fit the others: where it lies is known by leaving it out.

mod changes;

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::Arc;

use super::hypothesis::{Hypothesis, present};
use super::left_out::{only_wrong, shortest};
use super::misfit::Misfit;
use super::order::farthest;
use super::readings::Readings;
use super::search::misfit_with;
use super::some_rows::Rows;
use crate::case::Table;
use crate::kind::Files;

/// Rows of a table in which a stretch is looked for, at most: each part costs a fit.
const MOST_ROWS: usize = 5000;
/// Rows of another session that are wrong one by one, at least, and one in so many: the others happen to fit.
const FEWEST_OF_SESSION: usize = 5;
const ONE_WRONG_IN: usize = 4;
/// Wrong rows that are looked for one by one, at most.
const MOST_SCATTERED: usize = 30;

/// Rows without which the others fit.
#[derive(Debug)]
pub(super) struct Stretch {
    of: Readings,
    /// The rows in another order than that of the table; `None` where it lies in that.
    order: Option<Arc<[usize]>>,
    rows: Range<usize>,
    /// Those of them without which the others fit already.
    wrong: Vec<usize>,
    /// Rows of the table.
    n: usize,
}

impl Stretch {
    /// All of a case, which `fits` without each of them.
    pub(super) fn all_of(files: &Files, fits: &(impl Fn(&Misfit) -> bool + Sync)) -> Vec<Self> {
        let is_there = |of: &&Readings| files.folder.has(of.file);
        let of_table = |of: &Readings| Self::of_table(files, of, None, fits);
        files.kind.readings.iter().filter(is_there).flat_map(of_table).collect()
    }

    /// The same where the rows are in another order, one after the other.
    pub(super) fn in_other_orders(
        files: &Files,
        fits: &(impl Fn(&Misfit) -> bool + Sync),
    ) -> impl Iterator<Item = Vec<Self>> {
        let all =
            files.kind.readings.iter().flat_map(|of| of.orders.iter().map(move |by| (of, by)));
        all.filter_map(move |(of, by)| {
            let order = sorted_by(&files.folder.table(of.file, by).ok()?, by)?;
            Some(Self::of_table(files, of, Some(&order), fits))
        })
    }

    fn of_table(
        files: &Files,
        of: &Readings,
        order: Option<&Arc<[usize]>>,
        fits: &(impl Fn(&Misfit) -> bool + Sync),
    ) -> Vec<Self> {
        let Ok(table) = files.folder.table(of.file, &[]) else { return Vec::new() };
        let n = table.n_rows();
        let without = |rows: &[usize]| fits_without(files, of, rows, fits);
        let places = order.map(|order| &**order);
        let without_all = |rows: &Range<usize>| without(&in_order(places, rows));
        if !(of.fewest + 1..=MOST_ROWS).contains(&n) {
            return Vec::new();
        }
        let of_rows = |rows: Range<usize>| {
            let wrong = only_wrong(in_order(places, &rows), &without);
            Self { of: *of, order: order.cloned(), rows, n, wrong }
        };
        shortest((n, of.fewest), &without_all).into_iter().map(of_rows).collect()
    }

    /// Rows here and there, each the farthest off of those that are left, without which the others fit.
    pub(super) fn scattered(files: &Files, fits: &impl Fn(&Misfit) -> bool) -> Vec<Self> {
        let of_table = |of: &Readings| {
            let n = files.folder.table(of.file, &[]).ok()?.n_rows();
            let (mut rows, mut gone): (Vec<usize>, Vec<usize>) = ((0..n).collect(), Vec::new());
            for _ in 0..MOST_SCATTERED.min(n / 3) {
                let edits = of.without(&files.folder, &gone)?;
                let reading = files.with(&edits).read().ok()?;
                let fitted = reading.measured.fit_alone().ok()?;
                if fits(&Misfit::of(&*reading.measured, &fitted).0) {
                    return Self::of_those(files, of.file, gone);
                }
                // What is fitted must be the rows of this table.
                if fitted.observations.len() != rows.len() {
                    return None;
                }
                gone.push(rows.remove(*farthest(&fitted, 1).first()?));
                gone.sort_unstable();
            }
            None
        };
        let of_rows = |of: &&Readings| files.folder.has(of.file) && !of.are_places;
        files.kind.readings.iter().filter(of_rows).filter_map(of_table).collect()
    }

    /// Some rows of a table, without which the others fit, but for those that need not be left out.
    pub(super) fn of_wrong_ones(
        files: &Files,
        of: &Readings,
        rows: Vec<usize>,
        fits: &impl Fn(&Misfit) -> bool,
    ) -> Option<Self> {
        let without = |rows: &[usize]| fits_without(files, of, rows, fits);
        Self::of_those(files, of.file, only_wrong(rows, &without))
    }

    /// Some rows that misfit, of a table of readings.
    pub(super) fn of_those(files: &Files, file: &str, wrong: Vec<usize>) -> Option<Self> {
        let of = *files.kind.readings.iter().find(|of| of.file == file)?;
        let n = files.folder.table(of.file, &[]).ok()?.n_rows();
        Some(Self { of, order: None, rows: *wrong.first()?..wrong.last()? + 1, n, wrong })
    }

    fn all(&self) -> Vec<usize> {
        in_order(self.order.as_deref(), &self.rows)
    }

    /// Whether its rows are places, which physics does not move one by one.
    pub(super) fn is_of_places(&self) -> bool {
        self.of.are_places
    }

    /// How many of its rows are wrong.
    pub(super) fn n_wrong(&self) -> usize {
        self.wrong.len()
    }

    /// Whether as many of its rows are wrong as of a session of another day.
    pub(super) fn is_of_a_session(&self) -> bool {
        self.wrong.len() >= FEWEST_OF_SESSION.max(self.rows.len() / ONE_WRONG_IN)
    }

    /// Whether most rows are others: what one half has and the other has not is as likely physics that goes with
    /// time or direction.
    pub(super) fn is_of_the_few(&self) -> bool {
        2 * self.rows.len() < self.n
    }

    /// That the rows are not of this table, whatever is wrong with them.
    pub(super) fn misplaced(&self, files: &Files) -> Option<Hypothesis> {
        let Readings { file, sets, .. } = self.of;
        let table = files.folder.table(file, &[]).ok()?;
        let mut all = sets.iter().map(|(columns, _)| present(Some(&table), columns));
        let columns = all.find(|columns| !columns.is_empty())?;
        let these = if self.is_of_a_session() { self.all() } else { self.wrong.clone() };
        let rows = Rows { file, table: &table, these };
        let (those, do_not) =
            if rows.these.len() == 1 { ("a row", "does not") } else { ("the rows", "do not") };
        let ball = if files.kind.touches.is_some() {
            ", with another ball (tip radius), contact points for centres of the ball (compensated)"
        } else {
            ""
        };
        let description = format!(
            "{those} of {file}{} {do_not} fit the others, which fit without: of another session, set-up or part{ball}, \
             displaced, turned, shifted, mistyped (typos, digits lost) or exchanged, or pasted from elsewhere{}; look there, \
             and leave out what is wrong",
            rows.said(),
            self.read_there().or_else(|| rows.shared()).unwrap_or_default()
        );
        let edits = self.of.without(&files.folder, &rows.these)?;
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
}

/// Whether a case fits without some rows of a table.
fn fits_without(
    files: &Files,
    of: &Readings,
    rows: &[usize],
    fits: &impl Fn(&Misfit) -> bool,
) -> bool {
    let left = of.without(&files.folder, rows).and_then(|edits| misfit_with(files, &edits));
    left.is_some_and(|misfit| fits(&misfit))
}

/// Rows of a table by their places in an order, in ascending order.
fn in_order(order: Option<&[usize]>, places: &Range<usize>) -> Vec<usize> {
    let Some(order) = order else { return places.clone().collect() };
    let mut rows = order[places.clone()].to_vec();
    rows.sort_unstable();
    rows
}

/// The rows sorted by some columns, numbers by their size; `None` where that is how they stand.
fn sorted_by(table: &Table, columns: &[&str]) -> Option<Arc<[usize]>> {
    let columns: Option<Vec<usize>> = columns.iter().map(|name| table.column(name)).collect();
    let columns = columns?;
    let number = |row: usize, column: usize| table.cell(row, column).parse::<f64>();
    let compare = |a: usize, b: usize, column: usize| match (number(a, column), number(b, column)) {
        (Ok(a), Ok(b)) => a.total_cmp(&b),
        _ => table.cell(a, column).cmp(table.cell(b, column)),
    };
    let mut rows: Vec<usize> = (0..table.n_rows()).collect();
    rows.sort_by(|&a, &b| {
        let by_each = columns.iter().map(|&column| compare(a, b, column));
        by_each.fold(Ordering::Equal, Ordering::then)
    });
    let stands = rows.iter().enumerate().all(|(at, row)| at == *row);
    (!stands).then(|| Arc::from(rows))
}
