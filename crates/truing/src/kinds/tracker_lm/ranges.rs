//! The tables of a survey of ranges.

use tracker_lm::{Range, RotaryAxis, SecondAxis, Survey, find_axis};

use super::measured::TrackerCase;
use super::settings::{MOUNTS, RANGES, STATIONS, Settings, error};
use super::tables::{References, Setup, of_steps};
use crate::Error;
use crate::case::{Columns, Document, Folder, group_names};
use crate::measured::Reading;

const NEEDED: &[&str] = &["station", "mount", "step", "angle_deg", "displacement_mm"];
const KNOWN: &[&str] =
    &["station", "mount", "step", "angle_deg", "displacement_mm", "time_s", "direction"];
/// Of a head with two axes.
const SECOND_ANGLE: &str = "second_angle_deg";
const NEEDED_OF_TWO: &[&str] =
    &["station", "mount", "step", "angle_deg", SECOND_ANGLE, "displacement_mm"];
const KNOWN_OF_TWO: &[&str] = &[
    "station",
    "mount",
    "step",
    "angle_deg",
    SECOND_ANGLE,
    "displacement_mm",
    "time_s",
    "direction",
];

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: &Settings,
) -> Result<Reading, Error> {
    let setup = Setup::read(folder, document, settings)?;
    let (needed, known) = match &setup.second_axis {
        None => (NEEDED, KNOWN),
        Some(_) => (NEEDED_OF_TWO, KNOWN_OF_TWO),
    };
    let table = folder.table(RANGES, needed)?;
    let mut columns = Columns::new(&table, known);
    let references = setup.references(&mut columns, &table, RANGES)?;
    let second = match setup.second_axis {
        None => None,
        Some(axis) => {
            let angles_deg = columns.numbers(SECOND_ANGLE)?;
            let angles_deg = of_steps(&table, (SECOND_ANGLE, &angles_deg), &references.step_of)?;
            let angles_rad = angles_deg.into_iter().map(f64::to_radians).collect();
            Some(SecondAxis { axis, angles_rad })
        }
    };
    let displacements_mm = columns.numbers("displacement_mm")?;
    let extras = columns.rest(&settings.closure.columns)?;
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
    let mut survey = Survey { axis, second, stations, mounts, steps, ranges };
    let options = settings.options();
    if let Some(sought) = settings.sought() {
        survey.axis =
            find_axis(&survey, sought, &options).map_err(|e| error(table.at_file(), e))?;
        warnings.push(where_found(&survey.axis));
    }
    let loop_settings = settings.loop_settings();
    let case = TrackerCase {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        survey,
        options,
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
        tables: vec![STATIONS, MOUNTS, RANGES],
    })
}

fn where_found(axis: &RotaryAxis) -> String {
    let [x, y, z] = axis.origin_mm.coords.into();
    let [i, j, k] = axis.direction.into_inner().into();
    format!(
        "`[axis] origin_mm` is not declared: the axis found is the line that the reflectors turn \
         about, through ({x:.4}, {y:.4}, {z:.4}) mm along ({i:.7}, {j:.7}, {k:.7}); its errors are \
         against this line"
    )
}
