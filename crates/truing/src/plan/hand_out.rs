//! A plan as what people and machines work by.

use std::collections::BTreeMap;
use std::path::Path;

use super::planned::{Planned, PlannedMeasurement, PlannedTouchPlace};
use super::program::program;
use super::rows::Rows;
use crate::Case;
use crate::case::CASE_FILE;
use crate::file::{MAX_BYTES, read_text};
use crate::kinds::{Offer, Offered};

/// File that says what is to be recorded.
const RECORDS: &str = "plan.csv";

/// What is to be measured, one by one.
pub(super) fn measurements(
    rows: &Rows,
    offer: &Offer,
    chosen: &[usize],
) -> Vec<PlannedMeasurement> {
    let one = |(name, &index): (&String, &usize)| {
        let offered @ Offered { told, touch, .. } = &offer.offered[index];
        let number = |(column, cell): &(&'static str, String)| Some((*column, cell.parse().ok()?));
        // Cells of a record are what is read.
        let common = offered.common().filter(|_| !offer.is_record);
        PlannedMeasurement {
            name: name.clone(),
            cells: common.filter_map(number).chain(told.iter().copied()).collect(),
            touch: touch.map(|touch| PlannedTouchPlace {
                contact_mm: touch.contact_mm.into(),
                normal: touch.normal.into_inner().into(),
                ball_mm: touch.ball_mm.into(),
                approach: touch.approach.into_inner().into(),
                feed_mm_per_min: touch.feed_mm_per_min,
            }),
        }
    };
    rows.names.iter().zip(chosen).map(one).collect()
}

/// The rows handed out, by column: those of the table that are to be filled in, or one for each record.
pub(super) fn handed_rows(
    rows: &Rows,
    offer: &Offer,
    chosen: &[usize],
) -> Vec<BTreeMap<String, String>> {
    let (columns, cells) =
        if offer.is_record { records(rows, offer, chosen) } else { rows.handed() };
    let row = |cells: &Vec<String>| columns.iter().cloned().zip(cells.iter().cloned()).collect();
    cells.iter().map(row).collect()
}

/// What is to be done in each record: its name, and what is planned of it.
fn records(rows: &Rows, offer: &Offer, chosen: &[usize]) -> (Vec<String>, Vec<Vec<String>>) {
    let all = || chosen.iter().map(|&index| &offer.offered[index]);
    let told = all().next().into_iter().flat_map(|offered| offered.told.iter());
    let names = all().next().map(|offered| offered.names.to_owned());
    let columns = names.into_iter().chain(told.map(|(name, _)| (*name).to_owned())).collect();
    let row = |(name, offered): (&String, &Offered)| {
        let told = offered.told.iter().map(|(_, value)| value.to_string());
        std::iter::once(name.clone()).chain(told).collect()
    };
    (columns, rows.names.iter().zip(all()).map(row).collect())
}

/// The files to work by: a case to be filled in, and the program where a machine runs one.
pub(super) fn hand_out(
    planned: &mut Planned,
    case: &Case,
    offer: &Offer,
    (rows, tables): (&Rows, &[(&'static str, String)]),
    chosen: &[usize],
) {
    let touches: Vec<_> = chosen.iter().filter_map(|&i| offer.offered[i].touch).collect();
    if let Some(reach) = offer.reach.filter(|_| !touches.is_empty()) {
        let text = program(&rows.names, &touches, &reach);
        planned.files.push(("plan.ngc".to_owned(), text));
    } else if !touches.is_empty() {
        planned.warnings.push(
            "no probing program: the part is touched from below, where no height is safe"
                .to_owned(),
        );
    }
    planned.files.extend(tables.iter().map(|(name, text)| ((*name).to_owned(), text.clone())));
    if offer.is_record {
        let (columns, cells) = records(rows, offer, chosen);
        let lines = std::iter::once(&columns).chain(&cells).map(|cells| cells.join(",") + "\n");
        planned.files.push((RECORDS.to_owned(), lines.collect()));
    }
    let others = case.inputs.iter().filter(|input| {
        input.file == CASE_FILE
            || (tables.iter().all(|(name, _)| input.file != *name)
                && Path::new(&input.file).extension() != Some("toml".as_ref()))
    });
    for input in others {
        let is_name = Path::new(&input.file).components().count() == 1;
        match read_text(&input.path, MAX_BYTES).ok().filter(|_| is_name) {
            Some(text) => planned.files.push((input.file.clone(), text)),
            None => planned.warnings.push(format!("copy {} to the plan yourself", input.file)),
        }
    }
}
