//! Declared uncertainties in another unit: of some rows, or all.

use super::hypothesis::{Hypothesis, is_or_are, listed, owned, present};
use super::setting::{number, other_setting};
use super::unit::{Dimension, shown};
use crate::case::{Change, Edit, Table};
use crate::kind::Files;
use crate::uncertain::{Std, Uncertain};

/// Times that the uncertainties of some rows must be larger than those of all others to be in another unit.
const APART: f64 = 8.0;
/// Times by which the middle of the one may then be larger or smaller than that of the others: uncertainties of one
/// table may differ by as much.
const ALIKE: f64 = 2.0;

/// Noise that may be given in another unit.
pub(super) const NOISES_MM: [&str; 5] =
    ["point_mm", "deviation_mm", "displacement_mm", "range_mm", "distance_mm"];

/// Noise of forces and of moments, which may both be.
const NOISES_OF_FORCE: [&str; 2] = ["force_n", "moment_nmm"];

/// The declared noise so many times as large as it is declared, in a setting or in a column.
pub(super) fn noise_in_another_unit(files: &Files, times: f64) -> Option<Hypothesis> {
    let what = format!(
        "far too small: what is left goes with nothing, is small beside what was measured and {times:.0} times as large; \
         the noise is declared in another unit (m for mm), or mistyped"
    );
    // To two digits, as it is not known better.
    let two_digits = |value: f64| format!("{value:.1e}").parse::<f64>().ok();
    let of = |key: &'static str| {
        let path = ["noise", key];
        let declared = number(&files.document, &path)?;
        let found = two_digits(declared * times)?;
        let what = format!("{what}: {found} instead of {declared}");
        Some(other_setting(&path, "input:unit", &what, toml::Value::Float(found)))
    };
    let of_column = |uncertain: &Uncertain| {
        let Std::Columns(columns) = uncertain.std else { return None };
        let file = uncertain.table;
        let there = present(files.folder.table(file, &[]).ok().as_ref(), columns);
        let description = format!("{} of {file} {} {what}", listed(&there), is_or_are(&there));
        let change =
            Change::Scale { columns: owned(&there), rows: None, factor: two_digits(times)? };
        let edits = vec![Edit { file, change }];
        (!there.is_empty())
            .then(|| Hypothesis::of("input:unit", (file, &there), description, edits))
    };
    let of_columns = || files.kind.uncertain.iter().find_map(of_column);
    let of_forces = || {
        let all = NOISES_OF_FORCE.into_iter().filter_map(of);
        all.reduce(|one, other| {
            let description = format!("{}; and {}", one.description, other.description);
            Hypothesis { description, ..one.and(&other.edits) }
        })
    };
    NOISES_MM.into_iter().find_map(of).or_else(of_columns).or_else(of_forces)
}

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
