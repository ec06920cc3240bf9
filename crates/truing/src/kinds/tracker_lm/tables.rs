//! What surveys of ranges and of points have in common in their tables.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use tracker_lm::{Approach, Mount, RotaryAxis, Station, Step};

use super::settings::{MOUNTS, STATIONS, Settings};
use crate::Error;
use crate::case::{ColumnKinds, Columns, Document, Folder, Problem, Table, nearest};

pub(super) const PLACE: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
const KNOWN_STATIONS: &[&str] = &["station", PLACE[0], PLACE[1], PLACE[2]];
const KNOWN_MOUNTS: &[&str] = &["mount", PLACE[0], PLACE[1], PLACE[2], "body"];
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

/// Axis, stations and mounts of a case.
pub(super) struct Setup {
    pub(super) axis: RotaryAxis,
    /// The axis that rides on it.
    pub(super) second_axis: Option<RotaryAxis>,
    pub(super) stations: Vec<Station>,
    pub(super) mounts: Vec<Mount>,
    /// Body that each mount is on; empty where the table does not say.
    pub(super) bodies: Vec<String>,
    /// From the machine's zero to that of axis and stations here.
    pub(super) away_mm: Vector3<f64>,
    stations_table: Table,
    mounts_table: Table,
}

/// What every row of a table of readings refers to.
pub(super) struct References {
    pub(super) station_of: Vec<usize>,
    pub(super) mount_of: Vec<usize>,
    pub(super) steps: Vec<Step>,
    pub(super) step_of: Vec<usize>,
    pub(super) time_s: Option<Vec<f64>>,
}

impl Setup {
    pub(super) fn read(
        folder: &Folder,
        document: &Document,
        settings: &Settings,
    ) -> Result<Self, Error> {
        let mut axis = settings.axis(document)?;
        let away_mm = away(&axis);
        axis.origin_mm -= away_mm;
        let mut second_axis = settings.second_axis(document)?;
        if let Some(second) = &mut second_axis {
            second.origin_mm -= away_mm;
        }
        let stations_table = folder.table(STATIONS, &KNOWN_STATIONS[..4])?;
        let (stations, _) = places(&stations_table, KNOWN_STATIONS, "station")?;
        let mounts_table = folder.table(MOUNTS, &KNOWN_MOUNTS[..4])?;
        let (mounts, bodies) = places(&mounts_table, KNOWN_MOUNTS, "mount")?;
        let near = |(name, at)| Station { name, nominal_mm: at - away_mm };
        let stations = stations.into_iter().map(near).collect();
        let mounts =
            mounts.into_iter().map(|(name, nominal_mm)| Mount { name, nominal_mm }).collect();
        Ok(Self {
            axis,
            second_axis,
            stations,
            mounts,
            bodies,
            away_mm,
            stations_table,
            mounts_table,
        })
    }

    /// Takes the columns that readings of both kinds have.
    pub(super) fn references(
        &self,
        columns: &mut Columns<'_>,
        table: &Table,
        file: &'static str,
    ) -> Result<References, Error> {
        let stations: Vec<&str> = self.stations.iter().map(|s| s.name.as_str()).collect();
        let mounts: Vec<&str> = self.mounts.iter().map(|m| m.name.as_str()).collect();
        let station_of = references(columns, table, "station", &stations, STATIONS)?;
        let mount_of = references(columns, table, "mount", &mounts, MOUNTS)?;
        let step_names = columns.texts("step")?;
        let angles_deg = columns.numbers("angle_deg")?;
        let time_s = if columns.has("time_s") { Some(columns.numbers("time_s")?) } else { None };
        let approaches = columns.words("direction", APPROACHES, Some(None))?;
        all_used((&self.stations_table, &stations), &station_of, "station", file)?;
        all_used((&self.mounts_table, &mounts), &mount_of, "mount", file)?;
        let (steps, step_of) = steps(table, &step_names, &angles_deg, &approaches)?;
        Ok(References { station_of, mount_of, steps, step_of, time_s })
    }
}

/// Farther from its zero than this an axis is counted from its own origin: the grid of a land survey
/// would take the digits that the errors of the axis need.
const FAR_MM: f64 = 1e6;

/// What axis and stations are moved by so that digits are left for them.
fn away(axis: &RotaryAxis) -> Vector3<f64> {
    let origin = axis.origin_mm.coords;
    if origin.amax() > FAR_MM { origin } else { Vector3::zeros() }
}

/// A name with its nominal place.
type NamedPlace = (String, Point3<f64>);

/// Named places and the bodies they are on; further columns are not used.
fn places(
    table: &Table,
    known: &'static [&'static str],
    what: &'static str,
) -> Result<(Vec<NamedPlace>, Vec<String>), Error> {
    let mut columns = Columns::new(table, known);
    let names = columns.ids(what)?;
    let [x, y, z] = PLACE.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    let place = |row: usize| Point3::new(x[row], y[row], z[row]);
    let bodies = if what == "mount" && columns.has("body") {
        columns.texts("body")?.into_iter().map(str::to_owned).collect()
    } else {
        Vec::new()
    };
    columns.rest(&ColumnKinds::default())?;
    let named = names.iter().enumerate().map(|(row, name)| ((*name).to_owned(), place(row)));
    Ok((named.collect(), bodies))
}

/// Index of the station or mount of every row.
fn references(
    columns: &mut Columns<'_>,
    table: &Table,
    what: &'static str,
    known: &[&str],
    file: &'static str,
) -> Result<Vec<usize>, Error> {
    let index: HashMap<&str, usize> = known.iter().copied().zip(0..).collect();
    let of = |(row, name): (usize, &&str)| {
        index.get(*name).copied().ok_or_else(|| {
            let nearest = nearest(name, known.iter().copied()).map(str::to_owned);
            let problem = Problem::UnknownId { what, id: (*name).to_owned(), table: file, nearest };
            Error::case(table.at_cell(row, table.column(what).unwrap_or_default()), problem)
        })
    };
    columns.texts(what)?.iter().enumerate().map(of).collect()
}

fn all_used(
    (table, known): (&Table, &[&str]),
    used: &[usize],
    what: &'static str,
    file: &'static str,
) -> Result<(), Error> {
    let Some(row) = (0..known.len()).find(|i| !used.contains(i)) else { return Ok(()) };
    let problem = Problem::UnusedId { what, id: known[row].to_owned(), table: file };
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

/// Values of a column that belong to the steps, one each.
pub(super) fn of_steps(
    table: &Table,
    (name, values): (&str, &[f64]),
    step_of: &[usize],
) -> Result<Vec<f64>, Error> {
    let mut first_rows: Vec<usize> = Vec::new();
    for (row, &step) in step_of.iter().enumerate() {
        // Steps are numbered in the order in which they first come.
        if step == first_rows.len() {
            first_rows.push(row);
        }
        let first = first_rows[step];
        if values[row].total_cmp(&values[first]).is_ne() {
            return Err(two_values(table, row, first, name));
        }
    }
    Ok(first_rows.into_iter().map(|row| values[row]).collect())
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
