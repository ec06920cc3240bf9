//! An axis that stops elsewhere when it comes from the other side.

use nalgebra::Vector3;

use super::entry::{AXES, Entry, Setting, entry, parameter};
use super::measured::MeasuredTouch;
use super::term::{Term, WaysFrom};

/// The column that says which way each touch was made.
const DIRECTION: &str = "direction";
/// Mean square of a normal's component from which the reversal of that axis can be told: the touches
/// see a thirtieth of it. A screw's play of 30 µm shows as 1 µm, and what shows and has no name is
/// named after something else: along a slope, as a scale of that axis.
const SEEN_REVERSAL: f64 = 0.001;
/// Touches from either side of an axis from which its reversal can be told: of fewer, which side each came
/// from is a pattern that the part may have as well.
const EACH_WAY: usize = 5;
/// An axis that moves by less between two touches stands still: the noise of readings does no more.
const STILL_MM: f64 = 0.02;

/// Half of what an axis reads more when it came from below than when it came from above: by the touch
/// before, as where a part is touched along one axis and the others stand, by the approach, as
/// where the ball comes along the normal, and by a recorded direction, as of lines that are measured to and fro.
///
/// One candidate per axis, as play is a matter of one screw, and one of all axes: along the normal x and
/// y together look like a shorter vertex radius, and neither of them alone like anything.
pub(super) fn reversals(setting: &Setting<'_>) -> Vec<Entry> {
    let between = ways_between(setting.touches);
    let along: Vec<_> =
        setting.normals.iter().map(|n| n.map(|v| sign(-setting.side * v))).collect();
    let by = |ways: Vec<Vector3<f64>>, ways_from: WaysFrom| {
        let is_met = |axis: usize, sign: f64| {
            ways.iter().filter(|way| way[axis] * sign > 0.0).count() >= EACH_WAY
        };
        let is_seen = |axis: &usize| {
            setting.normal_squares[*axis] > SEEN_REVERSAL
                && is_met(*axis, 1.0)
                && is_met(*axis, -1.0)
        };
        let seen: Vec<usize> = (0..3).filter(is_seen).collect();
        let alone = (0..3).map(|axis| if is_seen(&axis) { vec![axis] } else { Vec::new() });
        let together = if seen.len() > 1 { seen.clone() } else { Vec::new() };
        let mut entries: Vec<Entry> = (alone.enumerate())
            .map(|(axis, axes)| reversal(&[axis], &axes, &ways, ways_from))
            .collect();
        entries.push(reversal(&[0, 1, 2], &together, &ways, ways_from));
        entries
    };
    let mut entries = by(between, WaysFrom::TouchBefore);
    entries.extend(by(along, WaysFrom::Approach));
    if let Some(recorded) = setting.covariates.iter().find(|c| c.name == DIRECTION) {
        let ways = recorded.values.iter().map(|value| Vector3::repeat(sign(*value))).collect();
        entries.extend(by(ways, WaysFrom::Column));
    }
    entries
}

/// Of the axes `of`, of which the touches show `axes`.
fn reversal(of: &[usize], axes: &[usize], ways: &[Vector3<f64>], ways_from: WaysFrom) -> Entry {
    let (name, subject) = match of {
        [axis] => {
            (format!("the machine's {} axis reads", AXES[*axis]), format!("{}, ", AXES[*axis]))
        }
        _ => ("the machine's axes read".to_owned(), String::new()),
    };
    let text = match ways_from {
        WaysFrom::TouchBefore => "otherwise after a way from the touch before to the other side",
        WaysFrom::Approach => "otherwise where the ball comes along the normal from the other side",
        WaysFrom::Column => {
            "otherwise where the touches were made the other way, as `direction` says"
        }
    };
    let by = match ways_from {
        WaysFrom::TouchBefore => "by touch",
        WaysFrom::Approach => "by approach",
        WaysFrom::Column => "by direction",
    };
    // An effect that nothing shows keeps its names.
    let shown = if axes.is_empty() { of } else { axes };
    let first = (ways_from == WaysFrom::TouchBefore).then_some("first touch");
    let names = shown.iter().map(|&axis| AXES[axis]).chain(first);
    let parameters = names.map(|name| parameter(name, "µm", 1e3)).collect();
    let ways = if axes.is_empty() { Vec::new() } else { ways.to_vec() };
    let term = Term::Reversal { ways, axes: shown.to_vec(), ways_from };
    let mut entry = entry("reversal", &format!("{name} {text}"), parameters, term);
    entry.effect.subject = Some(format!("{subject}{by}"));
    entry
}

/// Ways of the axes to each touch from the one before; none to the first one. An axis that stands still
/// stays on the side that it came from.
fn ways_between(touches: &[MeasuredTouch]) -> Vec<Vector3<f64>> {
    let (mut way, mut before) = (Vector3::zeros(), None);
    let places = touches.iter().map(|t| t.touch.center_mm.coords);
    places
        .map(|place| {
            let moved: Vector3<f64> = place - before.replace(place).unwrap_or(place);
            way = moved.zip_map(
                &way,
                |moved, way| if moved.abs() > STILL_MM { moved.signum() } else { way },
            );
            way
        })
        .collect()
}

/// The sign of a value; none of zero.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}
