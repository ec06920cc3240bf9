//! `positioning`: a linear or rotary axis sent to targets, by ISO 230-2.

mod approach;
mod at_targets;
mod axis_run;
mod directions;
mod estimates;
mod form;
mod measured;
mod places;
mod plan;
mod rearranged;
mod repeats;

use ft_center::{Approach, AxisMotion, AxisReading};
use serde::Deserialize;

use crate::Error;
use crate::case::{
    Change, Columns, Document, Edit, Folder, LoopSettings, Positive, Problem, Table, group_names,
};
use crate::count::count;
use crate::kind::Files;
use crate::kind::Kind;
use crate::measured::{Fitted, Reading};
use crate::suspect::{
    Dimension, Hypothesis, Part, Readings, Twice, all_in_metres, at_end, channels, doubled,
    exchanged_deviations, exchanged_rows, exchanged_targets, farthest, held, increments, number,
    points_lost, readings_of_each, readings_of_one, rows_left_out, signs, standing_still, units,
    zeros,
};

use approach::{DIRECTION, POSITIONS};
pub(crate) use approach::{approaches, derived, has_directions, names_of};
use at_targets::{
    at_other_targets, coarser_than_noise, signs_lost, targets_as_deviations, thousands,
};
pub use axis_run::{AxisFigureEstimate, AxisRunEstimate, AxisTargetEstimate};
pub(crate) use directions::{filled_directions, turned_directions};
use directions::{said_otherwise, said_ways, turned_sign};
pub use estimates::{PositionResidual, PositioningEstimates};
pub(crate) use form::positioning_form;
use measured::PositioningCase;
pub(crate) use plan::{AxisPlanSettings, AxisTable, Ways};
use repeats::{FINER, Repeats};

pub(crate) const KIND: Kind = Kind {
    name: "positioning",
    summary: "linear or rotary axis sent to targets, by ISO 230-2",
    read,
    mistakes,
    record: None,
    touches: None,
    readings: &[Readings::of(
        POSITIONS,
        &[
            (&["deviation_mm"], Dimension::Deviation),
            (&["deviation_deg"], Dimension::Deviation),
            (&["deviation_arcsec"], Dimension::Deviation),
            (&["actual_mm"], Dimension::Length),
            (&["target_mm"], Dimension::Length),
            (&["actual_deg"], Dimension::Angle),
            (&["target_deg"], Dimension::Angle),
        ],
    )],
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
/// Rows looked at for exchanged labels.
const FARTHEST: usize = 6;

/// Fewest equal positions at one end that are no accident, where their targets lie beyond.
const FEWEST_CLIPPED: usize = 3;
/// By how much of the travel these lie beyond it: no axis misses by that.
const CLIPPED_BY: f64 = 0.005;

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
    let settings: Settings = document.settings()?;
    let table = folder.table(POSITIONS, &["target_mm", "actual_mm", DIRECTION, "cycle"])?;
    let mut columns = Columns::new(&table, KNOWN);
    let positions = positions(&mut columns)?;
    let of_table = AxisTable {
        file: POSITIONS,
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
        tables: vec![POSITIONS],
    })
}

/// The column of what is read, and whether that is the position reached.
fn reading(columns: &Columns<'_>) -> (&'static str, bool) {
    let deviations = ["deviation_mm", "deviation_arcsec", "deviation_deg"];
    if let Some(deviation) = deviations.into_iter().find(|name| columns.has(name)) {
        return (deviation, false);
    }
    (if columns.has("target_deg") { "actual_deg" } else { "actual_mm" }, true)
}

fn positions(columns: &mut Columns<'_>) -> Result<Positions, Error> {
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
        let deviations = targets.iter().zip(actual);
        let deviations = match motion {
            AxisMotion::Linear => deviations.map(|(t, a)| a - t).collect(),
            // 359.999° is a thousandth below 0°.
            AxisMotion::Rotary => deviations
                .map(|(t, a)| {
                    let turned = a - t;
                    ARCSEC_PER_DEG * (turned - TURN_DEG * (turned / TURN_DEG).round())
                })
                .collect(),
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

fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let Ok(table) = files.folder.table(POSITIONS, &["target_mm"]) else { return Vec::new() };
    let pair = |table: &Table| -> Option<[&'static str; 2]> {
        [["target_mm", "actual_mm"], ["target_deg", "actual_deg"]]
            .into_iter()
            .find(|[_, actual]| table.has(actual))
    };
    let Some(columns) = pair(&table) else { return of_deviations(files, &table) };
    let table = Some(&table);
    let dimension = if columns[0] == "target_mm" { Dimension::Length } else { Dimension::Angle };
    let turned = table.and_then(|table| turned_directions((POSITIONS, table), columns[0]));
    // Which of the two is mirrored the directions tell, where there are any.
    let mut all = match (table.is_some_and(|table| table.has(DIRECTION)), &turned) {
        (true, None) => signs(POSITIONS, table, &columns[1..]),
        (true, Some(_)) => signs(POSITIONS, table, &columns[..1]),
        (false, _) => columns.iter().flat_map(|one| signs(POSITIONS, table, &[*one])).collect(),
    };
    // Targets of the other sign contradict every direction.
    all.extend(turned.filter(|_| !table.is_some_and(|table| are_mirrored(table, columns))));
    all.extend(table.and_then(|table| filled_directions((POSITIONS, table), columns)));
    all.extend(table.and_then(|table| from_the_other_end(table, columns[0])));
    for column in &columns {
        all.extend(units(POSITIONS, table, &[*column], dimension));
    }
    for of in [DIRECTION, "cycle"] {
        all.extend(readings_of_one(POSITIONS, table, (of, &columns[1..]), dimension));
    }
    all.extend(table.into_iter().flat_map(|table| of_one_way(table, columns, dimension)));
    if dimension == Dimension::Length {
        all.extend(all_in_metres(&[(POSITIONS, table, &columns)]));
    }
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(POSITIONS, rows)];
    all.extend(exchanged_targets(POSITIONS, table, columns));
    all.extend(table.and_then(|table| clipped(table, columns)));
    all.extend(points_lost(POSITIONS, table, &columns));
    all.extend(zeros(POSITIONS, table, &columns[1..], without));
    all.extend(standing_still(POSITIONS, table, &columns[1..], without));
    all.extend(held(POSITIONS, table, &columns[1..], without));
    all.extend(doubled(POSITIONS, table, &columns[1..], Twice::Gain));
    if let Some(fitted) = fitted {
        let far = farthest(fitted, FARTHEST);
        all.extend(exchanged_rows(POSITIONS, table, &columns[..1], &far));
    }
    all.extend(table.and_then(|table| signs_lost((POSITIONS, table), columns)));
    all.extend(table.and_then(|table| thousands((POSITIONS, table), columns)));
    let sigma = noise_of(&files.document, columns[1]).map(|(_, sigma)| sigma);
    all.extend(table.and_then(|table| coarser_than_noise((POSITIONS, table), columns, sigma)));
    all.extend(columns.iter().flat_map(|column| increments(POSITIONS, table, &[*column], &[])));
    all.extend(table.and_then(|table| at_other_targets((POSITIONS, table), columns)));
    all
}

/// Whether what was read falls where the targets rise.
fn are_mirrored(table: &Table, columns: [&str; 2]) -> bool {
    let [targets, actual] = columns.map(|column| table.numbers(column).unwrap_or_default());
    let middle = |of: &[f64]| of.iter().sum::<f64>() / count(of.len().max(1));
    let (a, b) = (middle(&targets), middle(&actual));
    targets.iter().zip(&actual).map(|(t, r)| (t - a) * (r - b)).sum::<f64>() < 0.0
}

/// Key of `[noise]` that declares that of a reading in this column, and what it says in the column's unit.
fn noise_of(document: &Document, column: &str) -> Option<(&'static str, f64)> {
    let (key, per) = match column {
        "deviation_arcsec" => ("deviation_arcsec", 1.0),
        "deviation_deg" | "actual_deg" => ("deviation_arcsec", ARCSEC_PER_DEG),
        _ => ("deviation_mm", 1.0),
    };
    Some((key, number(document, &["noise", key])? / per))
}

/// Readings of one way in another unit, where no column says which way the axis came.
fn of_one_way(
    table: &Table,
    [target, reached]: [&'static str; 2],
    dimension: Dimension,
) -> Vec<Hypothesis> {
    let Some(targets) = table.numbers(target).filter(|_| !table.has(DIRECTION)) else {
        return Vec::new();
    };
    let ways = derived(&targets);
    let of = |(name, way): (&'static str, Approach)| Part {
        name,
        said: format!("the axis was {name}"),
        rows: (0..ways.len()).filter(|row| ways[*row] == Some(way)).collect(),
    };
    let parts = [("rising", Approach::Rising), ("falling", Approach::Falling)].map(of);
    if parts.iter().any(|part| part.rows.is_empty()) {
        return Vec::new();
    }
    readings_of_each(POSITIONS, Some(table), &[reached], &parts, dimension)
}

/// What is wrong with deviations that somebody, or an instrument, took from the targets.
fn of_deviations(files: &Files, table: &Table) -> Vec<Hypothesis> {
    const READ: [[&str; 2]; 3] = [
        ["target_mm", "deviation_mm"],
        ["target_deg", "deviation_arcsec"],
        ["target_deg", "deviation_deg"],
    ];
    let there = READ.into_iter().filter(|columns| columns.iter().all(|name| table.has(name)));
    let of = |columns: [&'static str; 2]| {
        let without = |_: &Table, rows: &[bool]| vec![rows_left_out(POSITIONS, rows)];
        // They are small beside the travel, however wrong they are: the data alone show it.
        let cut = channels(POSITIONS, Some(table), &columns[1..], without).into_iter();
        let cut = cut.filter(Hypothesis::is_shown_by_data).map(Hypothesis::certain);
        let turned = turned_directions((POSITIONS, table), columns[0]).into_iter();
        let turned = turned.chain(exchanged_deviations(POSITIONS, table, columns));
        let ways = [
            filled_directions((POSITIONS, table), columns),
            turned_sign(table, columns),
            targets_as_deviations((POSITIONS, table), columns),
        ];
        let repeats = Repeats::of(table, columns);
        let noise = noise_of(&files.document, columns[1]);
        let by_repeats = repeats.iter().flat_map(|repeats| {
            let finer = FINER.iter().filter(|finer| finer.column == columns[1]);
            let finer = finer.map(|finer| repeats.in_a_finer_unit(finer, noise?));
            let sigma = noise.map(|(_, sigma)| sigma);
            [
                repeats.standing_still(table),
                repeats.turned_cycles(table),
                repeats.rows(table, sigma).in_another_order(),
            ]
            .into_iter()
            .chain(finer)
        });
        let ways = ways.into_iter().chain(by_repeats).flatten();
        turned.chain(ways).chain(cut).collect::<Vec<_>>()
    };
    there.flat_map(of).collect()
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

/// Positions that are all the same to the last digit at one end of what was reached, where the axis was sent
/// beyond it by more than any axis misses.
fn clipped(table: &Table, [target, reached]: [&str; 2]) -> Option<Hypothesis> {
    let (targets, values) = (table.numbers(target)?, table.numbers(reached)?);
    let span = |values: &[f64]| {
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let beyond = CLIPPED_BY * span(&targets);
    let of_end = |sign: f64| {
        let (end, marked) = at_end(&values, sign);
        let rows: Vec<usize> = (0..values.len()).filter(|row| marked[*row]).collect();
        let is_beyond = rows.iter().all(|&row| sign * (targets[row] - end) > beyond);
        (rows.len() >= FEWEST_CLIPPED && is_beyond).then_some((end, rows, marked))
    };
    let (limit, rows, marked) = of_end(1.0).or_else(|| of_end(-1.0))?;
    let description = format!(
        "`{reached}` of {POSITIONS} saturates: it clips at {limit} in {} rows, from line {}, whose targets lie \
         beyond; repeat the measurement with a wider range, or leave these rows out",
        rows.len(),
        table.line(rows[0])
    );
    let edits = vec![rows_left_out(POSITIONS, &marked)];
    Some(Hypothesis::of("input:saturation", (POSITIONS, &[reached]), description, edits).shown())
}

/// Targets that are counted from the other end of the travel.
fn from_the_other_end(table: &Table, target: &'static str) -> Option<Hypothesis> {
    let targets = table.numbers(target)?;
    let low = targets.iter().copied().fold(f64::INFINITY, f64::min);
    let high = targets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let values: Vec<f64> = targets.iter().map(|t| low + high - t).collect();
    let change = Change::Replace { column: target.to_owned(), values };
    let mut edits = vec![Edit { file: POSITIONS, change }];
    if table.has(DIRECTION) {
        edits.push(said_otherwise(POSITIONS, &said_ways(table)?, |_| true));
    }
    let description = format!(
        "`{target}` of {POSITIONS} is counted from the other end of the travel (reversed): take {} less each \
         target, and with it the other sign of every direction",
        low + high
    );
    Some(Hypothesis::of("input:direction", (POSITIONS, &[target]), description, edits))
}
