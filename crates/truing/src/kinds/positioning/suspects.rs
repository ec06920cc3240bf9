//! What may be wrong with a table of targets and what was reached there.

use ft_center::Approach;

use super::ARCSEC_PER_DEG;
use super::approach::{DIRECTION, derived};
use super::at_targets::{
    at_other_targets, coarser_than_noise, signs_lost, targets_as_deviations, thousands,
};
use super::directions::{
    filled_directions, said_otherwise, said_ways, turned_directions, turned_sign,
};
use super::repeats::{FINER, Repeats};
use crate::case::{Change, Document, Edit, Table};
use crate::count::count;
use crate::kind::Files;
use crate::measured::Fitted;
use crate::suspect::{
    Dimension, Hypothesis, Part, Twice, all_in_metres, at_end, channels, doubled,
    exchanged_deviations, exchanged_rows, exchanged_targets, farthest, held, increments, number,
    points_lost, readings_of_each, readings_of_one, rows_left_out, signs, standing_still, units,
    zeros,
};

/// Columns of targets and of the positions reached, as tables name them.
const PAIRS: [[&str; 2]; 3] =
    [["target_mm", "actual_mm"], ["target_deg", "actual_deg"], ["commanded_mm", "solved_mm"]];
/// Columns of targets and deviations.
const DEVIATIONS: [[&str; 2]; 3] = [
    ["target_mm", "deviation_mm"],
    ["target_deg", "deviation_arcsec"],
    ["target_deg", "deviation_deg"],
];
/// Rows looked at for exchanged labels.
const FARTHEST: usize = 6;
/// Fewest equal positions at one end that are no accident, where their targets lie beyond.
const FEWEST_CLIPPED: usize = 3;
/// By how much of the travel these lie beyond it: no axis misses by that.
const CLIPPED_BY: f64 = 0.005;

/// A table of an axis, and the name of its file.
type OfAxis<'t> = (&'static str, &'t Table);

/// What may be wrong with this table of the case, the likeliest first.
pub(crate) fn mistakes_of_axis(
    file: &'static str,
    files: &Files,
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let Ok(table) = files.folder.table(file, &[]) else { return Vec::new() };
    let axis = (file, &table);
    let there = |columns: &[&'static str; 2]| columns.iter().all(|column| table.has(column));
    if let Some(columns) = PAIRS.into_iter().find(there) {
        return of_positions(axis, columns, files, fitted);
    }
    DEVIATIONS
        .into_iter()
        .filter(there)
        .flat_map(|columns| of_deviations(axis, columns, files))
        .collect()
}

fn of_positions(
    axis: OfAxis<'_>,
    columns: [&'static str; 2],
    files: &Files,
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let (file, table) = axis;
    let [target, reached] = columns;
    let dimension = if target == "target_deg" { Dimension::Angle } else { Dimension::Length };
    let turned = turned_directions(axis, target);
    let there = Some(table);
    // Which of the two is mirrored the directions tell, where there are any.
    let mut all = match (table.has(DIRECTION), &turned) {
        (true, None) => signs(file, there, &[reached]),
        (true, Some(_)) => signs(file, there, &[target]),
        (false, _) => columns.iter().flat_map(|one| signs(file, there, &[*one])).collect(),
    };
    // Targets of the other sign contradict every direction.
    all.extend(turned.filter(|_| !are_mirrored(table, columns)));
    all.extend(filled_directions(axis, columns));
    all.extend(from_the_other_end(axis, target));
    for column in &columns {
        all.extend(units(file, there, &[*column], dimension));
    }
    for of in [DIRECTION, "cycle"] {
        all.extend(readings_of_one(file, there, (of, &[reached]), dimension));
    }
    all.extend(of_one_way(axis, columns, dimension));
    if dimension == Dimension::Length {
        all.extend(all_in_metres(&[(file, there, &columns)]));
    }
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(file, rows)];
    all.extend(exchanged_targets(file, there, columns));
    all.extend(clipped(axis, columns));
    all.extend(points_lost(file, there, &columns));
    all.extend(zeros(file, there, &[reached], without));
    all.extend(standing_still(file, there, &[reached], without));
    all.extend(held(file, there, &[reached], without));
    // Of what a machine was moved by and a sensor saw, either may be counted across.
    all.extend(match target {
        "commanded_mm" => doubled(file, there, &[reached, target], Twice::Diameter),
        _ => doubled(file, there, &[reached], Twice::Gain),
    });
    if let Some(fitted) = fitted {
        let far = farthest(fitted, FARTHEST);
        all.extend(exchanged_rows(file, there, &[target], &far));
    }
    all.extend(signs_lost(axis, columns));
    all.extend(thousands(axis, columns));
    let sigma = noise_of(&files.document, reached).map(|(_, sigma)| sigma);
    all.extend(coarser_than_noise(axis, columns, sigma));
    all.extend(columns.iter().flat_map(|column| increments(file, there, &[*column], &[])));
    all.extend(at_other_targets(axis, columns));
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
    let (keys, per): (&[&'static str], f64) = match column {
        "deviation_arcsec" => (&["deviation_arcsec"], 1.0),
        "deviation_deg" | "actual_deg" => (&["deviation_arcsec"], ARCSEC_PER_DEG),
        _ => (&["deviation_mm", "displacement_mm"], 1.0),
    };
    keys.iter().find_map(|key| Some((*key, number(document, &["noise", key])? / per)))
}

/// Readings of one way in another unit, where no column says which way the axis came.
fn of_one_way(
    (file, table): OfAxis<'_>,
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
    readings_of_each(file, Some(table), &[reached], &parts, dimension)
}

/// What is wrong with deviations that somebody, or an instrument, took from the targets.
fn of_deviations(axis: OfAxis<'_>, columns: [&'static str; 2], files: &Files) -> Vec<Hypothesis> {
    let (file, table) = axis;
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(file, rows)];
    // They are small beside the travel, however wrong they are: the data alone show it.
    let cut = channels(file, Some(table), &columns[1..], without).into_iter();
    let cut = cut.filter(Hypothesis::is_shown_by_data).map(Hypothesis::certain);
    let turned = turned_directions(axis, columns[0]).into_iter();
    let turned = turned.chain(exchanged_deviations(file, table, columns));
    let ways = [
        filled_directions(axis, columns),
        turned_sign(axis, columns),
        targets_as_deviations(axis, columns),
    ];
    let repeats = Repeats::of(axis, columns);
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
    turned.chain(ways).chain(cut).collect()
}

/// Positions that are all the same to the last digit at one end of what was reached, where the axis was sent
/// beyond it by more than any axis misses.
fn clipped((file, table): OfAxis<'_>, [target, reached]: [&'static str; 2]) -> Option<Hypothesis> {
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
        "`{reached}` of {file} saturates: it clips at {limit} in {} rows, from line {}, whose targets lie \
         beyond; repeat the measurement with a wider range, or leave these rows out",
        rows.len(),
        table.line(rows[0])
    );
    let edits = vec![rows_left_out(file, &marked)];
    Some(Hypothesis::of("input:saturation", (file, &[reached]), description, edits).shown())
}

/// Targets that are counted from the other end of the travel.
fn from_the_other_end((file, table): OfAxis<'_>, target: &'static str) -> Option<Hypothesis> {
    let targets = table.numbers(target)?;
    let low = targets.iter().copied().fold(f64::INFINITY, f64::min);
    let high = targets.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let values: Vec<f64> = targets.iter().map(|t| low + high - t).collect();
    let change = Change::Replace { column: target.to_owned(), values };
    let mut edits = vec![Edit { file, change }];
    if table.has(DIRECTION) {
        edits.push(said_otherwise(file, &said_ways(table)?, |_| true));
    }
    let description = format!(
        "`{target}` of {file} is counted from the other end of the travel (reversed): take {} less each \
         target, and with it the other sign of every direction",
        low + high
    );
    Some(Hypothesis::of("input:direction", (file, &[target]), description, edits))
}
