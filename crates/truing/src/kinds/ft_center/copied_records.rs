use std::collections::BTreeSet;

use super::settings::WRENCH;
use crate::case::{Edit, Table};
use crate::suspect::{Hypothesis, labels_of};

/// Different samples of a record that are those of another by no accident, at least: six numbers each.
const FEWEST_COPIED: usize = 5;

/// Records of presses that are those of an earlier one to the last digit, in all six channels.
pub(super) fn copied_records(
    wrench: &Table,
    channels: &[&str],
    without: impl Fn(&[bool]) -> Vec<Edit>,
) -> Option<Hypothesis> {
    let press = wrench.column("press")?;
    let columns: Vec<usize> =
        channels.iter().map(|name| Some(wrench.read_as(name)?.0)).collect::<Option<_>>()?;
    let cells = |row: &usize| -> Vec<&str> {
        columns.iter().map(|column| wrench.cell(*row, *column)).collect()
    };
    let mut records: Vec<(&str, Vec<usize>)> = labels_of(wrench, press).into_iter().collect();
    records.sort_by_key(|(_, rows)| rows[0]);
    let records: Vec<(&str, Vec<Vec<&str>>)> = (records.into_iter())
        .map(|(name, rows)| (name, rows.iter().map(cells).collect()))
        .collect();
    // A channel that stands still repeats without having been copied.
    let is_alive =
        |record: &[Vec<&str>]| record.iter().collect::<BTreeSet<_>>().len() >= FEWEST_COPIED;
    let is_copy = |one: &[Vec<&str>], other: &[Vec<&str>]| {
        let n = one.len().min(other.len());
        is_alive(&one[..n]) && one[..n] == other[..n]
    };
    let original = |at: usize| {
        let (name, record) = &records[at];
        let (of, _) = records[..at].iter().find(|(_, other)| is_copy(other, record))?;
        Some((*name, *of))
    };
    let copied: Vec<(&str, &str)> = (0..records.len()).filter_map(original).collect();
    let (_, first) = copied.first()?;
    let names: Vec<&str> = copied.iter().map(|(name, _)| *name).collect();
    let description = format!(
        "the six channels of {WRENCH} where `press` is {} repeat those of {first} to the last digit: a block was copied \
         (pasted twice) over what was read; put that back, or leave these presses out",
        names.join(", ")
    );
    let rows: Vec<bool> =
        (0..wrench.n_rows()).map(|row| names.contains(&wrench.cell(row, press))).collect();
    let copied = Hypothesis::of("input:copied", (WRENCH, channels), description, without(&rows));
    Some(copied.certain())
}
