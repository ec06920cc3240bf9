//! A pose, the errors of the machine's axes, and what a touch is corrected by.

use std::fmt::Write as _;

use serde_json::Value;

use crate::generators::vector::{add, dot, scale};
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{
    accepted, amplitude, begun, close, correct, numbers, patch_mm, settled, step, subjects,
};
use crate::handback::{Left, as_f64};
use crate::kinds::pose_icp::pose_scenes::{EFFECTS, scenes};

#[test]
fn a_pose_as_printed_leaves_the_error_that_is_printed() {
    let is_asphere = |f: &Folder| f.document()["surface"]["shape"].as_str() == Some("asphere");
    for folder in Folder::committed("pose-icp").into_iter().filter(is_asphere) {
        let json = close(&folder);
        applied(&folder, &json).assert_is(&folder.name(), &json);
    }
}

#[test]
fn every_effect_on_a_pose_is_in_what_is_printed() {
    let mut missing: Vec<&str> = EFFECTS.to_vec();
    for (name, files) in scenes() {
        let folder = Folder::written(&format!("pose-icp/{name}"), &files);
        let json = close(&folder);
        applied(&folder, &json).assert_is(&folder.name(), &json);
        program_goes_to_the_readings(&folder, &json);
        let found = accepted(&json);
        missing.retain(|effect| !found.iter().any(|f| f.starts_with(effect)));
    }
    assert!(missing.is_empty(), "never accepted: {missing:?}");
}

/// A surface of revolution about z, its vertex at the origin.
struct Asphere {
    radius_mm: f64,
    conic: f64,
    coefficients: Vec<f64>,
    rim_mm: f64,
}

impl Asphere {
    fn of(folder: &Folder) -> Self {
        let document = folder.document();
        let surface = &document["surface"];
        let number = |value: &toml::Value| {
            let whole = |v: i64| {
                #[expect(clippy::cast_precision_loss, reason = "a small number of a case")]
                let number = v as f64;
                number
            };
            value.as_float().or_else(|| value.as_integer().map(whole)).expect("a number")
        };
        let coefficients = surface.get("coefficients").and_then(toml::Value::as_array);
        Self {
            radius_mm: number(&surface["radius_mm"]),
            conic: number(&surface["conic"]),
            coefficients: coefficients.map_or_else(Vec::new, |c| c.iter().map(number).collect()),
            rim_mm: 0.5 * number(&surface["diameter_mm"]),
        }
    }

    /// Sag and slope at a distance from the axis.
    fn sag(&self, r: f64) -> [f64; 2] {
        let c = 1.0 / self.radius_mm;
        let w = (1.0 - (1.0 + self.conic) * c * c * r * r).sqrt();
        let mut sag = [c * r * r / (1.0 + w), c * r / w];
        for (k, a) in self.coefficients.iter().enumerate() {
            let power = i32::try_from(2 * k + 4).expect("a few coefficients");
            sag[0] += a * r.powi(power);
            sag[1] += f64::from(power) * a * r.powi(power - 1);
        }
        sag
    }

    /// Distance of a point along the normal, positive on the side of +z: Newton on the meridian.
    fn distance(&self, at: [f64; 3]) -> f64 {
        let rho = at[0].hypot(at[1]);
        let off = |r: f64| {
            let [z, slope] = self.sag(r);
            (r - rho) + (z - at[2]) * slope
        };
        let mut r = rho;
        for _ in 0..60 {
            // The derivative is near one: differences converge as fast as is needed.
            let by = 1e-4;
            r -= off(r) * 2.0 * by / (off(r + by) - off(r - by));
        }
        let [z, slope] = self.sag(r);
        ((at[2] - z) - (rho - r) * slope) / (1.0 + slope * slope).sqrt()
    }

    /// `∂z/∂R` and `∂z/∂k`, by differences.
    fn by_shape(&self, at: &[f64]) -> [f64; 2] {
        let r = at[0].hypot(at[1]);
        let c = 1.0 / self.radius_mm;
        let w = (1.0 - (1.0 + self.conic) * c * c * r * r).sqrt();
        [-c * c * r * r / (w * (1.0 + w)), c.powi(3) * r.powi(4) / (2.0 * w * (1.0 + w).powi(2))]
    }
}

/// What is left of every touch.
fn applied(folder: &Folder, json: &Value) -> Left {
    let table = folder.table("points.csv");
    let part = Asphere::of(folder);
    let document = folder.document();
    let probe = document.get("probe");
    let tip_mm = probe
        .and_then(|p| p.get("tip_radius_mm"))
        .map_or(0.0, |v| v.as_float().expect("a radius with a point"));
    let printed = json["estimates"]["points"].as_array().expect("points");
    let mut left = Left::default();
    for (row, point) in printed.iter().enumerate() {
        let read = ["x_mm", "y_mm", "z_mm"].map(|name| table.numbers(name)[row]);
        let sound = add(read, scale(-1.0, machine_error(json, &table, row, read)));
        let distance = part.distance(in_workpiece(&json["estimates"]["pose"], sound));
        let off = distance - tip_mm - added(json, &part, &table, row, point);
        let normal =
            turned(&json["estimates"]["pose"], triple(&numbers(&point["declared_normal"])));
        let residual = off / read_along(json, normal);
        left.scale = read.iter().fold(left.scale, |m, v| m.max(v.abs()));
        if point["use"] == "fit" {
            left.fitted.push(vec![residual]);
        } else {
            left.checked.push(vec![residual]);
        }
    }
    left
}

/// Corrected coordinates are written to nine decimals, mm; ten times what rounding leaves.
const WRITTEN_MM: f64 = 5e-9;

/// A program through the centres of the ball, in coordinates of the part, goes once corrected to
/// where the machine read them: what time and temperature added to single readings is no place.
fn program_goes_to_the_readings(folder: &Folder, json: &Value) {
    let table = folder.table("points.csv");
    let columns = ["x_mm", "y_mm", "z_mm"].map(|name| table.numbers(name));
    let mut program = "G90 G21 G1 F100\n".to_owned();
    let mut read = Vec::new();
    for row in 0..table.rows() {
        let passing = passing_error(json, &table, row);
        let lasting = add(columns.each_ref().map(|c| c[row]), scale(-1.0, passing));
        let sound = add(lasting, scale(-1.0, axes_error(json, lasting)));
        let [x, y, z] = in_workpiece(&json["estimates"]["pose"], sound);
        let _ = writeln!(program, "X{x:.9} Y{y:.9} Z{z:.9}");
        read.push(lasting);
    }
    let written = correct(folder, json, &program);
    let moves: Vec<[f64; 3]> = written.lines().filter_map(coordinates).collect();
    assert_eq!(moves.len(), read.len(), "{}: {written}", folder.name());
    for (found, wanted) in moves.iter().zip(&read) {
        let off = (0..3).map(|k| (found[k] - wanted[k]).abs()).fold(0.0, f64::max);
        assert!(off <= WRITTEN_MM, "{}: {found:?} and read {wanted:?}", folder.name());
    }
}

/// X, Y and Z of a block that has all of them.
fn coordinates(block: &str) -> Option<[f64; 3]> {
    let words: Vec<&str> = block.split_whitespace().collect();
    let of = |letter: char| words.iter().find_map(|w| w.strip_prefix(letter)?.parse().ok());
    Some([of('X')?, of('Y')?, of('Z')?])
}

/// `Rᵀ(q − d)` with `R = Rz(γ) Ry(β) Rx(α)`.
fn in_workpiece(pose: &Value, at: [f64; 3]) -> [f64; 3] {
    let number = |name: &str| pose[name].as_f64().expect("a number");
    let d = ["x_mm", "y_mm", "z_mm"].map(number);
    let [a, b, g] = ["alpha_deg", "beta_deg", "gamma_deg"].map(|n| number(n).to_radians());
    let [x, y, z] = add(at, scale(-1.0, d));
    let (x, y) = (g.cos() * x + g.sin() * y, -g.sin() * x + g.cos() * y);
    let (x, z) = (b.cos() * x - b.sin() * z, b.sin() * x + b.cos() * z);
    let (y, z) = (a.cos() * y + a.sin() * z, -a.sin() * y + a.cos() * z);
    [x, y, z]
}

/// `R n`: a direction of the workpiece in the machine.
fn turned(pose: &Value, direction: [f64; 3]) -> [f64; 3] {
    let origin = ["x_mm", "y_mm", "z_mm"].map(|name| pose[name].as_f64().expect("a number"));
    std::array::from_fn(|k| {
        let axis: [f64; 3] = std::array::from_fn(|i| f64::from(u8::from(i == k)));
        dot(in_workpiece(pose, add(origin, axis)), direction)
    })
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// What the machine adds to a reading.
fn machine_error(json: &Value, table: &Table, row: usize, read: [f64; 3]) -> [f64; 3] {
    // In first order of both: the place of a reading is that of the machine's scales.
    add(axes_error(json, read), passing_error(json, table, row))
}

/// What its axes add at a place.
fn axes_error(json: &Value, read: [f64; 3]) -> [f64; 3] {
    let mut error = [0.0; 3];
    if let Some(reference) = json["estimates"].get("reference_mm") {
        let reference = numbers(reference);
        let arm: [f64; 3] = std::array::from_fn(|k| read[k] - reference[k]);
        for (k, axis) in AXES.iter().enumerate() {
            if let Some(long) = step(json, "axis-scale", Some(axis)) {
                error[k] += amplitude(long, axis) * 1e-6 * arm[k];
            }
        }
        if let Some(skew) = step(json, "squareness", None) {
            for (a, b) in [(0, 1), (0, 2), (1, 2)] {
                let name = format!("{}{}", AXES[a], AXES[b]);
                error[a] += amplitude(skew, &name) * 1e-6 * arm[b];
            }
        }
    }
    error
}

/// How much a reading along a direction is longer than the way: `|(1 − E)ᵀ n|`.
fn read_along(json: &Value, normal: [f64; 3]) -> f64 {
    let Some(reference) = json["estimates"].get("reference_mm") else { return 1.0 };
    let reference = triple(&numbers(reference));
    // (1 − E) applied to each axis, a millimetre from the reference.
    let along = |k: usize| {
        let axis: [f64; 3] = std::array::from_fn(|i| f64::from(u8::from(i == k)));
        dot(normal, add(axis, scale(-1.0, axes_error(json, add(reference, axis)))))
    };
    (0..3).map(|k| along(k).powi(2)).sum::<f64>().sqrt()
}

/// What time and temperature add to one reading.
fn passing_error(json: &Value, table: &Table, row: usize) -> [f64; 3] {
    let mut error = [0.0; 3];
    let mut moved = |by: &Value, course: f64| {
        for (k, axis) in AXES.iter().enumerate() {
            error[k] += amplitude(by, axis) * 1e-3 * course;
        }
    };
    let drifts = [None, Some("sideways")].map(|whose| step(json, "drift", whose));
    for drift in drifts.into_iter().flatten() {
        moved(drift, elapsed(table, row));
    }
    if let Some(drift) = step(json, "drift", Some("settling")) {
        moved(drift, settled(drift, elapsed(table, row), table.has("time_s"), table.rows()));
    }
    for whose in ["", "sideways, "] {
        for shift in begun(json, ("session-shift", whose), table.texts("point"), row) {
            moved(shift, 1.0);
        }
    }
    for (k, axis) in AXES.iter().enumerate() {
        let size = |by: &str| -> f64 {
            let alone = step(json, "reversal", Some(&format!("{axis}, by {by}")));
            let together = step(json, "reversal", Some(&format!("by {by}")));
            [alone, together].into_iter().flatten().map(|found| amplitude(found, axis) * 1e-3).sum()
        };
        error[k] += size("touch") * way(table, row, k) + size("approach") * way_along(json, row, k);
        if table.has("direction") {
            error[k] += size("direction") * table.numbers("direction")[row].signum();
        }
    }
    if let Some((growth, excess_k)) = temperature(json, table, row) {
        for (k, axis) in AXES.iter().enumerate() {
            error[k] += amplitude(growth, &format!("{axis} growth")) * 1e-3 * excess_k;
        }
    }
    error
}

/// An axis that moves by less than this between two touches, mm, stays on the side that it came from.
const STILL_MM: f64 = 0.02;

/// +1 where an axis came up from the touch before, −1 where it came down; 0 while it has not moved.
fn way(table: &Table, row: usize, axis: usize) -> f64 {
    let read = table.numbers(["x_mm", "y_mm", "z_mm"][axis]);
    let moved = (1..=row).rev().map(|r| read[r] - read[r - 1]);
    moved.into_iter().find(|by| by.abs() > STILL_MM).map_or(0.0, f64::signum)
}

fn has_amplitude(found: &Value, axis: &str) -> bool {
    found["parameters"].as_array().expect("parameters").iter().any(|p| p["name"] == axis)
}

/// The same while the ball came along the normal, from above the part.
fn way_along(json: &Value, row: usize, axis: usize) -> f64 {
    let normal = triple(&numbers(&json["estimates"]["points"][row]["declared_normal"]));
    let pose = &json["estimates"]["pose"];
    let origin = ["x_mm", "y_mm", "z_mm"].map(|name| pose[name].as_f64().expect("a number"));
    let mut ahead = origin;
    ahead[axis] += 1.0;
    // The axis' direction in the workpiece.
    -dot(in_workpiece(pose, ahead), normal).signum()
}

/// Hours since the first touch, or the share of the series that has passed.
fn elapsed(table: &Table, row: usize) -> f64 {
    if table.has("time_s") {
        let time_s = table.numbers("time_s");
        (time_s[row] - time_s[0]) / 3600.0
    } else {
        as_f64(row) / as_f64(table.rows() - 1)
    }
}

/// The accepted growth with a temperature, and how warm it was.
fn temperature<'a>(json: &'a Value, table: &Table, row: usize) -> Option<(&'a Value, f64)> {
    let columns = table.ending("_c");
    columns.iter().find_map(|column| {
        let subject = (columns.len() > 1).then_some(column.as_str());
        let growth = step(json, "temperature", subject)?;
        Some((growth, table.numbers(column)[row] - 20.0))
    })
}

/// What ball, part and the touch itself add to a distance.
fn added(json: &Value, part: &Asphere, table: &Table, row: usize, point: &Value) -> f64 {
    let contact = numbers(&point["declared_contact_mm"]);
    let normal = numbers(&point["declared_normal"]);
    let mut height = 0.0;
    if let Some(longer) = step(json, "vertex-radius", None) {
        height += amplitude(longer, "radius") * part.by_shape(&contact)[0];
    }
    if let Some(larger) = step(json, "conic", None) {
        height += amplitude(larger, "conic") * part.by_shape(&contact)[1];
    }
    let (rho, theta) = (contact[0].hypot(contact[1]) / part.rim_mm, contact[1].atan2(contact[0]));
    let lobes = [
        ("astigmatism", 2.0, rho.powi(2)),
        ("coma", 1.0, 3.0 * rho.powi(3) - 2.0 * rho),
        ("trefoil", 3.0, rho.powi(3)),
    ];
    for (id, count, size) in lobes {
        if let Some(form) = step(json, id, None) {
            let (sin, cos) = (count * theta).sin_cos();
            height += 1e-3 * size * (amplitude(form, "cos") * cos + amplitude(form, "sin") * sin);
        }
    }
    if let Some(saddle) = step(json, "astigmatism", Some("diagonal")) {
        let gamma = json["estimates"]["pose"]["gamma_deg"].as_f64().expect("an angle");
        let along = (2.0 * (theta + gamma.to_radians())).sin();
        height += 1e-3 * amplitude(saddle, "diagonal") * rho.powi(2) * along;
    }
    let mut added = height * normal[2] + patch_mm(json, triple(&contact));
    for (subject, found) in subjects(json, "reversal") {
        let moved = AXES
            .iter()
            .enumerate()
            .filter(|(_, axis)| subject.starts_with(&format!("{axis},")) || !subject.contains(','));
        let mut moved = moved.filter(|(_, axis)| has_amplitude(found, axis));
        if subject.ends_with("by touch") && moved.any(|(k, _)| way(table, row, k) == 0.0) {
            added += amplitude(found, "first touch") * 1e-3;
        }
    }
    if let Some(ball) = step(json, "tip-radius", None) {
        added += amplitude(ball, "radius");
    }
    if let Some((growth, excess_k)) = temperature(json, table, row) {
        let out = dot(triple(&normal), triple(&contact));
        added += amplitude(growth, "expansion") * 1e-6 * excess_k * out;
    }
    let name = point["point"].as_str().expect("a name");
    if let Some(bad) = step(json, "bad-point", Some(name))
        && point["use"] == "fit"
    {
        added += amplitude(bad, "along the normal");
    }
    added - point.get("empirical_mm").map_or(0.0, |v| v.as_f64().expect("a number"))
}

fn triple(list: &[f64]) -> [f64; 3] {
    [list[0], list[1], list[2]]
}
