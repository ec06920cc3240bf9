//! Channels of a record that come late, or too early, by some samples.

use rayon::prelude::*;

use super::hypothesis::{Hypothesis, present};
use super::misfit::Misfit;
use super::order::rows_shifted_by;
use super::readings::Readings;
use super::search::misfit_with;
use crate::kind::Files;

/// Samples by which a channel is tried as late, either way: of a signal that goes up and down, only the right number
/// helps.
const FARTHEST: isize = 24;
/// Samples by which the first trials lie apart: what is so far from the right number helps, too, unless the signal turns
/// within as many.
const APART: usize = 3;

/// Each channel of the record shifted by the samples that leave the least.
pub(super) fn late_channels(files: &Files) -> Vec<Hypothesis> {
    let Some((file, within)) = files.kind.record else { return Vec::new() };
    let Ok(table) = files.folder.table(file, &[]) else { return Vec::new() };
    let of_table = |of: &Readings| match of.samples {
        Some(samples) if samples.file == file => samples.sets,
        _ if of.file == file => of.sets,
        _ => &[],
    };
    let sets = files.kind.readings.iter().flat_map(of_table);
    let columns: Vec<&str> = sets.flat_map(|(columns, _)| present(Some(&table), columns)).collect();
    let of_column = |column: &&str| {
        let tried = |by: isize| -> Option<(Misfit, Hypothesis)> {
            let all = rows_shifted_by(file, Some(&table), &[*column], Some(within), by);
            // The last drops the rows that have lost their partner.
            let shifted = all.into_iter().next_back()?;
            Some((misfit_with(files, &shifted.edits)?, shifted))
        };
        let of_least = |all: &mut dyn Iterator<Item = isize>| {
            let all = all.filter(|by| (2..=FARTHEST).contains(&by.abs()));
            let all = all.filter_map(|by| Some((by, tried(by)?)));
            all.min_by(|a, b| a.1.0.share.total_cmp(&b.1.0.share))
        };
        let (about, _) = of_least(&mut (2..=FARTHEST).step_by(APART).flat_map(|by| [by, -by]))?;
        let (_, (_, shifted)) = of_least(&mut (about - 2..=about + 2))?;
        Some(shifted)
    };
    columns.par_iter().filter_map(of_column).collect()
}
