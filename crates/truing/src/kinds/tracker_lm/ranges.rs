//! The tables of a survey.

use std::collections::HashMap;

use nalgebra::Point3;
use tracker_lm::{Approach, Mount, Range, Station, Step, Survey};

use super::measured::TrackerCase;
use super::{MOUNTS, RANGES, STATIONS, Settings};
use crate::Error;
use crate::case::{Columns, Document, Folder, Problem, Table, group_names, nearest};
use crate::kinds::Reading;

const PLACE: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
const KNOWN_STATIONS: &[&str] = &["station", PLACE[0], PLACE[1], PLACE[2]];
const KNOWN_MOUNTS: &[&str] = &["mount", PLACE[0], PLACE[1], PLACE[2]];
const NEEDED: &[&str] = &["station", "mount", "step", "angle_deg", "displacement_mm"];
const KNOWN: &[&str] =
    &["station", "mount", "step", "angle_deg", "displacement_mm", "time_s", "direction"];
/// Ways to write which way the axis came.
const APPROACHES: &[(&str, Option<Approach>)] = &[
    ("+1", Some(Approach::Positive)),
    ("1", Some(Approach::Positive)),
    ("+", Some(Approach::Positive)),
    ("1.0", Some(Approach::Positive)),
    ("-1", Some(Approach::Negative)),
    ("-", Some(Approach::Negative)),
    ("-1.0", Some(Approach::Negative)),
];

pub(super) fn read(
    folder: &Folder,
    document: &Document,
    settings: Settings,
) -> Result<Reading, Error> {
    let axis = settings.axis(document)?;
    let stations_table = folder.table(STATIONS, KNOWN_STATIONS)?;
    let stations = places(&stations_table, KNOWN_STATIONS, "station")?;
    let mounts_table = folder.table(MOUNTS, KNOWN_MOUNTS)?;
    let mounts = places(&mounts_table, KNOWN_MOUNTS, "mount")?;

    let table = folder.table(RANGES, NEEDED)?;
    let mut columns = Columns::new(&table, KNOWN);
    let station_of = references(&mut columns, &table, "station", &stations, STATIONS)?;
    let mount_of = references(&mut columns, &table, "mount", &mounts, MOUNTS)?;
    let step_names = columns.texts("step")?;
    let angles_deg = columns.numbers("angle_deg")?;
    let displacements_mm = columns.numbers("displacement_mm")?;
    let time_s = if columns.has("time_s") { Some(columns.numbers("time_s")?) } else { None };
    let approaches = columns.words("direction", APPROACHES, Some(None))?;
    let extras = columns.rest()?;
    all_used(&stations_table, &stations, &station_of, "station")?;
    all_used(&mounts_table, &mounts, &mount_of, "mount")?;
    let (steps, step_of) = steps(&table, &step_names, &angles_deg, &approaches)?;

    let mut warnings = settings.warnings();
    warnings.extend(extras.warnings);
    let groups = group_names(settings.closure.group.as_ref(), &table, document)?;
    let ranges = (0..table.n_rows())
        .map(|row| Range {
            station: station_of[row],
            mount: mount_of[row],
            step: step_of[row],
            displacement_mm: displacements_mm[row],
        })
        .collect();
    let station = |(name, nominal_mm): &(String, Point3<f64>)| Station {
        name: name.clone(),
        nominal_mm: *nominal_mm,
    };
    let mount = |(name, nominal_mm): &(String, Point3<f64>)| Mount {
        name: name.clone(),
        nominal_mm: *nominal_mm,
    };
    let case = TrackerCase {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        survey: Survey {
            axis,
            stations: stations.iter().map(station).collect(),
            mounts: mounts.iter().map(mount).collect(),
            steps,
            ranges,
        },
        options: settings.options(),
        time_s,
        covariates: extras.covariates,
        groups,
        group_noun: settings.closure.group.as_ref().map(|g| g.get_ref().clone()),
        solved: std::sync::OnceLock::new(),
    };
    Ok(Reading {
        measured: Box::new(case),
        loop_settings: settings.closure,
        warnings,
        tables: &[STATIONS, MOUNTS, RANGES],
    })
}

/// Named places; further columns are not used.
fn places(
    table: &Table,
    known: &'static [&'static str],
    what: &'static str,
) -> Result<Vec<(String, Point3<f64>)>, Error> {
    let mut columns = Columns::new(table, known);
    let names = columns.ids(what)?;
    let [x, y, z] = PLACE.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    let place = |row: usize| Point3::new(x[row], y[row], z[row]);
    columns.rest()?;
    Ok(names.iter().enumerate().map(|(row, name)| ((*name).to_owned(), place(row))).collect())
}

/// Index of the station or mount of every row.
fn references(
    columns: &mut Columns<'_>,
    table: &Table,
    what: &'static str,
    known: &[(String, Point3<f64>)],
    file: &'static str,
) -> Result<Vec<usize>, Error> {
    let index: HashMap<&str, usize> =
        known.iter().map(|(name, _)| name.as_str()).zip(0..).collect();
    let of = |(row, name): (usize, &&str)| {
        index.get(*name).copied().ok_or_else(|| {
            let nearest = nearest(name, known.iter().map(|(n, _)| n.as_str())).map(str::to_owned);
            let problem = Problem::UnknownId { what, id: (*name).to_owned(), table: file, nearest };
            Error::case(table.at_cell(row, table.column(what).unwrap_or_default()), problem)
        })
    };
    columns.texts(what)?.iter().enumerate().map(of).collect()
}

fn all_used(
    table: &Table,
    known: &[(String, Point3<f64>)],
    used: &[usize],
    what: &'static str,
) -> Result<(), Error> {
    let Some(row) = (0..known.len()).find(|i| !used.contains(i)) else { return Ok(()) };
    let problem = Problem::UnusedId { what, id: known[row].0.clone(), table: RANGES };
    Err(Error::case(table.at_row(row), problem))
}

/// Steps in the order in which they first come, and the step of every row.
fn steps(
    table: &Table,
    names: &[&str],
    angles_deg: &[f64],
    approaches: &[Option<Approach>],
) -> Result<(Vec<Step>, Vec<usize>), Error> {
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut first_rows: Vec<usize> = Vec::new();
    let mut steps: Vec<Step> = Vec::new();
    let mut step_of = Vec::with_capacity(names.len());
    for (row, name) in names.iter().enumerate() {
        let step = *index.entry(name).or_insert(steps.len());
        if step == steps.len() {
            first_rows.push(row);
            steps.push(Step {
                name: (*name).to_owned(),
                angle_rad: angles_deg[row].to_radians(),
                approach: approaches[row],
            });
        }
        let first = first_rows[step];
        if angles_deg[row].total_cmp(&angles_deg[first]).is_ne() {
            return Err(two_values(table, row, first, "angle_deg"));
        }
        if approaches[row] != approaches[first] {
            return Err(two_values(table, row, first, "direction"));
        }
        step_of.push(step);
    }
    Ok((steps, step_of))
}

fn two_values(table: &Table, row: usize, first: usize, name: &str) -> Error {
    let column = table.column(name).unwrap_or_default();
    let step = table.column("step").unwrap_or_default();
    let problem = Problem::TwoValues {
        what: "step",
        id: table.cell(row, step).to_owned(),
        column: name.to_owned(),
        first: table.cell(first, column).to_owned(),
        second: table.cell(row, column).to_owned(),
    };
    Error::case(table.at_cell(row, column), problem)
}
