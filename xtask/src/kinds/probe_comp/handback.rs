//! Contacts of a touch probe: what is taken off a reading, and what stays in a deviation.

use serde_json::Value;

use crate::generators::vector::{add, cross, dot, norm, scale};
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{accepted, amplitude, begun, close, patch_mm, settled, step};
use crate::handback::{Left, as_f64};
use crate::kinds::probe_comp::probe_scenes::{EFFECTS, scenes};

/// Sums of a few dozen terms of coordinates of some tens of mm.
const ROUNDING_MM: f64 = 1e-11;

#[test]
fn contacts_as_printed_leave_the_error_that_is_printed() {
    for folder in Folder::committed("probe-comp") {
        check(&folder);
    }
}

#[test]
fn every_effect_on_a_probe_is_in_what_is_printed() {
    let mut missing: Vec<&str> = EFFECTS.to_vec();
    for (name, files) in scenes() {
        let folder = Folder::written(&format!("probe-comp/{name}"), &files);
        let found = accepted(&check(&folder));
        missing.retain(|effect| !found.iter().any(|f| f.starts_with(effect)));
    }
    assert!(missing.is_empty(), "never accepted: {missing:?}");
}

/// The part as drawn: a sphere about the origin, or a paraboloid bowl.
enum Part {
    Sphere(f64),
    Bowl(f64),
}

/// A nominal point with its normal, and how far a query is from it.
struct Foot {
    at: [f64; 3],
    normal: [f64; 3],
    distance: f64,
}

impl Part {
    fn of(folder: &Folder) -> Self {
        let document = folder.document();
        let surface = &document["surface"];
        let radius = surface["radius_mm"].as_float().expect("a radius with a point");
        match surface["shape"].as_str() {
            Some("sphere") => Self::Sphere(radius),
            Some("asphere") => {
                assert_eq!(surface["conic"].as_float(), Some(-1.0), "a paraboloid");
                Self::Bowl(radius)
            }
            other => panic!("a part of shape {other:?}"),
        }
    }

    fn foot(&self, query: [f64; 3]) -> Foot {
        match *self {
            Self::Sphere(radius) => {
                let normal = scale(1.0 / norm(&query), query);
                Foot { at: scale(radius, normal), normal, distance: norm(&query) - radius }
            }
            Self::Bowl(radius) => {
                let rho = query[0].hypot(query[1]);
                let mut r = rho;
                for _ in 0..60 {
                    let off = (r - rho) + (r * r / (2.0 * radius) - query[2]) * r / radius;
                    r -= off / (1.0 + (1.5 * r * r / radius - query[2]) / radius);
                }
                let out = if rho > 0.0 { [query[0] / rho, query[1] / rho] } else { [1.0, 0.0] };
                let at = [r * out[0], r * out[1], r * r / (2.0 * radius)];
                let steep = [-r / radius * out[0], -r / radius * out[1], 1.0];
                let normal = scale(1.0 / norm(&steep), steep);
                let distance = dot(add(query, scale(-1.0, at)), normal);
                Foot { at, normal, distance }
            }
        }
    }
}

/// Where the errors of form are measured from, and by what length.
struct FormScale {
    center: [f64; 3],
    radius: f64,
}

impl FormScale {
    fn of(part: &Part, feet: &[Foot]) -> Self {
        let center = match part {
            Part::Sphere(_) => [0.0; 3],
            Part::Bowl(_) => {
                let middle = |k: usize| {
                    let all = feet.iter().map(|f| f.at[k]);
                    let (low, high) =
                        all.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
                    0.5 * (low + high)
                };
                // Of the part's own origin where that lies within half of what was touched.
                let half = |k: usize| {
                    let all = feet.iter().map(|f| f.at[k]);
                    let (low, high) =
                        all.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
                    0.5 * (high - low)
                };
                if (0..2).all(|k| middle(k).abs() < 0.5 * half(k)) {
                    [0.0; 3]
                } else {
                    [middle(0), middle(1), 0.0]
                }
            }
        };
        let reach = |foot: &Foot| {
            let arm = add(foot.at, scale(-1.0, center));
            if matches!(part, Part::Sphere(_)) { norm(&arm) } else { arm[0].hypot(arm[1]) }
        };
        Self { center, radius: feet.iter().map(reach).fold(0.0, f64::max) }
    }
}

/// Closes the loop on a folder and compares what is left, and every deviation.
fn check(folder: &Folder) -> Value {
    let json = close(folder);
    let table = folder.table("touches.csv");
    let part = Part::of(folder);
    let tip = folder.document()["probe"]["tip_radius_mm"].as_float().expect("a ball");
    let places: Vec<[f64; 3]> = (0..table.rows())
        .map(|row| ["x_mm", "y_mm", "z_mm"].map(|name| table.numbers(name)[row]))
        .collect();
    let feet: Vec<Foot> = places.iter().map(|p| part.foot(*p)).collect();
    let form = FormScale::of(&part, &feet);
    let mut left = Left::default();
    for (row, printed) in
        json["estimates"]["touches"].as_array().expect("touches").iter().enumerate()
    {
        let touch = Touch { json: &json, table: &table, row, foot: &feet[row], tip, form: &form };
        let (read, off) = touch.added(printed["use"] == "fit");
        let distance = part.foot(add(places[row], scale(-1.0, read))).distance;
        let deviation = distance - tip - off;
        let said = printed["deviation_mm"].as_f64().expect("a deviation");
        let name = folder.name();
        assert!((deviation - said).abs() < ROUNDING_MM, "{name}, {row}: {deviation} and {said}");
        let empirical = printed.get("empirical_mm").map_or(0.0, |v| v.as_f64().expect("a number"));
        let residual = deviation - touch.height() + empirical;
        left.scale = places[row].iter().fold(left.scale, |m, v| m.max(v.abs()));
        if printed["use"] == "fit" {
            left.fitted.push(vec![residual]);
        } else {
            left.checked.push(vec![residual]);
        }
    }
    left.assert_is(&folder.name(), &json);
    json
}

struct Touch<'a> {
    json: &'a Value,
    table: &'a Table,
    row: usize,
    foot: &'a Foot,
    tip: f64,
    form: &'a FormScale,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Touch<'_> {
    fn number(&self, column: &str) -> f64 {
        self.table.numbers(column)[self.row]
    }

    fn approach(&self) -> [f64; 3] {
        if self.table.has("nx") {
            let given = ["nx", "ny", "nz"].map(|name| self.number(name));
            return scale(1.0 / norm(&given), given);
        }
        scale(-1.0, self.foot.normal)
    }

    /// What drifts and later sessions add to the reading.
    fn drifted(&self, approach: [f64; 3]) -> [f64; 3] {
        let json = self.json;
        let mut read = [0.0; 3];
        if let Some(found) = step(json, "drift", Some("trigger")) {
            let along = 1e-3 * amplitude(found, "travel") * self.elapsed();
            read = add(read, scale(along, approach));
        }
        if let Some(found) = step(json, "drift", Some("machine")) {
            for (k, axis) in AXES.iter().enumerate() {
                read[k] += 1e-3 * amplitude(found, axis) * self.elapsed();
            }
        }
        let settling = ["machine, settling", "machine, settling to zero"];
        for found in settling.into_iter().filter_map(|of| step(json, "drift", Some(of))) {
            let (is_time, rows) = (self.table.has("time_s"), self.table.rows());
            let course = settled(found, self.elapsed(), is_time, rows);
            for (k, axis) in AXES.iter().enumerate() {
                read[k] += 1e-3 * amplitude(found, axis) * course;
            }
        }
        for (k, axis) in AXES.iter().enumerate() {
            if let Some(found) = step(json, "reversal", Some(&format!("{axis}, by direction"))) {
                read[k] += 1e-3 * amplitude(found, axis) * self.number("direction").signum();
            }
        }
        let names = self.table.texts("touch");
        for found in begun(json, ("session-shift", "trigger, "), names, self.row) {
            read = add(read, scale(1e-3 * amplitude(found, "travel"), approach));
        }
        for found in begun(json, ("session-shift", "machine, "), names, self.row) {
            for (k, axis) in AXES.iter().enumerate() {
                read[k] += 1e-3 * amplitude(found, axis);
            }
        }
        read
    }

    /// What is taken off the ball's centre, and what off its distance.
    fn added(&self, is_fitted: bool) -> ([f64; 3], f64) {
        let (mut read, mut off) = ([0.0; 3], 0.0);
        let center = add(self.foot.at, scale(self.tip, self.foot.normal));
        let arm = add(center, scale(-1.0, self.form.center));
        let approach = self.approach();
        let json = self.json;
        let mut along = 0.0;
        if let Some(found) = step(json, "tip-radius", None) {
            off += amplitude(found, "radius");
        }
        if let Some(found) = step(json, "pretravel", None) {
            along += amplitude(found, "travel");
        }
        for (subject, power) in
            [("with the sideways part of the approach", 1), ("at every inclination", 0)]
        {
            if let Some(found) = step(json, "lobing", Some(subject)) {
                let azimuth = 3.0 * approach[1].atan2(approach[0]);
                let side = approach[0].hypot(approach[1]);
                let size = if side < 1e-3 { 0.0 } else { side.powi(power) };
                let (cos, sin) = (amplitude(found, "cos"), amplitude(found, "sin"));
                along += 1e-3 * size * (cos * azimuth.cos() + sin * azimuth.sin());
            }
        }
        if let Some(found) = step(json, "latency", None) {
            let speed = if self.table.has("feed_mm_per_min") {
                self.number("feed_mm_per_min") / 60.0
            } else {
                self.number("feed_mm_per_s")
            };
            along += 1e-3 * amplitude(found, "time") * speed;
        }
        read = add(read, scale(along, approach));
        if let Some(found) = step(json, "bending", None) {
            let sideways = [approach[0], approach[1], 0.0];
            read = add(read, scale(1e-3 * amplitude(found, "sideways"), sideways));
        }
        if let Some(found) = step(json, "datum-shift", None) {
            for (k, axis) in AXES.iter().enumerate() {
                read[k] += 1e-3 * amplitude(found, axis);
            }
        }
        if let Some(found) = step(json, "datum-turn", None) {
            for (k, axis) in AXES.iter().enumerate() {
                let mut about = [0.0; 3];
                about[k] = 1e-6 * amplitude(found, axis);
                read = add(read, cross(about, arm));
            }
        }
        for (k, axis) in AXES.iter().enumerate() {
            if let Some(found) = step(json, "axis-scale", Some(axis)) {
                read[k] += 1e-6 * amplitude(found, axis) * center[k];
            }
            if let Some(found) = step(json, "axis-scale", Some(&format!("{axis}, about the part")))
            {
                read[k] += 1e-6 * amplitude(found, axis) * (center[k] - self.form.center[k]);
            }
        }
        if let Some(found) = step(json, "squareness", None) {
            for (a, b) in [(0, 1), (0, 2), (1, 2)] {
                let name = format!("{}{}", AXES[a], AXES[b]);
                read[a] += 1e-6 * amplitude(found, &name) * center[b];
            }
        }
        read = add(read, self.drifted(approach));
        let warm = self.table.ending("_c");
        for column in &warm {
            let subject = (warm.len() > 1).then_some(column.as_str());
            if let Some(found) = step(json, "temperature", subject) {
                let excess_k = self.number(column) - 20.0;
                for (k, axis) in AXES.iter().enumerate() {
                    read[k] += 1e-3 * amplitude(found, &format!("{axis} growth")) * excess_k;
                }
                let out = dot(self.foot.normal, add(self.foot.at, scale(-1.0, self.form.center)));
                off += 1e-6 * amplitude(found, "expansion") * excess_k * out;
            }
        }
        let name = &self.table.texts("touch")[self.row];
        if is_fitted && let Some(found) = step(json, "bad-point", Some(name)) {
            off += amplitude(found, "along the normal");
        }
        (read, off)
    }

    /// Hours since the first touch, or the share of the series that has passed.
    fn elapsed(&self) -> f64 {
        if self.table.has("time_s") {
            return (self.number("time_s") - self.table.numbers("time_s")[0]) / 3600.0;
        }
        as_f64(self.row) / as_f64(self.table.rows() - 1)
    }

    /// By how much the real part is higher than drawn.
    fn height(&self) -> f64 {
        let arm = add(self.foot.at, scale(-1.0, self.form.center));
        let [x, y, z] = scale(1.0 / self.form.radius, arm);
        let (rho, theta) = (x.hypot(y), y.atan2(x));
        let wave = |n: f64| [(n * theta).cos(), (n * theta).sin()];
        let [c1, s1] = wave(1.0);
        let [c2, s2] = wave(2.0);
        let [c3, s3] = wave(3.0);
        let shapes: [(&str, Vec<(&str, f64)>); 6] = [
            ("focus", vec![("height", rho * rho)]),
            ("astigmatism", vec![("cos", rho.powi(2) * c2), ("sin", rho.powi(2) * s2)]),
            ("coma", {
                let size = 3.0 * rho.powi(3) - 2.0 * rho;
                vec![("cos", size * c1), ("sin", size * s1)]
            }),
            ("trefoil", vec![("cos", rho.powi(3) * c3), ("sin", rho.powi(3) * s3)]),
            (
                "ellipsoid",
                vec![
                    ("xx − yy", x * x - y * y),
                    ("xy", 2.0 * x * y),
                    ("xz", 2.0 * x * z),
                    ("yz", 2.0 * y * z),
                    ("zz", 0.5 * (3.0 * z * z - 1.0)),
                ],
            ),
            (
                "lobes",
                vec![
                    ("3 cos", rho.powi(3) * c3),
                    ("3 sin", rho.powi(3) * s3),
                    ("2 cos z", rho.powi(2) * c2 * z),
                    ("2 sin z", rho.powi(2) * s2 * z),
                    ("cos zz", rho * c1 * (5.0 * z * z - 1.0)),
                    ("sin zz", rho * s1 * (5.0 * z * z - 1.0)),
                    ("zzz", 0.5 * (5.0 * z.powi(3) - 3.0 * z)),
                ],
            ),
        ];
        let mut height = patch_mm(self.json, self.foot.at);
        for (name, parts) in shapes {
            // What a sphere alone has is a subject of `form`.
            let own = step(self.json, name, None);
            if let Some(found) = own.or_else(|| step(self.json, "form", Some(name))) {
                height +=
                    parts.iter().map(|(name, v)| 1e-3 * amplitude(found, name) * v).sum::<f64>();
            }
        }
        height
    }
}
