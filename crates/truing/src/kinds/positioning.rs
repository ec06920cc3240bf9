//! `positioning`: a linear or rotary axis sent to targets, by ISO 230-2.

mod approach;
mod at_targets;
mod axis_run;
mod directions;
mod estimates;
mod figures;
mod form;
mod measured;
mod places;
mod plan;
mod rearranged;
mod repeats;
mod suspects;

use ft_center::{AxisMotion, AxisReading};
use serde::Deserialize;

use crate::Error;
use crate::case::{Columns, Document, Folder, LoopSettings, Positive, Problem, Table, group_names};
use crate::kind::{Files, Kind};
use crate::measured::{Fitted, Reading};
use crate::suspect::{Dimension, Hypothesis, Readings, Set};

use approach::{DIRECTION, POSITIONS};
pub(crate) use approach::{approaches, derived, has_directions, names_of};
pub use axis_run::{AxisFigureEstimate, AxisRunEstimate, AxisTargetEstimate};
pub use estimates::{PositionResidual, PositioningEstimates};
pub use figures::{AxisCorrection, PositioningFigures};
pub(crate) use form::positioning_form;
use measured::PositioningCase;
pub(crate) use plan::{AxisPlanSettings, AxisTable, Ways};
pub(crate) use suspects::mistakes_of_axis;

/// Columns of a table of targets and of what was reached.
pub(crate) const AXIS: &[Set] = &[
    (&["deviation_mm"], Dimension::Deviation),
    (&["deviation_deg"], Dimension::Deviation),
    (&["deviation_arcsec"], Dimension::Deviation),
    (&["solved_mm"], Dimension::Length),
    (&["commanded_mm"], Dimension::Length),
    (&["actual_mm"], Dimension::Length),
    (&["target_mm"], Dimension::Length),
    (&["actual_deg"], Dimension::Angle),
    (&["target_deg"], Dimension::Angle),
];

pub(crate) const KIND: Kind = Kind {
    name: "positioning",
    summary: "linear or rotary axis sent to targets, by ISO 230-2",
    read,
    mistakes,
    record: None,
    touches: None,
    readings: &[Readings::of(POSITIONS, AXIS)],
    typed: &[],
    uncertain: &[],
    example: &[
        ("case.toml", include_str!("../../templates/positioning/case.toml")),
        ("positions.csv", include_str!("../../templates/positioning/positions.csv")),
    ],
};

const KNOWN: &[&str] = &[
    "point",
    "target_mm",
    "actual_mm",
    "deviation_mm",
    "target_deg",
    "actual_deg",
    "deviation_deg",
    "deviation_arcsec",
    DIRECTION,
    "cycle",
];
/// Seconds of arc of a degree.
const ARCSEC_PER_DEG: f64 = 3600.0;
const TURN_DEG: f64 = 360.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    #[serde(rename = "kind")]
    _kind: serde::de::IgnoredAny,
    #[serde(default)]
    axis: AxisSettings,
    #[serde(default)]
    noise: NoiseSettings,
    #[serde(default)]
    plan: AxisPlanSettings,
    #[serde(default, rename = "conformity")]
    _conformity: serde::de::IgnoredAny,
    #[serde(default, rename = "loop")]
    closure: LoopSettings,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisSettings {
    lead_mm: Option<Positive>,
    lead_deg: Option<Positive>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct NoiseSettings {
    /// Displacements of a sensor name it after themselves.
    #[serde(alias = "displacement_mm")]
    deviation_mm: Option<Positive>,
    deviation_arcsec: Option<Positive>,
    length_ppm: Option<Positive>,
    angle_arcsec: Option<Positive>,
}

/// Targets and deviations as the table has them.
struct Positions {
    motion: AxisMotion,
    targets: Vec<f64>,
    deviations: Vec<f64>,
}

fn read(folder: &Folder, document: &Document) -> Result<Reading, Error> {
    read_targets(POSITIONS, folder, document)
}

fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    mistakes_of_axis(POSITIONS, files, fitted)
}

/// Whether a table has targets by the names that this kind knows.
pub(crate) fn has_targets(table: &Table) -> bool {
    ["target_mm", "target_deg"].iter().any(|column| table.has(column))
}

/// One axis of which this file of the case has the targets.
pub(crate) fn read_targets(
    file: &'static str,
    folder: &Folder,
    document: &Document,
) -> Result<Reading, Error> {
    let settings: Settings = document.settings()?;
    let table = folder.table(file, &["target_mm", "actual_mm", DIRECTION, "cycle"])?;
    one_axis(&table)?;
    let mut columns = Columns::new(&table, KNOWN);
    let positions = positions(&table, &mut columns)?;
    let of_table = AxisTable {
        file,
        target: if columns.has("target_deg") { "target_deg" } else { "target_mm" },
        reading: reading(&columns),
        has_direction: columns.has(DIRECTION),
        has_cycle: columns.has("cycle"),
    };
    let mut warnings = Vec::new();
    let approaches = if columns.has(DIRECTION) {
        approaches(&mut columns)?
    } else {
        warnings.push(
            "no column `direction`: which way the axis came is taken from the target before"
                .to_owned(),
        );
        derived(&positions.targets)
    };
    // Labels: `[loop] group = "cycle"` leaves whole cycles out.
    let cycles = columns.has("cycle").then(|| columns.texts("cycle")).transpose()?;
    let cycles = cycles.map(|names| places_of(&names));
    let points = columns.has("point").then(|| columns.texts("point")).transpose()?;
    let lines: Vec<usize> = (0..table.n_rows()).map(|row| table.line(row)).collect();
    let unit = positions.motion.target_unit();
    let at = |target: &f64| format!("{target} {unit}");
    let given: Vec<String> = match points {
        Some(points) => points.into_iter().map(str::to_owned).collect(),
        None => positions.targets.iter().map(at).collect(),
    };
    let names = names_of(&given, &lines);
    let readings: Vec<AxisReading> = (names.into_iter().zip(approaches).enumerate())
        .map(|(row, (name, approach))| AxisReading {
            name,
            target: positions.targets[row],
            deviation: positions.deviations[row],
            approach,
        })
        .collect();
    let extras = columns.rest(&settings.closure.columns)?;
    warnings.extend(extras.warnings);
    let (sigma, lead, length_ratio) = declared(&settings, &positions, &mut warnings);
    let group = settings.closure.group.as_ref();
    let (groups, group_noun) = match group_names(group, &table, document)? {
        Some(groups) => (groups, group.map_or_else(String::new, |g| g.get_ref().clone())),
        None => (readings.iter().map(|r| r.name.clone()).collect(), "reading".to_owned()),
    };
    let measured = PositioningCase {
        file: table.at_file(),
        readings,
        motion: positions.motion,
        sigma,
        lead,
        length_ratio,
        cycles,
        covariates: extras.covariates,
        groups,
        group_noun,
        plan: settings.plan,
        of_table,
    };
    Ok(Reading {
        measured: Box::new(measured),
        loop_settings: settings.closure,
        warnings,
        tables: vec![file],
    })
}

/// A table is of one axis, whose name may stand beside every row.
pub(crate) fn one_axis(table: &Table) -> Result<(), Error> {
    let Some(column) = table.column("axis") else { return Ok(()) };
    let axis = |row: usize| table.cell(row, column);
    let Some(row) = (1..table.n_rows()).find(|row| axis(*row) != axis(0)) else { return Ok(()) };
    let [first, second] = [0, row].map(|row| axis(row).to_owned());
    Err(Error::case(table.at_cell(row, column), Problem::SecondAxis { first, second }))
}

/// The column of what is read, and whether that is the position reached.
fn reading(columns: &Columns<'_>) -> (&'static str, bool) {
    let deviations = ["deviation_mm", "deviation_arcsec", "deviation_deg"];
    if let Some(deviation) = deviations.into_iter().find(|name| columns.has(name)) {
        return (deviation, false);
    }
    (if columns.has("target_deg") { "actual_deg" } else { "actual_mm" }, true)
}

/// Deviations in seconds of arc, as 359.999° is a thousandth below 0°; the table's notes say where that was so.
fn within_a_turn(table: &Table, off_deg: Vec<f64>) -> Vec<f64> {
    let turns = |off: f64| (off / TURN_DEG).round();
    let wrapped = off_deg.iter().filter(|off| turns(**off).abs() > 0.5).count();
    if wrapped > 0 {
        table.note(format!(
            "{wrapped} positions a full turn from their targets: taken for what they are within it"
        ));
    }
    off_deg.into_iter().map(|off| ARCSEC_PER_DEG * (off - TURN_DEG * turns(off))).collect()
}

fn positions(table: &Table, columns: &mut Columns<'_>) -> Result<Positions, Error> {
    let is_rotary = columns.has("target_deg");
    if is_rotary && columns.has("target_mm") {
        return Err(exclusive(columns, "target_mm", "target_deg"));
    }
    let (motion, target, actual): (_, _, &'static str) = if is_rotary {
        (AxisMotion::Rotary, "target_deg", "actual_deg")
    } else {
        (AxisMotion::Linear, "target_mm", "actual_mm")
    };
    let targets = columns.numbers(target)?;
    let of_rotary = ["deviation_arcsec", "deviation_deg"];
    let found = if is_rotary { &of_rotary[..] } else { &["deviation_mm"] };
    let found = found.iter().copied().find(|name| columns.has(name));
    let Some(deviation) = found else {
        let actual = columns.numbers(actual)?;
        let off = targets.iter().zip(actual).map(|(t, a)| a - t);
        let deviations = match motion {
            AxisMotion::Linear => off.collect(),
            AxisMotion::Rotary => within_a_turn(table, off.collect()),
        };
        return Ok(Positions { motion, targets, deviations });
    };
    if columns.has(actual) {
        return Err(exclusive(columns, deviation, actual));
    }
    let factor = if deviation == "deviation_deg" { ARCSEC_PER_DEG } else { 1.0 };
    let deviations = columns.numbers(deviation)?.into_iter().map(|d| factor * d).collect();
    Ok(Positions { motion, targets, deviations })
}

fn exclusive(columns: &Columns<'_>, column: &str, other: &str) -> Error {
    let (column, other) = (column.to_owned(), other.to_owned());
    Error::case(columns.at(&column), Problem::ExclusiveColumns { column, other })
}

/// Noise of a deviation, lead of the screw, and uncertainty of the length standard over the length.
fn declared(
    settings: &Settings,
    positions: &Positions,
    warnings: &mut Vec<String>,
) -> (Option<f64>, Option<f64>, Option<f64>) {
    let value = |setting: &Option<Positive>| setting.as_ref().map(|Positive(value)| *value);
    let of_linear = [
        ("[axis] lead_mm", value(&settings.axis.lead_mm)),
        ("[noise] deviation_mm", value(&settings.noise.deviation_mm)),
        ("[noise] length_ppm", value(&settings.noise.length_ppm)),
    ];
    let of_rotary = [
        ("[axis] lead_deg", value(&settings.axis.lead_deg)),
        ("[noise] deviation_arcsec", value(&settings.noise.deviation_arcsec)),
        ("[noise] angle_arcsec", value(&settings.noise.angle_arcsec)),
    ];
    let (own, others) = match positions.motion {
        AxisMotion::Linear => (of_linear, of_rotary),
        AxisMotion::Rotary => (of_rotary, of_linear),
    };
    for (key, _) in others.iter().filter(|(_, value)| value.is_some()) {
        warnings.push(format!(
            "`{key}` is not used with targets in {}",
            positions.motion.target_unit()
        ));
    }
    let [(_, lead), (noise, sigma), (_, standard)] = own;
    if sigma.is_none() {
        warnings
            .push(format!("no `{noise}`: the standard uncertainty is estimated from the residual"));
    }
    let low = positions.targets.iter().copied().fold(f64::INFINITY, f64::min);
    let high = positions.targets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let ratio = match positions.motion {
        AxisMotion::Linear => standard.map(|ppm| 1e-6 * ppm),
        AxisMotion::Rotary => standard.filter(|_| high > low).map(|u| u / (high - low)),
    };
    (sigma, lead, ratio)
}

/// For each name the place at which it first stands among those before it.
fn places_of<'t>(names: &[&'t str]) -> Vec<usize> {
    let mut known: Vec<&'t str> = Vec::new();
    let mut place = |name: &&'t str| {
        known.iter().position(|other| other == name).unwrap_or_else(|| {
            known.push(name);
            known.len() - 1
        })
    };
    names.iter().map(&mut place).collect()
}
