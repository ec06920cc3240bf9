//! Uncertainties of some rows in another unit.

use super::hypothesis::{Hypothesis, owned, present};
use super::unit::{Dimension, shown};
use crate::case::{Change, Edit, Table};
use crate::kind::Files;
use crate::uncertain::Std;

/// Times that the uncertainties of some rows must be larger than those of all others to be in another unit.
const APART: f64 = 8.0;
/// Times by which the middle of the one may then be larger or smaller than that of the others: uncertainties of one
/// table may differ by as much.
const ALIKE: f64 = 2.0;

/// The smaller ones in a larger unit, or the larger ones in a smaller one, where a column has two sorts.
pub(super) fn uncertainties_of_some_rows(files: &Files) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for uncertain in files.kind.uncertain {
        let Std::Columns(columns) = uncertain.std else { continue };
        let Ok(table) = files.folder.table(uncertain.table, &[]) else { continue };
        for column in present(Some(&table), columns) {
            all.extend(two_sorts(uncertain.table, &table, column).into_iter().flatten());
        }
    }
    all
}

fn two_sorts(file: &'static str, table: &Table, column: &str) -> Option<Vec<Hypothesis>> {
    let values = table.numbers(column)?;
    let mut rows: Vec<usize> = (0..values.len()).collect();
    rows.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let gap = |at: &usize| values[rows[*at]] / values[rows[*at - 1]];
    let at =
        (1..rows.len()).max_by(|a, b| gap(a).total_cmp(&gap(b))).filter(|at| gap(at) >= APART)?;
    let (small, large) = rows.split_at(at);
    let ratio = values[large[large.len() / 2]] / values[small[small.len() / 2]];
    let is_near = |factor: f64| (factor / ratio).max(ratio / factor) <= ALIKE;
    let units = Dimension::Length.instead_of(1.0);
    let scaled = |rows: &[usize], unit: &str, factor: f64| {
        let mut rows = rows.to_vec();
        rows.sort_unstable();
        let description = format!(
            "`{column}` of {file} is in another unit than the name says, {unit}, in {} of {} rows, line {} the first: \
             multiply these by {}",
            rows.len(),
            values.len(),
            table.line(rows[0]),
            shown(factor)
        );
        let change = Change::Scale { columns: owned(&[column]), rows: Some(rows), factor };
        let edits = vec![Edit { file, change }];
        Hypothesis::of("input:unit", (file, &[column]), description, edits)
    };
    let of_unit = |(unit, factor): (&str, f64)| {
        let smaller = is_near(factor).then(|| scaled(small, unit, factor));
        let larger = is_near(1.0 / factor).then(|| scaled(large, unit, factor));
        smaller.into_iter().chain(larger)
    };
    Some(units.flat_map(of_unit).collect())
}
