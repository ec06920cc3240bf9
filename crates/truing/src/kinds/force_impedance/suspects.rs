//! What may be wrong with a log, or with runs along a path.

use force_impedance::{LogSample, PathSample};

use super::session;
use super::settings::{CELLS, KNOWN, LEG_ANGLES_DEG, LENGTH_TOL, LENGTHS, LOG, PATH};
use crate::case::Table;
use crate::count::{count, rms};
use crate::kind::Files;
use crate::measured::Fitted;
use crate::suspect::{
    Dimension, Hypothesis, Proof, Record, Twice, Yardstick, channels, clocks, component_shifted,
    copies, cycles, doubled, exchanged_blocks, exchanges, held, increments, lengths, numbers,
    other_setting, points_lost, rows_left_out, rows_shifted, rows_shifted_by, scaled_setting,
    signs, spikes, spread_of, standing_still, stretches, units, units_from_a_row, zeros,
};

pub(super) const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
pub(super) const REFERENCE: &str = "reference_n";
/// Error of the force over the force itself that no physics of a sound head makes.
const GROSS: f64 = 0.4;
/// The same beyond which legs and reference have nothing to do with each other.
const UNMATCHED: f64 = 0.6;
/// Variation of a reference over its size from which on legs that miss it by all of it tell nothing of
/// it, and are of another session: physics that goes so far is a fifth of the force.
const MISSED_WHOLE: f64 = 0.2;
/// Disagreement of the four lengths over their mean that no zero error makes.
const GROSS_LENGTH: f64 = 0.01;
/// Longest time by which a reference instrument with its filter reads late.
const LATENCY_S: f64 = 0.1;
/// Segments whose references may be exchanged, at most: each pair is a fit.
const MOST_SEGMENTS: usize = 16;
/// Segments in each of which the reference stands still, from which on it may be its mean; the share of the misfit that
/// the means of segments then have at most, and that steps from row to row have: white noise has √2 of it.
const FEWEST_MEANS: usize = 3;
const MEAN_LEAVES: f64 = 0.1;
const SMOOTH: f64 = 1.0;
/// One kilogram weighs that much.
const N_PER_KG: f64 = 9.806_65;
/// The international pound of 1959 weighs that much.
const N_PER_LBF: f64 = 4.448_221_615_260_5;

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    if files.folder.has(PATH) { path(files) } else { log(files, fitted) }
}

fn log(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let Ok(table) = files.folder.table(LOG, KNOWN) else { return Vec::new() };
    let table = Some(&table);
    let mut all = Vec::new();
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(LOG, rows)];
    for (family, dimension) in [
        (&CELLS[..], Dimension::Force),
        (&[REFERENCE], Dimension::Force),
        (&LENGTHS, Dimension::Length),
    ] {
        all.extend(points_lost(LOG, table, family));
        all.extend(units_from_a_row(LOG, table, family, dimension));
    }
    all.extend(channels(LOG, table, &[&CELLS[..], &[REFERENCE]].concat(), without));
    for family in [&[&CELLS[..], &[REFERENCE]].concat()[..], &LENGTHS] {
        all.extend(copies(LOG, table, family, Proof::Data));
    }
    // A slide may stand still: there the fit decides.
    all.extend(standing_still(LOG, table, &LENGTHS, without));
    all.extend(held(LOG, table, &[&CELLS[..], &[REFERENCE]].concat(), without));
    all.extend(zeros(LOG, table, &CELLS, without));
    all.extend(units(LOG, table, &CELLS, Dimension::Force));
    all.extend(units(LOG, table, &[REFERENCE], Dimension::Force));
    all.extend(units(LOG, table, &LENGTHS, Dimension::Length));
    all.extend(doubled(LOG, table, &[&CELLS[..], &[REFERENCE]].concat(), Twice::Gain));
    for family in [&CELLS[..], &LENGTHS, &NORMAL] {
        all.extend(exchanges(LOG, table, family));
    }
    for family in [[CELLS[0], CELLS[1], CELLS[2]], [LENGTHS[0], LENGTHS[1], LENGTHS[2]], NORMAL] {
        all.extend(cycles(LOG, table, family));
    }
    all.extend(component_shifted(LOG, table, &NORMAL, LENGTH_TOL));
    all.extend(signs(LOG, table, &NORMAL));
    all.extend(signs(LOG, table, &CELLS));
    all.extend(signs(LOG, table, &[REFERENCE]));
    if let Some(fitted) = fitted {
        all.extend(reference_clock(table, fitted));
        all.extend(table.and_then(|table| means_of_segments(table, fitted)));
    }
    for column in [REFERENCE].iter().chain(&CELLS).chain(&LENGTHS) {
        all.extend(rows_shifted(LOG, table, &[*column], Some("segment")));
    }
    all.extend(increments(LOG, table, &[REFERENCE], &[]));
    all.extend(exchanged_blocks(LOG, table, &[REFERENCE], "segment", MOST_SEGMENTS));
    let of_spikes = [&CELLS[3..], &CELLS[..3], &[REFERENCE], &LENGTHS].concat();
    all.extend(fitted.and_then(|fitted| spikes(LOG, table, &of_spikes, fitted)));
    all.extend(of_head(files));
    all
}

fn of_head(files: &Files) -> Vec<Hypothesis> {
    let document = &files.document;
    let keys = ["tip_to_plane_mm", "plane_to_joint_mm", "head_radius_mm", "bracket_radius_mm"];
    let mut all: Vec<Hypothesis> =
        keys.iter().flat_map(|key| lengths(document, &["head", key])).collect();
    let weight = [
        ("in another unit, kg instead of N", N_PER_KG),
        ("in another unit, lbf instead of N", N_PER_LBF),
        ("of the opposite sign", -1.0),
    ];
    all.extend(weight.iter().filter_map(|(what, factor)| {
        scaled_setting(document, &["head", "weight_n"], "input:unit", what, *factor)
    }));
    all.extend(legs_numbered_otherwise(files));
    all
}

/// The angles of the legs by another numbering than lengths and cells have, which their table may have instead.
fn legs_numbered_otherwise(files: &Files) -> Vec<Hypothesis> {
    const ORDERS: [([usize; 3], &str); 5] = [
        ([1, 2, 0], "numbered one further"),
        ([2, 0, 1], "numbered one back"),
        ([0, 2, 1], "numbered the other way round, 2 and 3 exchanged"),
        ([2, 1, 0], "numbered the other way round, 1 and 3 exchanged"),
        ([1, 0, 2], "numbered the other way round, 1 and 2 exchanged"),
    ];
    let path = ["head", "leg_angles_deg"];
    let given = numbers(&files.document, &path).unwrap_or_else(|| LEG_ANGLES_DEG.to_vec());
    let Ok(angles_deg) = <[f64; 3]>::try_from(given) else { return Vec::new() };
    let of = |(order, said): ([usize; 3], &str)| {
        let other = order.map(|leg| angles_deg[leg]);
        let what = format!(
            "in another numbering than the cells and lengths of {LOG} (exchanged): the legs are {said}, at {other:?}"
        );
        let value = toml::Value::Array(other.map(toml::Value::Float).to_vec());
        other_setting(&path, "input:exchanged", &what, value)
    };
    ORDERS.into_iter().map(of).collect()
}

/// The reference on another clock or in other rows, where its residual is known.
fn reference_clock(table: Option<&Table>, fitted: &Fitted) -> Vec<Hypothesis> {
    let Some((table, (time_s, read))) =
        table.and_then(|t| Some((t, t.numbers("time_s").zip(t.numbers(REFERENCE))?)))
    else {
        return Vec::new();
    };
    let residuals = fitted.observations.iter().map(|o| o.residual[0]);
    let expected: Vec<f64> = residuals.zip(&read).map(|(r, read)| r + read).collect();
    let stretch = stretches(table, "segment");
    let record = Record {
        file: LOG,
        column: REFERENCE,
        time_s: &time_s,
        read: &read,
        expected: &expected,
        stretch: &stretch,
        latency_s: LATENCY_S,
    };
    let Some(late) = record.late() else { return Vec::new() };
    let mut found = clocks(&record, &late);
    // Where the log pauses, a column further down takes its first readings from before the pause.
    for rows in record.rows_late(&late) {
        let mut shifted = rows_shifted_by(LOG, Some(table), &[REFERENCE], None, rows);
        shifted.extend(rows_shifted_by(LOG, Some(table), &CELLS, None, -rows));
        // Of one that comes as late as an instrument does, physics is asked, however gross that is.
        let physics = late.may_be_latency(rows, LATENCY_S).then_some("delay");
        found.extend(shifted.into_iter().map(|shifted| Hypothesis { physics, ..shifted }));
    }
    found
}

/// A reference that stands still in every segment, at what the legs have there on average, where they go through a
/// course of their own: its mean was written down.
fn means_of_segments(table: &Table, fitted: &Fitted) -> Option<Hypothesis> {
    let read = table.numbers(REFERENCE)?;
    let segments = stretches(table, "segment");
    let n_values = read.chunk_by(|a, b| a.total_cmp(b).is_eq()).count();
    let n_segments = segments.last()? + 1;
    if n_values != n_segments
        || n_segments < FEWEST_MEANS
        || fitted.observations.len() != read.len()
    {
        return None;
    }
    let off: Vec<f64> = fitted.observations.iter().map(|o| o.residual[0]).collect();
    let mut by_segment: Vec<Vec<f64>> = vec![Vec::new(); n_segments];
    for (residual, segment) in off.iter().zip(&segments) {
        by_segment[*segment].push(*residual);
    }
    let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / count(values.len());
    let means = rms(by_segment.iter().map(mean));
    let steps = rms(by_segment.iter().flat_map(|of| of.windows(2).map(|pair| pair[1] - pair[0])));
    let all = rms(off.iter().copied());
    let is_mean = means < MEAN_LEAVES * all && steps < SMOOTH * all;
    let description = format!(
        "`{REFERENCE}` of {LOG} stands still in every segment (stuck, or its mean was filled down), at what the legs \
         have there on average while they go through a course of their own: put back what was read"
    );
    is_mean.then(|| {
        Hypothesis::of("input:stuck", (LOG, &[REFERENCE]), description, Vec::new()).shown()
    })
}

fn path(files: &Files) -> Vec<Hypothesis> {
    let columns = ["run", "time_s", "path_mm", "force_n", REFERENCE];
    let Ok(table) = files.folder.table(PATH, &columns) else { return Vec::new() };
    let table = Some(&table);
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(PATH, rows)];
    let mut all = channels(PATH, table, &["force_n"], without);
    for column in ["force_n", REFERENCE] {
        all.extend(units(PATH, table, &[column], Dimension::Force));
    }
    all.extend(signs(PATH, table, &["force_n"]));
    all.extend(signs(PATH, table, &[REFERENCE]));
    all.extend(exchanges(PATH, table, &["path_mm", "force_n", REFERENCE]));
    all.extend(rows_shifted(PATH, table, &[REFERENCE], Some("run")));
    all.extend(exchanged_blocks(PATH, table, &[REFERENCE], "run", MOST_SEGMENTS));
    all
}

pub(super) fn log_yardstick(samples: &[LogSample], fitted: &Fitted) -> Yardstick {
    let reference: Option<Vec<f64>> = samples.iter().map(|s| s.reference_n).collect();
    let Some(reference) = reference else {
        let lengths = samples.iter().flat_map(|s| s.lengths_mm);
        let (spread, gross) = (rms(lengths), GROSS_LENGTH);
        return Yardstick {
            spread,
            taken_up: 0.0,
            gross,
            unmatched: f64::INFINITY,
            ..Yardstick::NONE
        };
    };
    // A reference that is too large by its unit makes the force look small beside it.
    let cells = rms(samples.iter().map(|s| s.cells_n[3]));
    let size = rms(reference.iter().copied());
    let spread = size.max(cells);
    let points: Vec<[f64; 1]> = reference.iter().map(|read| [*read]).collect();
    let variation = spread_of(points.iter().map(<[f64; 1]>::as_slice));
    let unmatched =
        if session::is_another(samples, fitted.observations.iter().map(|o| o.residual[0])) {
            0.0
        } else if variation < MISSED_WHOLE * size {
            GROSS
        } else {
            (variation / spread).min(UNMATCHED)
        };
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched, ..Yardstick::NONE }
}

pub(super) fn path_yardstick(samples: &[PathSample]) -> Yardstick {
    let reference = rms(samples.iter().map(|s| s.reference_n));
    let spread = reference.max(rms(samples.iter().map(|s| s.force_n)));
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched: UNMATCHED, ..Yardstick::NONE }
}
