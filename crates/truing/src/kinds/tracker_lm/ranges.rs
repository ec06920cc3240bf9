//! The tables of a survey of ranges.

use tracker_lm::{Range, Survey};

use super::measured::TrackerCase;
use super::settings::{MOUNTS, RANGES, STATIONS, Settings};
use super::tables::{References, Setup};
use crate::Error;
use crate::case::{Columns, Document, Folder, group_names};
use crate::measured::Reading;

const NEEDED: &[&str] = &["station", "mount", "step", "angle_deg", "displacement_mm"];
const KNOWN: &[&str] =
    &["station", "mount", "step", "angle_deg", "displacement_mm", "time_s", "direction"];

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: &Settings,
) -> Result<Reading, Error> {
    let setup = Setup::read(folder, document, settings)?;
    let table = folder.table(RANGES, NEEDED)?;
    let mut columns = Columns::new(&table, KNOWN);
    let references = setup.references(&mut columns, &table, RANGES)?;
    let displacements_mm = columns.numbers("displacement_mm")?;
    let extras = columns.rest()?;
    let mut warnings = settings.warnings();
    warnings.extend(extras.warnings);
    let groups = group_names(settings.closure.group.as_ref(), &table, document)?;
    let References { station_of, mount_of, steps, step_of, time_s } = references;
    let ranges = (0..table.n_rows())
        .map(|row| Range {
            station: station_of[row],
            mount: mount_of[row],
            step: step_of[row],
            displacement_mm: displacements_mm[row],
        })
        .collect();
    let Setup { axis, stations, mounts, away_mm, .. } = setup;
    let loop_settings = settings.loop_settings();
    let case = TrackerCase {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        survey: Survey { axis, stations, mounts, steps, ranges },
        options: settings.options(),
        time_s,
        covariates: extras.covariates,
        groups,
        group_noun: settings.closure.group.as_ref().map(|g| g.get_ref().clone()),
        away_mm,
        has_direction: table.column("direction").is_some(),
        plan: settings.plan.clone(),
        solved: std::sync::OnceLock::new(),
    };
    Ok(Reading {
        measured: Box::new(case),
        loop_settings,
        warnings,
        tables: &[STATIONS, MOUNTS, RANGES],
    })
}
