//! What is wrong with the rows of one label alone.

use std::collections::BTreeMap;

use super::hypothesis::{Hypothesis, Proof, is_or_are, listed, owned};
use super::unit::{Dimension, shown};
use crate::case::{Change, Edit, Table};

/// Different labels in a column, at most: each costs a fit.
const MOST_LABELS: usize = 60;

/// Rows of a table with the same text in a column.
pub(crate) struct Label {
    pub(crate) column: String,
    pub(crate) name: String,
    pub(crate) rows: Vec<usize>,
}

/// Labels in the columns of text that are not among those `known`: each on two rows or more, and on less
/// than half of all where there are but two, of which either may be the odd one.
pub(crate) fn labelled(table: &Table, known: &[&str]) -> Vec<Label> {
    let mut all = Vec::new();
    for (index, column) in table.names().iter().enumerate() {
        let is_text = |row: usize| table.cell(row, index).parse::<f64>().is_err();
        if known.contains(&column.as_str()) || !(0..table.n_rows()).all(is_text) {
            continue;
        }
        let labels = labels_of(table, index);
        if labels.len() > MOST_LABELS {
            continue;
        }
        let are_many = labels.len() > 2;
        let is_usable = |rows: &[usize]| {
            rows.len() > 1
                && rows.len() < table.n_rows()
                && (are_many || 2 * rows.len() < table.n_rows())
        };
        let usable = labels.into_iter().filter(|(_, rows)| is_usable(rows));
        all.extend(usable.map(|(name, rows)| Label {
            column: column.clone(),
            name: name.to_owned(),
            rows,
        }));
    }
    all
}

pub(crate) fn labels_of(table: &Table, column: usize) -> BTreeMap<&str, Vec<usize>> {
    let mut labels: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for row in 0..table.n_rows() {
        labels.entry(table.cell(row, column)).or_default().push(row);
    }
    labels
}

/// The rows of each label left out, as those of another part, where the misfit is gross: where it is not,
/// a part that was moved is an effect of the catalogue.
pub(crate) fn of_another_part(
    file: &'static str,
    table: Option<&Table>,
    known: &[&str],
) -> Vec<Hypothesis> {
    let Some(table) = table else { return Vec::new() };
    let without = |Label { column, name, rows }: Label| {
        let description = format!(
            "the {} rows of {file} with `{column}` = `{name}` do not fit the others: they are of another \
             part, or stood elsewhere; leave them out, or measure them again",
            rows.len()
        );
        let kept = (0..table.n_rows()).filter(|row| !rows.contains(row)).collect();
        let edits = vec![Edit { file, change: Change::Keep { rows: kept } }];
        let found = Hypothesis::of("input:misplaced", (file, &[&column]), description, edits);
        Hypothesis {
            subject: format!("{file}: {column} {name}"),
            proof: Proof::FitIfGross,
            ..found
        }
    };
    labelled(table, known).into_iter().map(without).collect()
}

/// Rows of a table: a name for them, and in words what holds in them.
pub(crate) struct Part<'t> {
    pub(crate) name: &'t str,
    pub(crate) said: String,
    pub(crate) rows: Vec<usize>,
}

/// The readings of one instrument, by its name in `label`, in another unit or of the other sign.
pub(crate) fn readings_of_one(
    file: &'static str,
    table: Option<&Table>,
    (label, columns): (&str, &[&str]),
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let labels = table.and_then(|table| Some(labels_of(table, table.column(label)?)));
    let named = |(name, rows)| Part { name, said: format!("`{label}` is `{name}`"), rows };
    let parts: Vec<Part<'_>> = labels.into_iter().flatten().map(named).collect();
    readings_of_each(file, table, columns, &parts, dimension)
}

/// The readings of each of two parts and more in another unit, of the other sign, or with another gain.
pub(crate) fn readings_of_each(
    file: &'static str,
    table: Option<&Table>,
    columns: &[&str],
    parts: &[Part<'_>],
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let declared = table.and_then(|table| table.unit_of(columns)).filter(|_| parts.len() > 1);
    let Some(declared) = declared else { return Vec::new() };
    let of_one = |Part { name, said, rows }: &Part<'_>| {
        let wrong = |effect: &'static str, what: String, factor: f64| {
            let is = is_or_are(columns);
            let description = format!(
                "{} of {file} {is} {what} where {said}: multiply these by {}",
                listed(columns),
                shown(factor)
            );
            let change =
                Change::Scale { columns: owned(columns), rows: Some(rows.clone()), factor };
            let edits = vec![Edit { file, change }];
            let found = Hypothesis::of(effect, (file, columns), description, edits);
            Hypothesis { subject: format!("{} of {name}", found.subject), ..found }
        };
        let of_unit = |(unit, factor): (&str, f64)| {
            let what = format!("in another unit than the name says, {unit},");
            wrong("input:unit", what, factor)
        };
        let mut all: Vec<Hypothesis> = dimension.instead_of(declared).map(of_unit).collect();
        all.push(wrong("input:sign", "of the opposite sign".to_owned(), -1.0));
        let gain = |what: &str, factor| wrong("input:gain", what.to_owned(), factor);
        all.push(gain("twice the reading (another gain, or both ways of a beam),", 0.5));
        all.push(gain("half of the reading (another gain, or one way of two),", 2.0));
        all
    };
    parts.iter().flat_map(of_one).collect()
}
