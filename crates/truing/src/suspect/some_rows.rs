//! What may be wrong with some rows of a table.

use std::collections::BTreeSet;

use super::factor::Factor;
use super::hypothesis::{Hypothesis, is_or_are, listed, owned, pairs, present, stretches_of};
use super::unit::{Dimension, all_and_each, shown};
use crate::case::{Change, Edit, Table};

/// Names of which every two may be exchanged, at most.
const MOST_NAMES: usize = 8;

pub(super) const OPPOSITE: &str = "of the opposite sign";

/// What may be wrong with the coordinates in one row.
pub(super) fn changes_of_row(
    (file, table): (&'static str, Option<&Table>),
    row: usize,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let rows = Rows { file, table, these: vec![row] };
    rows.changes(&present(Some(table), columns), Dimension::Length)
}

/// The coordinates in one row exchanged, any two of them, or of the opposite sign, each.
pub(crate) fn axes_of_row(
    (file, table): (&'static str, &Table),
    row: usize,
    columns: &[&str],
) -> Vec<Hypothesis> {
    let rows = Rows { file, table, these: vec![row] };
    let there = present(Some(table), columns);
    let mut all: Vec<_> = rows.all_exchanged(&there).collect();
    let turned = |column: &&str| rows.scaled("input:sign", (&[*column], OPPOSITE), -1.0);
    all.extend(there.iter().map(turned));
    all
}

/// Times by which numbers may be less or more than all others of their column.
const APART: f64 = 3.0;

/// Some rows of a table, in ascending order.
pub(super) struct Rows<'t> {
    pub(super) file: &'static str,
    pub(super) table: &'t Table,
    /// In ascending order.
    pub(super) these: Vec<usize>,
}

impl Rows<'_> {
    pub(super) fn said(&self) -> String {
        let lines: Vec<usize> = self.these.iter().map(|row| self.table.line(*row)).collect();
        match lines[..] {
            [] => String::new(),
            [line] => format!(" in line {line}"),
            [first, .., last] if last - first + 1 == lines.len() => {
                format!(" from line {first} to line {last}")
            }
            _ => format!(" in lines {}", stretches_of(&lines)),
        }
    }

    /// What these rows have in common and few others have: those at the ends may fit by accident.
    pub(super) fn shared(&self) -> Option<String> {
        let of_column = |column: usize| {
            let name = self.table.cell(*self.these.first()?, column);
            let has = |row: usize| self.table.cell(row, column) == name;
            let all = (0..self.table.n_rows()).filter(|row| has(*row)).count();
            let is_theirs =
                self.these.iter().all(|row| has(*row)) && 4 * all <= 5 * self.these.len();
            is_theirs.then(|| {
                format!(
                    ", or a number of another table (a typo, a wrong digit) that belongs to `{}` = `{name}` is wrong",
                    self.table.names()[column]
                )
            })
        };
        (0..self.table.names().len()).find_map(of_column)
    }

    pub(super) fn hypothesis(
        &self,
        effect: &'static str,
        (columns, what, cure): (&[&str], &str, &str),
        change: Change,
    ) -> Hypothesis {
        let file = self.file;
        let is = is_or_are(columns);
        let description =
            format!("{} of {file} {is} {what}{}: {cure} there", listed(columns), self.said());
        Hypothesis::of(effect, (file, columns), description, vec![Edit { file, change }])
    }

    /// Signs, units and factors of all columns and of each, and any two of them exchanged.
    pub(super) fn changes(&self, columns: &[&str], dimension: Dimension) -> Vec<Hypothesis> {
        let sets = all_and_each(columns);
        let mut all: Vec<_> = sets.iter().flat_map(|set| self.factors(set, dimension)).collect();
        // As of a part that was turned by half a turn.
        let both = |pair: [&str; 2]| self.scaled("input:sign", (&pair, OPPOSITE), -1.0);
        all.extend(pairs(columns).map(both));
        // As of a turn the other way round.
        if dimension == Dimension::Direction && columns.len() == 4 {
            let said = (&columns[1..], "of the opposite sign (an inverse, the other way round)");
            all.push(self.scaled("input:sign", said, -1.0));
        }
        all.extend(self.all_exchanged(columns));
        all
    }

    /// Any two columns exchanged.
    fn all_exchanged(&self, columns: &[&str]) -> impl Iterator<Item = Hypothesis> {
        pairs(columns).map(|[one, other]| self.exchanged(&[one], &[other], "exchanged (swapped)"))
    }

    /// Any two names of a column exchanged.
    pub(super) fn names_exchanged(&self, column: &str) -> Vec<Hypothesis> {
        let Some(index) = self.table.column(column) else { return Vec::new() };
        let names: BTreeSet<&str> =
            self.these.iter().map(|row| self.table.cell(*row, index)).collect();
        let names: Vec<&str> = names.into_iter().collect();
        if names.len() > MOST_NAMES {
            return Vec::new();
        }
        let exchanged = |[one, other]: [&str; 2]| {
            let description = format!(
                "the labels `{one}` and `{other}` in `{column}` of {} are exchanged (swapped){}: exchange them there",
                self.file,
                self.said()
            );
            let change = Change::Rename {
                column: column.to_owned(),
                rows: Some(self.these.clone()),
                names: [[one, other], [other, one]].map(|pair| pair.map(str::to_owned)).to_vec(),
            };
            let edits = vec![Edit { file: self.file, change }];
            Hypothesis::of("input:labels", (self.file, &[column]), description, edits)
        };
        pairs(&names).map(exchanged).collect()
    }

    fn factors(&self, set: &[&str], dimension: Dimension) -> Vec<Hypothesis> {
        let Some(declared) = self.table.unit_of(set) else { return Vec::new() };
        let all = Factor::all(dimension, declared).into_iter();
        let may_be = all.filter(|factor| !self.are_put_apart(set, factor.by));
        may_be.map(|Factor { effect, what, by }| self.scaled(effect, (set, &what), by)).collect()
    }

    /// Whether a factor takes numbers that are like the others of their column far from all of them: what a channel
    /// read beside a mistake of another is no other unit of it.
    fn are_put_apart(&self, set: &[&str], factor: f64) -> bool {
        let of_column = |name: &&str| {
            let sizes: Vec<f64> =
                self.table.numbers(name).into_iter().flatten().map(f64::abs).collect();
            let others = (0..sizes.len()).filter(|row| self.these.binary_search(row).is_err());
            let (least, most) = others.fold((f64::INFINITY, 0.0_f64), |(least, most), row| {
                (least.min(sizes[row]), most.max(sizes[row]))
            });
            let like_others = least / APART..most * APART;
            self.these.iter().all(|&row| {
                let factored = sizes[row] * factor.abs();
                like_others.contains(&sizes[row]) && !like_others.contains(&factored)
            })
        };
        set.iter().any(of_column)
    }

    pub(super) fn scaled(
        &self,
        effect: &'static str,
        (set, what): (&[&str], &str),
        factor: f64,
    ) -> Hypothesis {
        let rows = Some(self.these.clone());
        let change = Change::Scale { columns: owned(set), rows, factor };
        let cure = format!("multiply by {}", shown(factor));
        self.hypothesis(effect, (set, what, &cure), change)
    }

    /// The columns of one set exchanged for those of another.
    pub(super) fn sets_exchanged(&self, one: &[&str], other: &[&str]) -> Hypothesis {
        self.exchanged(one, other, "exchanged (swapped, two tables mixed up)")
    }

    fn exchanged(&self, one: &[&str], other: &[&str], what: &str) -> Hypothesis {
        let (there, here) = ([one, other].concat(), [other, one].concat());
        let rows = Some(self.these.clone());
        let change = Change::Permute { columns: owned(&there), sources: owned(&here), rows };
        self.hypothesis("input:exchanged", (&there, what, "exchange them"), change)
    }
}
