//! What may be wrong with the two tables of points.

use frame_fit::{TipPose, Transform};

use super::estimates::FrameFitEstimates;
use super::rematched::rematched;
use super::set_ups::{misplaced, relabelled};
use super::settings::{COORDINATES, DISTANCES, FROM, PAIRS, POSES, TO};
use crate::case::{Change, Edit, Table};
use crate::kind::Files;
use crate::kinds::orientation::{QUATERNION, mistakes_of_quaternion};
use crate::measured::Fitted;
use crate::residual::Residual;
use crate::suspect::{
    Dimension, Hypothesis, Proof, Twice, Yardstick, all_in_metres, clipped_of_few, copies, cycles,
    doubled, exchanged_rows, exchanges, farthest, held, increments, other_setting, points_lost,
    polar, rows_left_out, rows_shifted, signs, silent, sorted_as_text, spread_of, standing_still,
    swapped_names, units, zeros,
};

/// The two sides of the table.
const TO_AND_FROM: [[&str; 3]; 2] = [TO, FROM];
/// Misfit over the spread of the points that no machine has: 20 mm in a metre.
const GROSS: f64 = 0.02;
/// Misfit over spread of tables that have nothing to do with each other.
const UNMATCHED: f64 = 0.1;
/// Spread of the difference of two columns over their own below which they differ by a constant.
const PARALLEL: f64 = 1e-3;
/// A scale farther from 1 than this is no thermal or metrological one, which are below 1e-3.
const USUAL_SCALE: f64 = 3e-3;
/// Rows looked at for exchanged labels: the two with the largest residuals, and as many more as
/// the fit may have put before them.
const FARTHEST: usize = 6;
/// Places of which every pair of names is tried.
const MOST_PLACES: usize = 12;
/// Spread of one side over that of the other below which its points are all one.
const COINCIDENT: f64 = 0.2;
/// Correlation of the distances between points of the two sides, below which they are unrelated.
const UNRELATED: f64 = 0.7;

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    if files.folder.has(POSES) { poses(files, fitted) } else { pairs(files, fitted) }
}

fn pairs(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let table = files.folder.table(PAIRS, &["point", FROM[0], FROM[1], TO[0], TO[1]]).ok();
    let Some(table) = table.as_ref() else { return Vec::new() };
    let mut all: Vec<Hypothesis> = coincident(table).into_iter().collect();
    if let Some(fitted) = fitted {
        all.extend(misplaced(files, table, fitted));
    }
    for side in TO_AND_FROM {
        all.extend(units(PAIRS, Some(table), &side, Dimension::Length));
        all.extend(doubled(PAIRS, Some(table), &side, Twice::Diameter));
        all.extend(polar(PAIRS, Some(table), &side));
    }
    all.extend(all_in_metres(&[(PAIRS, Some(table), &[FROM, TO].concat())]));
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(PAIRS, rows)];
    for side in TO_AND_FROM {
        all.extend(silent(PAIRS, Some(table), &side));
        all.extend(standing_still(PAIRS, Some(table), &side, without));
        all.extend(held(PAIRS, Some(table), &side, without));
        all.extend(clipped_of_few(PAIRS, Some(table), &side, without));
        all.extend(zeros(PAIRS, Some(table), &side, without));
    }
    all.extend(TO_AND_FROM.iter().flat_map(|side| signs(PAIRS, Some(table), side)));
    for side in TO_AND_FROM {
        all.extend(copies(PAIRS, Some(table), &side, Proof::Gross));
        all.extend(exchanges(PAIRS, Some(table), &side));
        all.extend(cycles(PAIRS, Some(table), side));
    }
    all.extend(
        (FROM.iter().zip(TO).map(|(from, to)| [*from, to]))
            .filter(|pair| !are_parallel(table, *pair))
            .flat_map(|pair| exchanges(PAIRS, Some(table), &pair)),
    );
    all.push(handedness(files));
    all.extend(sorted_as_text(PAIRS, Some(table), "point", &TO));
    all.extend(fitted.and_then(|fitted| rematched(table, fitted)));
    all.extend(TO_AND_FROM.iter().flat_map(|side| increments(PAIRS, Some(table), side, &[])));
    if let Some(fitted) = fitted {
        let far = farthest(fitted, FARTHEST);
        all.extend(exchanged_rows(PAIRS, Some(table), &TO, &far));
        all.extend(far.iter().filter_map(|row| read_elsewhere(table, *row)));
    }
    all
}

/// A reading that was taken at the place of another row, the one that reads most like it.
fn read_elsewhere(table: &Table, row: usize) -> Option<Hypothesis> {
    let columns = |names: &[&str]| -> Vec<Vec<f64>> {
        names.iter().filter_map(|name| table.numbers(name)).collect()
    };
    let (places, readings) = (columns(&FROM), columns(&TO));
    let apart = |of: &[Vec<f64>], other: usize| -> f64 {
        of.iter().map(|values| (values[row] - values[other]).powi(2)).sum()
    };
    let others = (0..table.n_rows()).filter(|other| apart(&places, *other) > 0.0);
    let like = |a: &usize, b: &usize| apart(&readings, *a).total_cmp(&apart(&readings, *b));
    let other = others.min_by(like)?;
    let description = format!(
        "line {} of {PAIRS} was read at the place of line {} and stands under another label (a label typed wrongly): \
         give it the name and the coordinates of the place that it was read at",
        table.line(row),
        table.line(other)
    );
    let there = FROM.into_iter().filter(|name| table.has(name));
    let edits = there.zip(places).map(|(name, mut values)| {
        values[row] = values[other];
        Edit { file: PAIRS, change: Change::Replace { column: name.to_owned(), values } }
    });
    Some(Hypothesis::of("input:labels", (PAIRS, &["point"]), description, edits.collect()))
}

/// Poses of a flange, and the distances known between the places.
fn poses(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let Ok(table) = files.folder.table(POSES, &["place", COORDINATES[0], QUATERNION[0]]) else {
        return Vec::new();
    };
    let relabelled = relabelled(&table);
    let table = Some(&table);
    let mut all: Vec<Hypothesis> = relabelled.into_iter().collect();
    all.extend(units(POSES, table, &COORDINATES, Dimension::Length));
    let known = (files.folder.has(DISTANCES))
        .then(|| files.folder.table(DISTANCES, &["from", "to", "distance_mm"]).ok());
    let known = known.flatten();
    all.extend(points_lost(POSES, table, &COORDINATES));
    all.extend(units(DISTANCES, known.as_ref(), &["distance_mm"], Dimension::Length));
    let lengths: [(_, _, &[&str]); 2] =
        [(POSES, table, &COORDINATES), (DISTANCES, known.as_ref(), &["distance_mm"])];
    all.extend(all_in_metres(&lengths));
    all.extend(signs(POSES, table, &COORDINATES));
    all.extend(copies(POSES, table, &COORDINATES, Proof::Gross));
    all.extend(exchanges(POSES, table, &COORDINATES));
    all.extend(cycles(POSES, table, COORDINATES));
    all.extend(mistakes_of_quaternion(POSES, table));
    all.extend(exchanges(POSES, table, &QUATERNION));
    all.extend(rows_shifted(POSES, table, &["place"], None));
    all.extend(swapped_names(POSES, table, "place", MOST_PLACES));
    if let Some(fitted) = fitted {
        let n_rows = table.map_or(0, Table::n_rows);
        let far: Vec<usize> =
            farthest(fitted, FARTHEST).into_iter().filter(|row| *row < n_rows).collect();
        all.extend(exchanged_rows(POSES, table, &COORDINATES, &far));
        all.extend(exchanged_rows(POSES, table, &["place"], &far));
    }
    all
}

pub(super) fn pose_yardstick(poses: &[TipPose]) -> Yardstick {
    let spread = spread_of(poses.iter().map(|p| p.position_mm.as_slice()));
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched: UNMATCHED, ..Yardstick::NONE }
}

/// The frames mirrored against what is declared.
fn handedness(files: &Files) -> Hypothesis {
    let path = ["model", "handedness"];
    let declared = files.document.value(&path);
    let is_improper = declared.is_some_and(|value| value.as_str() == Some("improper"));
    let other = if is_improper { "proper" } else { "improper" };
    let what = format!("wrong, the frames are mirrored otherwise: \"{other}\"");
    other_setting(&path, "input:handedness", &what, toml::Value::String(other.to_owned()))
}

/// One side of the table is one and the same point over and over.
fn coincident(table: &Table) -> Option<Hypothesis> {
    let side = |names: [&str; 3]| -> Option<Vec<Vec<f64>>> {
        let axes: Vec<Vec<f64>> = names.iter().filter_map(|name| table.numbers(name)).collect();
        let point = |row| axes.iter().map(|axis| axis[row]).collect();
        (axes.len() > 1).then(|| (0..table.n_rows()).map(point).collect())
    };
    let (from, to) = (side(FROM)?, side(TO)?);
    let spread = |points: &[Vec<f64>]| spread_of(points.iter().map(Vec::as_slice));
    let (columns, ratio) = if spread(&to) < spread(&from) {
        (TO, spread(&to) / spread(&from))
    } else {
        (FROM, spread(&from) / spread(&to))
    };
    if ratio > COINCIDENT || correlation(&distances(&from), &distances(&to)) > UNRELATED {
        return None;
    }
    let columns = &columns[..from[0].len().min(3)];
    let description = format!(
        "the points of {PAIRS} in {} are all the same point (coincident): their spread is {ratio:.1e} \
         of that of the others, and unrelated to it; give the places that belong to the points",
        columns.join(", ")
    );
    let found =
        Hypothesis::of("input:coincident-points", (PAIRS, columns), description, Vec::new());
    Some(found.shown())
}

/// Between every point and the next four.
fn distances(points: &[Vec<f64>]) -> Vec<f64> {
    let n = points.len();
    let pairs = (0..n).flat_map(|i| (1..=4).map(move |k| (i, (i + k) % n)));
    let square = |(i, j): (usize, usize)| {
        points[i].iter().zip(&points[j]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    pairs.map(square).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let product: f64 = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum();
    let square = |v: &[f64], m: f64| v.iter().map(|x| (x - m).powi(2)).sum::<f64>();
    product / (square(a, ma) * square(b, mb)).sqrt().max(f64::MIN_POSITIVE)
}

pub(super) fn yardstick(
    sides_mm: [&[Vec<f64>]; 2],
    transform: Transform,
    fitted: &Fitted,
) -> Yardstick {
    let spread = |points: &[Vec<f64>]| spread_of(points.iter().map(Vec::as_slice));
    let spread = spread(sides_mm[0]).max(spread(sides_mm[1]));
    // Frames that are claimed to be one may be shifted and turned against each other.
    let is_claimed = matches!(transform, Transform::None | Transform::Translation);
    // Points that a map of another scale takes onto each other belong together.
    let stretched = stretched(fitted);
    let left = || Residual::of(fitted.observations.iter(), COORDINATES.len(), fitted.unit).rms;
    let is_mapped = stretched > USUAL_SCALE && left().is_some_and(|rms| rms < UNMATCHED * spread);
    Yardstick {
        spread,
        taken_up: match stretched {
            // Another unit leaves no stretch that is gross still: the image of a camera is no table in cm.
            s if s > GROSS => spread,
            s if s > USUAL_SCALE => spread * s,
            _ => 0.0,
        },
        gross: GROSS,
        unmatched: if is_claimed || is_mapped { f64::INFINITY } else { UNMATCHED },
        ..Yardstick::NONE
    }
}

/// By how much a fitted map stretches the most, as a share.
fn stretched(fitted: &Fitted) -> f64 {
    let Some(found) = fitted.estimates.downcast_ref::<FrameFitEstimates>() else { return 0.0 };
    let d = found.matrix.len() - 1;
    let linear = nalgebra::DMatrix::from_fn(d, d, |i, j| found.matrix[i][j]);
    linear.singular_values().iter().map(|s| (s - 1.0).abs()).fold(0.0, f64::max)
}

/// Whether a coordinate differs between the frames by a constant, so that an exchange moves one frame, and
/// of points along a line changes what noise leaves of the turn about it.
fn are_parallel(table: &Table, [from, to]: [&str; 2]) -> bool {
    let Some((from, to)) = table.numbers(from).zip(table.numbers(to)) else { return false };
    let differences: Vec<f64> = from.iter().zip(&to).map(|(a, b)| b - a).collect();
    let spread = |values: &[f64]| spread_of(values.chunks_exact(1));
    spread(&differences) <= PARALLEL * spread(&from)
}
