//! What may be wrong with the touches of a probe, its ball or the drawing of the part.

use nalgebra::Vector3;

use super::around::around_others;
use super::estimates::ProbeCompEstimates;
use super::settings::{MICRO, TOUCHES};
use super::tables::{APPROACH, KNOWN, UNIT_TOL};
use crate::case::Table;
use crate::count::rms;
use crate::kind::Files;
use crate::kinds::surface::{
    XYZ, mistakes_of_drawing, mistakes_of_points, mistakes_of_rows, yardstick_of,
};
use crate::measured::Fitted;
use crate::residual::Residual;
use crate::suspect::{
    Hypothesis, component_shifted, exchanges, lengths, lines_of, number, other_setting,
    rows_left_out, rows_shifted, rows_shifted_by, signs,
};

/// Root mean square sine of the angle between approach and normal from which on it is asked why: 10°.
const BESIDE: f64 = 0.17;
/// Times that it must be smaller with a change of the coordinates.
const STRAIGHTER: f64 = 4.0;
/// Share of the radius within which a touch is off by it, and below which it is not off.
const BY_THE_RADIUS: f64 = 0.05;
const NEAR: f64 = 0.25;
/// Touches off by it that are no accident.
const FEWEST_COMPENSATED: usize = 2;

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let columns = ["touch", XYZ[0], XYZ[1], XYZ[2]];
    let table = files.folder.table(TOUCHES, &columns).ok();
    let table = table.as_ref();
    let mut all = sides(files);
    all.extend(lengths(&files.document, &["probe", "tip_radius_mm"]));
    all.extend(lengths(&files.document, &["qualification", "radius_mm"]));
    all.extend(mistakes_of_drawing(files));
    all.extend(mistakes_of_points(TOUCHES, table));
    if files.folder.has(MICRO) {
        let around = files.folder.table(MICRO, &columns).ok();
        all.extend(mistakes_of_points(MICRO, around.as_ref()));
        all.extend(around_others(files));
    }
    all.extend(outward(table));
    all.extend(exchanges(TOUCHES, table, &APPROACH));
    all.extend(component_shifted(TOUCHES, table, &APPROACH, UNIT_TOL));
    all.extend(signs(TOUCHES, table, &APPROACH));
    all.extend(rows_shifted(TOUCHES, table, &APPROACH, None));
    all.extend(table.zip(fitted).and_then(|(table, fitted)| against_approaches(table, fitted)));
    all.extend(
        table.zip(fitted).and_then(|(table, fitted)| compensated_rows(files, table, fitted)),
    );
    all.extend(mistakes_of_rows(TOUCHES, table, KNOWN, fitted));
    all
}

/// Some rows off by the radius of the ball, inwards, or by its diameter, and all others by next to nothing: they hold
/// contact points, or the centre of a ball on the other side.
fn compensated_rows(files: &Files, table: &Table, fitted: &Fitted) -> Option<Hypothesis> {
    let found = fitted.estimates.downcast_ref::<ProbeCompEstimates>()?;
    let radius_mm = number(&files.document, &["probe", "tip_radius_mm"])?;
    let off: Vec<f64> = found.touches.iter().map(|touch| touch.deviation_mm).collect();
    let is_off_by = |mm: f64, by_mm: f64| (mm + by_mm).abs() <= BY_THE_RADIUS * radius_mm;
    let holds = [
        (
            "input:compensated",
            radius_mm,
            "contact points, from which the radius was taken off already",
        ),
        ("input:side", 2.0 * radius_mm, "centres of a ball on the other side of the surface"),
    ];
    let of = |(effect, by_mm, what): (&'static str, f64, &str)| {
        let marked: Vec<bool> = off.iter().map(|mm| is_off_by(*mm, by_mm)).collect();
        let n_marked = marked.iter().filter(|marked| **marked).count();
        let mut others = off.iter().zip(&marked).filter(|(_, marked)| !**marked);
        let is_all = others.all(|(mm, _)| mm.abs() <= NEAR * radius_mm);
        let is_some = n_marked >= FEWEST_COMPENSATED && 2 * n_marked <= off.len();
        if off.len() != table.n_rows() || !is_all || !is_some {
            return None;
        }
        let description = format!(
            "the touches of {TOUCHES} in lines {} are {what}: put back the centres of the ball, or leave these rows out",
            lines_of(table, &marked)
        );
        let edits = vec![rows_left_out(TOUCHES, &marked)];
        Some(Hypothesis::of(effect, (TOUCHES, &XYZ), description, edits).shown())
    };
    holds.into_iter().find_map(of)
}

/// Coordinates exchanged or mirrored so that the part looks the same, as one of revolution does, or approaches of other
/// rows: the touches then come from beside the normals of where they seem to be, and along those of where they were.
fn against_approaches(table: &Table, fitted: &Fitted) -> Option<Hypothesis> {
    let found = fitted.estimates.downcast_ref::<ProbeCompEstimates>()?;
    let [nx, ny, nz] = APPROACH.map(|name| table.numbers(name));
    let (nx, ny, nz) = (nx?, ny?, nz?);
    let normals: Vec<Vector3<f64>> =
        found.touches.iter().map(|t| Vector3::new(t.nx, t.ny, t.nz)).collect();
    // Of a part that the touches do not fit the normals say nothing.
    let places: Vec<[f64; 3]> = found.touches.iter().map(|t| [t.x_mm, t.y_mm, t.z_mm]).collect();
    let misfit_mm = Residual::of(fitted.observations.iter(), 1, fitted.unit).rms.unwrap_or(0.0);
    let yardstick = yardstick_of(places.iter().map(|place| &place[..]));
    if normals.len() != nx.len() || misfit_mm > yardstick.gross * yardstick.spread {
        return None;
    }
    // Of the touches whose normals are those of others, where there are these.
    let besides = |of: &dyn Fn(usize) -> Option<Vector3<f64>>| {
        let beside = |row: usize| {
            let came = Vector3::new(nx[row], ny[row], nz[row]);
            Some(came.cross(&of(row)?).norm() / came.norm())
        };
        rms((0..normals.len()).filter_map(beside))
    };
    let now = besides(&|row| Some(normals[row]));
    let turned = symmetries(table).into_iter().map(|symmetry| {
        let then = besides(&|row| Some(symmetry.of(&normals[row])));
        (then, symmetry.hypothesis, " (or the same is wrong with `nx`, `ny`, `nz`)")
    });
    let shifted = [1, -1].into_iter().filter_map(|by| {
        let of_row = |row: usize| normals.get(row.checked_add_signed(-by)?).copied();
        let hypotheses = rows_shifted_by(TOUCHES, Some(table), &APPROACH, None, by);
        Some((besides(&of_row), hypotheses.into_iter().next()?, ""))
    });
    let straighter = turned.chain(shifted).filter(|(then, ..)| then * STRAIGHTER <= now);
    let (then, found, or) =
        straighter.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| now >= BESIDE)?;
    let degrees = |sine: f64| sine.min(1.0).asin().to_degrees();
    let description = format!(
        "{}; as they are the touches came from {:.0}° beside the normals, then from {:.0}°{or}",
        found.description,
        degrees(now),
        degrees(then)
    );
    Some(Hypothesis { description, ..found }.certain())
}

/// What may be wrong with the coordinates, and what it does to a normal.
struct Symmetry {
    hypothesis: Hypothesis,
    /// Which component comes to each place, and with which sign.
    order: [usize; 3],
    sign: [f64; 3],
}

impl Symmetry {
    fn of(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.sign[i] * normal[self.order[i]])
    }
}

/// Two coordinates exchanged, or one mirrored.
fn symmetries(table: &Table) -> Vec<Symmetry> {
    let exchanged = |[a, b]: [usize; 2]| {
        let mut order = [0, 1, 2];
        order.swap(a, b);
        let hypothesis = exchanges(TOUCHES, Some(table), &[XYZ[a], XYZ[b]]).pop()?;
        Some(Symmetry { hypothesis, order, sign: [1.0; 3] })
    };
    let mirrored = |axis: usize| {
        let mut sign = [1.0; 3];
        sign[axis] = -1.0;
        let hypothesis = signs(TOUCHES, Some(table), &[XYZ[axis]]).pop()?;
        Some(Symmetry { hypothesis, order: [0, 1, 2], sign })
    };
    let pairs = [[0, 1], [0, 2], [1, 2]].into_iter().filter_map(exchanged);
    pairs.chain((0..3).filter_map(mirrored)).collect()
}

/// Directions given as normals of the part instead of approaches, or inward for outward.
fn outward(table: Option<&Table>) -> Vec<Hypothesis> {
    let turned = signs(TOUCHES, table, &APPROACH).pop();
    let named = |found: Hypothesis| Hypothesis {
        effect: "input:normal",
        description: format!(
            "{}; they are normals of the other side, inward instead of outward or outward instead \
             of the approach",
            found.description
        ),
        ..found
    };
    turned.filter(|_| table.is_some_and(|t| t.has(APPROACH[0]))).map(named).into_iter().collect()
}

/// The ball on the other side of the surface.
fn sides(files: &Files) -> Vec<Hypothesis> {
    let of_sphere = files.document.value(&["surface", "shape"]);
    let is_sphere = of_sphere.is_some_and(|shape| shape.as_str() == Some("sphere"));
    let (path, names) = if is_sphere {
        (["surface", "side"], ["outside", "inside"])
    } else {
        (["probe", "side"], ["+z", "-z"])
    };
    let given = files.document.value(&path);
    let is_second = given.is_some_and(|side| side.as_str() == Some(names[1]));
    // Where nothing is given, either side may be the one that was taken.
    let others = if is_second { &names[..1] } else { &names[1..] };
    let one = |other: &&str| {
        let what = format!("wrong, the ball was on the other side of the surface: \"{other}\"");
        other_setting(&path, "input:side", &what, toml::Value::String((*other).to_owned()))
    };
    others.iter().map(one).collect()
}
