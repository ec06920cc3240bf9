use std::collections::{BTreeMap, BTreeSet};

use super::settings::WRENCH;
use crate::case::{Edit, Table};
use crate::suspect::Hypothesis;

const CHANNELS: [&str; 6] = ["fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"];
/// Different samples of a record that are those of another by no accident, at least: six numbers each.
const FEWEST_COPIED: usize = 5;

/// Records of presses that are those of an earlier one to the last digit, in all six channels.
pub(super) fn copied_records(
    wrench: &Table,
    without: impl Fn(&[bool]) -> Vec<Edit>,
) -> Option<Hypothesis> {
    let press = wrench.column("press")?;
    let columns: Vec<usize> =
        CHANNELS.iter().map(|name| Some(wrench.read_as(name)?.0)).collect::<Option<_>>()?;
    let cells = |row: usize| -> Vec<&str> {
        columns.iter().map(|column| wrench.cell(row, *column)).collect()
    };
    let mut records: BTreeMap<&str, Vec<Vec<&str>>> = BTreeMap::new();
    let mut order: Vec<&str> = Vec::new();
    for row in 0..wrench.n_rows() {
        let name = wrench.cell(row, press);
        let record = records.entry(name).or_insert_with(|| {
            order.push(name);
            Vec::new()
        });
        record.push(cells(row));
    }
    // A channel that stands still repeats without having been copied.
    let is_alive =
        |record: &[Vec<&str>]| record.iter().collect::<BTreeSet<_>>().len() >= FEWEST_COPIED;
    let is_copy = |one: &[Vec<&str>], other: &[Vec<&str>]| {
        let n = one.len().min(other.len());
        is_alive(&one[..n]) && one[..n] == other[..n]
    };
    let original = |at: usize| {
        let record = &records[order[at]];
        order[..at].iter().copied().find(|name| is_copy(&records[name], record))
    };
    let copied: Vec<(&str, &str)> =
        (0..order.len()).filter_map(|at| Some((order[at], original(at)?))).collect();
    let (_, first) = copied.first()?;
    let names: Vec<&str> = copied.iter().map(|(name, _)| *name).collect();
    let description = format!(
        "the six channels of {WRENCH} where `press` is {} repeat those of {first} to the last digit: a block was copied \
         (pasted twice) over what was read; put that back, or leave these presses out",
        names.join(", ")
    );
    let rows: Vec<bool> =
        (0..wrench.n_rows()).map(|row| names.contains(&wrench.cell(row, press))).collect();
    let copied = Hypothesis::of("input:copied", (WRENCH, &CHANNELS), description, without(&rows));
    Some(copied.certain())
}
