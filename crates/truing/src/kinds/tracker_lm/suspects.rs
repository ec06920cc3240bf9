//! What may be wrong with a survey of a rotary axis.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use nalgebra::{Point3, Vector3};
use tracker_lm::{Survey, TargetSurvey};

use super::axis_error::AxisErrorEstimate;
use super::estimates::TrackerLmEstimates;
use super::settings::{MOUNTS, RANGES, STATIONS, TARGETS};
use super::tables::PLACE;
use crate::case::{Change, Edit, Table};
use crate::count::count;
use crate::kind::Files;
use crate::measured::Fitted;
use crate::suspect::{
    Dimension, Hypothesis, Proof, Twice, Yardstick, axes_of_row, blocks_shifted, clipped_of_few,
    clipped_of_one, copies, cycles, doubled, exchanges, farthest, held, increments,
    names_of_one_exchanged, numbers, other_setting, place_standing_still, readings_of_one,
    rows_left_out, rows_shifted, signs, slip_of_sign, spread_of, standing_still,
    standing_still_in_several, standing_still_within, swapped_names, units, zeros,
};

/// What is moved, over what there is, that no axis and no tape measure does: 6 mm in 200 mm.
const GROSS: f64 = 0.03;
/// The same beyond which the tables have nothing to do with each other.
const UNMATCHED: f64 = 0.3;
/// Errors of an axis, over the distance of its reflectors, that no survey meets: 20 mrad.
const USUAL_ERROR: f64 = 0.02;
/// Nominal places are off by this share of their distances, at most: they come from a tape.
const USUAL_PLACE: f64 = 0.05;
/// What stations may be off by, over their distances from each other, for it to be how well they are known.
const KNOWN: f64 = 0.01;
/// Names of which every pair is tried.
const MOST_NAMES: usize = 8;
/// Reflectors of one station of which every two and three are exchanged.
const MOST_NAMES_OF_ONE: usize = 5;
/// Angles looked at for exchanged ones: the two where the axis errs most, and as many more as the fit
/// may have put before them.
const FARTHEST: usize = 5;
pub(super) const DISPLACEMENT: &str = "displacement_mm";
const SIGN: &str = "input:sign";
/// Displacements with another sign than their neighbours that are looked at.
const MOST_TURNED: usize = 4;
/// Angles as close as this are one, as they are written.
const SAME_ANGLE_DEG: f64 = 1e-6;

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let folder = &files.folder;
    let file = if folder.has(TARGETS) { TARGETS } else { RANGES };
    let read = folder.table(file, &["station", "mount", "step", "angle_deg"]).ok();
    let stations = folder.table(STATIONS, &["station", PLACE[0], PLACE[1], PLACE[2]]).ok();
    let mounts = folder.table(MOUNTS, &["mount", PLACE[0], PLACE[1], PLACE[2]]).ok();
    let (read, stations, mounts) = (read.as_ref(), stations.as_ref(), mounts.as_ref());
    let mut all = directions(files);
    let locks = read.map_or_else(Vec::new, locks);
    let without = |read: &Table, rows: &[bool]| left_out((file, read), [stations, mounts], rows);
    if file == TARGETS {
        all.extend(place_standing_still(file, read, &PLACE, without));
        all.extend(standing_still(file, read, &PLACE, without));
        all.extend(zeros(file, read, &PLACE, without));
    } else {
        // What stands still at the end of a station's range clips there.
        all.extend(clipped_of_one(file, read, ["station", DISPLACEMENT], without));
        all.extend(standing_still(file, read, &[DISPLACEMENT], without));
        all.extend(held(file, read, &[DISPLACEMENT], without));
        all.extend(standing_still_within(
            file,
            read,
            DISPLACEMENT,
            (&locks, "steps of one lock"),
            without,
        ));
        all.extend(standing_still_in_several(file, read, DISPLACEMENT, (&locks, "locks"), without));
    }
    all.extend(units(file, read, &["angle_deg"], Dimension::Angle));
    all.extend(signs(file, read, &["angle_deg"]));
    if file == TARGETS {
        all.extend(of_places(TARGETS, read));
        all.extend(doubled(TARGETS, read, &PLACE, Twice::Gain));
        for columns in [&PLACE[..], &PLACE[..1], &PLACE[1..2], &PLACE[2..]] {
            all.extend(rows_shifted(file, read, columns, Some("mount")));
            let of_one = readings_of_one(file, read, ("station", columns), Dimension::Length);
            // A tracker has one unit, and each axis a sign.
            let is_usual = |h: &Hypothesis| columns.len() == PLACE.len() || h.effect == SIGN;
            all.extend(of_one.into_iter().filter(is_usual));
        }
    } else {
        let column = [DISPLACEMENT];
        all.extend(units(file, read, &column, Dimension::Length));
        all.extend(doubled(file, read, &column, Twice::Path));
        all.extend(increments(file, read, &column, &locks));
        all.extend(increments_of_one(file, read, &locks));
        all.extend(turned_signs(file, read, &locks));
        let far = fitted.map(|fitted| farthest(fitted, FARTHEST));
        all.extend(
            (read.zip(far).into_iter())
                .flat_map(|(read, far)| lock_shifted((file, read), &locks, &far)),
        );
        all.extend(read.into_iter().flat_map(|read| station_shifted(file, read, &locks)));
        all.extend(signs(file, read, &column));
        for of in ["station", "mount"] {
            all.extend(readings_of_one(file, read, (of, &column), Dimension::Length));
        }
        all.extend(clipped_of_few(file, read, &column, without));
        if file == TARGETS {
            all.extend(clipped_of_one(file, read, ["station", column[0]], without));
        }
        all.extend(rows_shifted(file, read, &column, Some("mount")));
    }
    all.extend(of_places(STATIONS, stations));
    all.extend(of_places(MOUNTS, mounts));
    for column in ["station", "mount"] {
        all.extend(swapped_names(file, read, column, MOST_NAMES));
    }
    let most = [MOST_NAMES_OF_ONE; 2];
    all.extend(names_of_one_exchanged(file, read, ["station", "mount"], most));
    all.extend(names_of_one_exchanged(file, read, ["mount", "station"], [MOST_NAMES, 0]));
    if let Some((read, fitted)) = read.zip(fitted) {
        all.extend(exchanged_angles((file, read), fitted));
    }
    all
}

/// The readings of one station alone as differences.
fn increments_of_one(
    file: &'static str,
    read: Option<&Table>,
    locks: &[Vec<usize>],
) -> Vec<Hypothesis> {
    let Some((read, station)) = read.and_then(|read| Some((read, read.column("station")?))) else {
        return Vec::new();
    };
    let of = |lock: &Vec<usize>| lock.first().map(|row| read.cell(*row, station));
    let names: BTreeSet<&str> = locks.iter().filter_map(of).collect();
    let of_station = |name: &&str| {
        let its: Vec<_> = locks.iter().filter(|lock| of(lock) == Some(name)).cloned().collect();
        let only = |all: Hypothesis| Hypothesis {
            description: format!("{} where `station` is `{name}`", all.description),
            ..all
        };
        increments(file, Some(read), &[DISPLACEMENT], &its)
            .into_iter()
            .map(only)
            .collect::<Vec<_>>()
    };
    names.iter().flat_map(of_station).collect()
}

/// The readings of one lock, a station on one reflector, in the order of the table.
fn locks(read: &Table) -> Vec<Vec<usize>> {
    let Some((station, mount)) = read.column("station").zip(read.column("mount")) else {
        return Vec::new();
    };
    let mut locks: HashMap<[&str; 2], Vec<usize>> = HashMap::new();
    for row in 0..read.n_rows() {
        locks.entry([read.cell(row, station), read.cell(row, mount)]).or_default().push(row);
    }
    let mut locks: Vec<Vec<usize>> = locks.into_values().collect();
    locks.sort();
    locks
}

/// Displacements between whose neighbours in the lock, of the opposite sign, they would lie with the other one.
fn turned_signs(file: &'static str, read: Option<&Table>, locks: &[Vec<usize>]) -> Vec<Hypothesis> {
    let Some((read, values)) = read.and_then(|read| Some((read, read.numbers(DISPLACEMENT)?)))
    else {
        return Vec::new();
    };
    let is_turned = |three: &&[usize]| {
        let [before, at, after] = [0, 1, 2].map(|i| values[three[i]]);
        let beside = (after - before).abs();
        before * after > 0.0 && at * before < 0.0 && (-at - 0.5 * (before + after)).abs() <= beside
    };
    let turned = locks.iter().flat_map(|lock| lock.windows(3)).filter(is_turned);
    let slip = |three: &[usize]| slip_of_sign(file, read, (DISPLACEMENT, &values), three[1]);
    turned.take(MOST_TURNED).map(slip).collect()
}

/// The readings of one station one row further down or up in every lock of it, the last of each first, where the rows of
/// each follow each other.
fn station_shifted(file: &'static str, read: &Table, locks: &[Vec<usize>]) -> Vec<Hypothesis> {
    let Some(station) = read.column("station") else { return Vec::new() };
    let mut of_stations: BTreeMap<&str, Vec<Range<usize>>> = BTreeMap::new();
    for lock in locks {
        let block = lock[0]..lock[0] + lock.len();
        if lock[lock.len() - 1] + 1 != block.end {
            return Vec::new();
        }
        of_stations.entry(read.cell(lock[0], station)).or_default().push(block);
    }
    let of = |(name, blocks): (&&str, &Vec<Range<usize>>)| {
        let said = format!(" in every lock of station `{name}`");
        let by = |by| blocks_shifted((file, read), &[DISPLACEMENT], (blocks, &*said), by);
        // Rows that have lost their partner are those of a station whose rows have moved on from lock to lock.
        [1, -1].into_iter().filter_map(|way| by(way).into_iter().next()).collect::<Vec<_>>()
    };
    of_stations.iter().flat_map(of).collect()
}

/// The readings of one lock one row further down or up: of the lock that lies farthest off, where its rows
/// follow each other.
fn lock_shifted(
    (file, read): (&'static str, &Table),
    locks: &[Vec<usize>],
    far: &[usize],
) -> Vec<Hypothesis> {
    let Some(lock) = far.first().and_then(|row| locks.iter().find(|lock| lock.contains(row)))
    else {
        return Vec::new();
    };
    let (first, n) = (lock[0], lock.len());
    if lock[n - 1] - first + 1 != n {
        return Vec::new();
    }
    let said = format!(" in one lock, lines {} to {},", read.line(first), read.line(first + n - 1));
    let block = first..first + n;
    let of_it = (std::slice::from_ref(&block), &*said);
    let by = |by| blocks_shifted((file, read), &[DISPLACEMENT], of_it, by);
    [1, -1].into_iter().flat_map(by).collect()
}

/// The angles of two steps exchanged, of those at which the axis errs most.
fn exchanged_angles((file, read): (&'static str, &Table), fitted: &Fitted) -> Vec<Hypothesis> {
    const ANGLE: &str = "angle_deg";
    let found = fitted.estimates.downcast_ref::<TrackerLmEstimates>();
    let Some((found, column)) = found.zip(read.column(ANGLE)) else { return Vec::new() };
    let square = |e: &AxisErrorEstimate| e.e_a_rad.powi(2) + e.e_b_rad.powi(2) + e.e_c_rad.powi(2);
    let mut errors: Vec<&AxisErrorEstimate> = found.axis_errors.iter().collect();
    errors.sort_by(|a, b| square(b).total_cmp(&square(a)));
    let written = |angle_deg: f64| {
        let is_it = |cell: &&str| {
            cell.parse::<f64>().is_ok_and(|value| (value - angle_deg).abs() < SAME_ANGLE_DEG)
        };
        (0..read.n_rows()).map(|row| read.cell(row, column)).find(is_it)
    };
    let far: Vec<&str> =
        errors.iter().take(FARTHEST).filter_map(|e| written(e.angle_deg)).collect();
    let mut all = Vec::new();
    for (i, one) in far.iter().enumerate() {
        for other in &far[i + 1..] {
            let description = format!(
                "the labels `{one}` and `{other}` in `{ANGLE}` of {file} are exchanged (swapped): \
                 exchange them"
            );
            let edits = vec![Edit { file, change: Change::swap(ANGLE, [*one, *other]) }];
            all.push(Hypothesis::of("input:labels", (file, &[ANGLE]), description, edits));
        }
    }
    all
}

/// Some readings go, and with them stations and reflectors of which none is left.
fn left_out(
    (file, read): (&'static str, &Table),
    [stations, mounts]: [Option<&Table>; 2],
    rows: &[bool],
) -> Vec<Edit> {
    let mut edits = vec![rows_left_out(file, rows)];
    for (of, places, name) in [(STATIONS, stations, "station"), (MOUNTS, mounts, "mount")] {
        let columns = places.and_then(|table| Some((table, table.column(name)?)));
        let Some(((table, named), column)) = columns.zip(read.column(name)) else { continue };
        let is_read = |row: usize| {
            let is_named = |at: usize| read.cell(at, column) == table.cell(row, named);
            (0..read.n_rows()).any(|at| !rows[at] && is_named(at))
        };
        let marked: Vec<bool> = (0..table.n_rows()).map(|row| !is_read(row)).collect();
        if marked.contains(&true) {
            edits.push(rows_left_out(of, &marked));
        }
    }
    edits
}

fn of_places(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = units(file, table, &PLACE, Dimension::Length);
    all.extend(copies(file, table, &PLACE, Proof::Gross));
    all.extend(exchanges(file, table, &PLACE));
    all.extend(cycles(file, table, PLACE));
    all.extend(signs(file, table, &PLACE));
    // Without one of them the others may not do to see what is wrong with it.
    if let Some(table) = table.filter(|table| table.n_rows() <= MOST_NAMES) {
        let of_row = |row| axes_of_row((file, table), row, &PLACE);
        let last = |change| Hypothesis { proof: Proof::FitIfNoOther, ..change };
        all.extend((0..table.n_rows()).flat_map(of_row).map(last));
    }
    all
}

/// The axis the other way round, or along another axis of the machine.
fn directions(files: &Files) -> Vec<Hypothesis> {
    let path = ["axis", "direction"];
    let Some(declared) = direction(files) else { return Vec::new() };
    let setting = |effect: &'static str, what: &str, to: Vector3<f64>| {
        let value = to.iter().map(|v| toml::Value::Float(*v)).collect();
        let what = format!("{what}: it should be [{}, {}, {}]", to.x, to.y, to.z);
        other_setting(&path, effect, &what, toml::Value::Array(value))
    };
    let mut all = vec![setting(
        "input:direction",
        "reversed (of the opposite sign), and with it the sense of every angle",
        -declared,
    )];
    for along in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for to in [along, -along] {
            if to.dot(&declared).abs() < 0.5 * declared.norm() {
                let what = "along another axis than the one that turned (wrong axis letter)";
                all.push(setting("input:direction", what, to));
            }
        }
    }
    all
}

fn direction(files: &Files) -> Option<Vector3<f64>> {
    let document = &files.document;
    if document.value(&["axis", "direction"]).is_some() {
        return match numbers(document, &["axis", "direction"])?[..] {
            [x, y, z] => Some(Vector3::new(x, y, z)),
            _ => None,
        };
    }
    Some(match document.value(&["axis", "letter"])?.as_str()? {
        "A" => Vector3::x(),
        "B" => Vector3::y(),
        _ => Vector3::z(),
    })
}

pub(super) fn range_yardstick(survey: &Survey, fitted: &Fitted) -> Yardstick {
    let stations = survey.stations.iter().map(|s| s.nominal_mm).collect();
    let mounts: Vec<_> = survey.mounts.iter().map(|m| m.nominal_mm).collect();
    let read: Vec<[f64; 1]> = survey.ranges.iter().map(|r| [r.displacement_mm]).collect();
    let spread = spread_of(read.iter().map(<[f64; 1]>::as_slice));
    yardstick(spread, Some(stations), &mounts, fitted)
}

pub(super) fn target_yardstick(survey: &TargetSurvey, fitted: &Fitted) -> Yardstick {
    let mounts: Vec<Point3<f64>> = survey.mounts.iter().map(|m| m.nominal_mm).collect();
    let spread = spread_of(mounts.iter().map(|p| p.coords.as_slice()));
    yardstick(spread, None, &mounts, fitted)
}

/// Counts what the errors of the axis and the places take up beyond what is usual. Stations that are known to a few
/// mm turn the whole frame, and move the places of reflectors far from them.
fn yardstick(
    spread: f64,
    stations: Option<Vec<Point3<f64>>>,
    mounts: &[Point3<f64>],
    fitted: &Fitted,
) -> Yardstick {
    let Some(found) = fitted.estimates.downcast_ref::<TrackerLmEstimates>() else {
        return Yardstick::NONE;
    };
    let place = |x, y, z| Point3::new(x, y, z);
    let found_mounts: Vec<_> = found.mounts.iter().map(|m| place(m.x_mm, m.y_mm, m.z_mm)).collect();
    let (of_stations, turn_rad, away_mm) = stations.map_or((0.0, 0.0, 0.0), |stations| {
        let found: Vec<_> = found.stations.iter().map(|s| place(s.x_mm, s.y_mm, s.z_mm)).collect();
        let share = moved(&stations, &found);
        let turn_rad = if share > KNOWN { 0.0 } else { share };
        (beyond(share, USUAL_PLACE), turn_rad, (middle(&stations) - middle(mounts)).norm())
    });
    let by_frame = turn_rad * away_mm / spread_of(mounts.iter().map(|p| p.coords.as_slice()));
    let of_mounts = beyond(moved(mounts, &found_mounts), USUAL_PLACE + by_frame);
    let of_axis = beyond(turned(found, mounts), USUAL_ERROR);
    let taken_up = spread * of_axis.hypot(of_stations).hypot(of_mounts);
    Yardstick { spread, taken_up, gross: GROSS, unmatched: UNMATCHED, ..Yardstick::NONE }
}

fn middle(places: &[Point3<f64>]) -> Vector3<f64> {
    let sum: Vector3<f64> = places.iter().map(|place| place.coords).sum();
    sum / count(places.len().max(1))
}

fn beyond(share: f64, usual: f64) -> f64 {
    if share > usual { share } else { 0.0 }
}

/// Distance between two sets of places, over their spread.
fn moved(nominal: &[Point3<f64>], found: &[Point3<f64>]) -> f64 {
    let spread = |points: &[Point3<f64>]| spread_of(points.iter().map(|p| p.coords.as_slice()));
    let square: f64 = nominal.iter().zip(found).map(|(a, b)| (a - b).norm_squared()).sum();
    (square / count(nominal.len().max(1))).sqrt() / spread(nominal).max(spread(found))
}

/// What the six errors of the axis move the reflectors by, over their distance from it.
fn turned(found: &TrackerLmEstimates, mounts: &[Point3<f64>]) -> f64 {
    let mean = |sum: f64, n: usize| sum / count(n.max(1));
    let radius_mm =
        mean(mounts.iter().map(|m| m.coords.norm_squared()).sum::<f64>(), mounts.len()).sqrt();
    let square = found.axis_errors.iter().map(|e| {
        let shift = e.e_x_mm.powi(2) + e.e_y_mm.powi(2) + e.e_z_mm.powi(2);
        let turn = e.e_a_rad.powi(2) + e.e_b_rad.powi(2) + e.e_c_rad.powi(2);
        shift / radius_mm.powi(2) + turn
    });
    mean(square.sum::<f64>(), found.axis_errors.len()).sqrt()
}
