//! Stations, reflectors and the six errors of an axis from points, and what is left of every point.

use serde_json::Value;

use crate::generators::vector::{add, cross, dot, norm, rotate, scale};
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{accepted, amplitude, close, step, subjects};
use crate::handback::{AGREEMENT, as_f64};
use crate::kinds::tracker_lm::handback::{AXES, ERRORS};
use crate::kinds::tracker_lm::target_scenes::{EFFECTS, scenes};

#[test]
fn an_axis_from_points_as_printed_leaves_the_error_that_is_printed() {
    for folder in Folder::committed("tracker-lm").into_iter().filter(|f| f.has("targets.csv")) {
        let json = close(&folder);
        assert_is(&folder, &json);
    }
}

#[test]
fn every_effect_on_points_is_in_what_is_printed() {
    let mut missing: Vec<&str> = EFFECTS.to_vec();
    for (name, files) in scenes() {
        let folder = Folder::written(&format!("tracker-lm/{name}"), &files);
        let json = close(&folder);
        assert_is(&folder, &json);
        let found = accepted(&json);
        assert_eq!(found.len(), 1, "{name}: {found:?}");
        missing.retain(|effect| !found.iter().any(|f| f.starts_with(effect)));
    }
    assert!(missing.is_empty(), "never accepted: {missing:?}");
}

/// χ² of all points with what was printed applied is that of the printed answer.
fn assert_is(folder: &Folder, json: &Value) {
    let survey = Survey::new(folder, json);
    let document = folder.document();
    let sigma = |key: &str| document.get("noise")?.get(key)?.as_float();
    let (Some(range_mm), Some(angle_rad)) = (sigma("range_mm"), sigma("angle_rad")) else { return };
    let chi2: f64 = (0..survey.table.rows())
        .map(|row| {
            let measured = survey.measured(row);
            let distance = norm(&measured);
            let beam = scale(1.0 / distance, measured);
            let off = survey.left(row);
            let along = dot(off, beam);
            let across = norm(&add(off, scale(-along, beam)));
            (along / range_mm).powi(2) + (across / (angle_rad * distance)).powi(2)
        })
        .sum();
    let after = &json["after"];
    let dof = json["residual"]["dof"].as_f64().expect("degrees of freedom");
    let printed = after["chi2_per_dof"].as_f64().expect("the noise was declared") * dof;
    assert!(
        (chi2 - printed).abs() < 2.0 * AGREEMENT * printed,
        "{}: χ² is {chi2:e} with what was printed applied, and said to be {printed:e}",
        folder.name()
    );
}

/// One survey, and what was found of it.
struct Survey<'a> {
    json: &'a Value,
    table: Table,
    bodies: Table,
    origin: [f64; 3],
    direction: [f64; 3],
    letter: String,
    /// Hours, or share of the run where no time was recorded.
    time: Vec<f64>,
}

impl<'a> Survey<'a> {
    fn new(folder: &Folder, json: &'a Value) -> Self {
        let document = folder.document();
        let axis = &document["axis"];
        let triple = |key: &str| -> [f64; 3] {
            let list = axis[key].as_array().expect("three numbers");
            std::array::from_fn(|k| list[k].as_float().expect("a number with a point"))
        };
        let table = folder.table("targets.csv");
        let time = if table.has("time_s") {
            let time_s = table.numbers("time_s");
            let first = time_s.iter().copied().fold(f64::INFINITY, f64::min);
            time_s.iter().map(|t| (t - first) / 3600.0).collect()
        } else {
            let last = as_f64(table.rows() - 1);
            (0..table.rows()).map(|row| as_f64(row) / last).collect()
        };
        let direction = triple("direction");
        Self {
            json,
            origin: triple("origin_mm"),
            direction: scale(1.0 / norm(&direction), direction),
            letter: axis["letter"].as_str().expect("a letter").to_owned(),
            bodies: folder.table("mounts.csv"),
            table,
            time,
        }
    }

    fn text(&self, column: &str, row: usize) -> &str {
        &self.table.texts(column)[row]
    }

    fn measured(&self, row: usize) -> [f64; 3] {
        AXES.map(|axis| self.table.numbers(&format!("{axis}_mm"))[row])
    }

    fn own<'v>(&'v self, list: &str, key: &str, name: &str) -> &'v Value {
        let all = self.json["estimates"][list].as_array().expect("a list");
        all.iter().find(|one| one[key] == name).expect("every name is printed")
    }

    fn angle_rad(&self, row: usize) -> f64 {
        self.table.numbers("angle_deg")[row].to_radians()
    }

    /// 1 where the axis came with rising angles, −1 with falling ones.
    fn way(&self, row: usize) -> f64 {
        if self.table.has("direction") { self.table.numbers("direction")[row] } else { 1.0 }
    }

    fn six(&self, row: usize) -> ([f64; 3], [f64; 3]) {
        let angle_deg = self.table.numbers("angle_deg")[row];
        let all = self.json["estimates"]["axis_errors"].as_array().expect("errors");
        let is_own =
            |e: &&Value| (e["angle_deg"].as_f64().expect("a number") - angle_deg).abs() < 1e-8;
        let own = all.iter().find(is_own).expect("errors of every angle");
        let six = ERRORS.map(|name| own[name].as_f64().expect("an error"));
        ([six[0], six[1], six[2]], [six[3], six[4], six[5]])
    }

    /// Predicted less measured point, frame of the station.
    fn left(&self, row: usize) -> [f64; 3] {
        let json = self.json;
        let (station, mount) = (self.text("station", row), self.text("mount", row));
        let pose = self.own("stations", "station", station);
        let place =
            |of: &Value| AXES.map(|axis| of[format!("{axis}_mm")].as_f64().expect("a number"));
        let rotation: [[f64; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| pose["rotation"][i][j].as_f64().expect("a rotation"))
        });
        let to_station = |v: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|j| (0..3).map(|i| rotation[i][j] * v[i]).sum())
        };
        let body = place(self.own("mounts", "mount", mount));
        let (moved, turned) = self.six(row);
        let turn = |v: [f64; 3]| {
            let size = norm(&turned);
            let nominal = rotate(self.direction, self.angle_rad(row), v);
            if size > 0.0 { rotate(scale(1.0 / size, turned), size, nominal) } else { nominal }
        };
        let arm = turn(body);
        let beam = add(add(self.origin, add(moved, arm)), scale(-1.0, place(pose)));
        let predicted = to_station(beam);
        let mut off = add(predicted, scale(-1.0, self.measured(row)));
        // Small motions in the machine's frame.
        let mut machine = self.body_motion(row, body, turn);
        if let Some(play) = step(json, "backlash", None) {
            let half = 0.5 * self.way(row);
            let of = |names: [&str; 3], factor: f64| {
                names.map(|n| half * factor * amplitude(play, &format!("E{n}{}", self.letter)))
            };
            machine = add(machine, of(["X", "Y", "Z"], 1e-3));
            machine = add(machine, cross(of(["A", "B", "C"], 1e-6), arm));
        }
        for (subject, slip) in subjects(json, "mount-slip") {
            let (slipped, rest) = subject.split_once(" at ").expect("of a reflector at a step");
            let (at, by) = rest.split_once(" from ").expect("seen from a station");
            let is_from = |&r: &usize| {
                let here = [("mount", slipped), ("step", at), ("station", by)];
                here.iter().all(|(column, name)| self.text(column, r) == *name)
            };
            let from = (0..self.table.rows()).find(is_from).expect("the step was measured");
            if slipped == mount && row >= from {
                machine = add(machine, turn(AXES.map(|axis| 1e-3 * amplitude(slip, axis))));
            }
        }
        for (subject, shift) in subjects(json, "session-shift") {
            let first = subject.strip_prefix("from ").and_then(|s| s.strip_suffix(" on"));
            let (lock, at) = first.and_then(|f| f.split_once(" at ")).expect("of a lock at a step");
            let (by, seen) = lock.split_once('-').expect("of a station and a reflector");
            if self.has_begun(row, by, seen, at) {
                machine = add(machine, AXES.map(|axis| 1e-3 * amplitude(shift, axis)));
                let turned = ["a", "b", "c"].map(|c| 1e-6 * amplitude(shift, c));
                machine = add(machine, cross(turned, arm));
            }
        }
        for (subject, shift) in subjects(json, "station-shift") {
            let from = subject.strip_suffix(" on").and_then(|s| s.split_once(" from "));
            let (own, first) = from.expect("of a station from a reading on");
            let (seen, at) = first.split_once(" at ").expect("of a reflector at a step");
            if own == station && self.has_begun(row, own, seen, at) {
                machine = add(machine, AXES.map(|axis| -1e-3 * amplitude(shift, axis)));
                let turned = ["a", "b", "c"].map(|c| 1e-6 * amplitude(shift, c));
                machine = add(machine, cross(beam, turned));
            }
        }
        if let Some(drift) = step(json, "station-drift", Some(station)) {
            let own = (0..self.table.rows()).filter(|&r| self.text("station", r) == station);
            let first = own.map(|r| self.time[r]).fold(f64::INFINITY, f64::min);
            let since = self.time[row] - first;
            let of = |names: [&str; 3], factor: f64| {
                names.map(|name| since * factor * amplitude(drift, name))
            };
            machine = add(machine, scale(-1.0, of(AXES, 1e-3)));
            machine = add(machine, cross(beam, of(["a", "b", "c"], 1e-6)));
        }
        off = add(off, to_station(machine));
        let longer = |id: &str, subject: Option<&str>| {
            step(json, id, subject).map_or(0.0, |s| 1e-6 * amplitude(s, "scale"))
        };
        let mut share = longer("range-scale", None) + longer("bad-station", Some(station));
        for column in self.table.ending("_c") {
            let excess_k = self.table.numbers(&column)[row] - 20.0;
            share += excess_k * longer("temperature", Some(&column));
        }
        off = add(off, scale(share, predicted));
        let here = format!("{mount} at {} from {station}", self.text("step", row));
        if let Some(bad) = step(json, "bad-point", Some(&here)) {
            off = add(off, AXES.map(|axis| 1e-3 * amplitude(bad, axis)));
        }
        off
    }

    /// Whether a row was read when that of a reflector at a step by a station was, or later.
    fn has_begun(&self, row: usize, station: &str, mount: &str, at: &str) -> bool {
        let is_first = |&r: &usize| {
            let named = [("station", station), ("mount", mount), ("step", at)];
            named.iter().all(|(column, name)| self.text(column, r) == *name)
        };
        let first = (0..self.table.rows()).find(is_first).expect("the step was measured");
        self.time[row] >= self.time[first]
    }

    /// What the reflectors of one body do against those of the first.
    fn body_motion(
        &self,
        row: usize,
        body: [f64; 3],
        turn: impl Fn([f64; 3]) -> [f64; 3],
    ) -> [f64; 3] {
        let mount = self.text("mount", row);
        let names = self.bodies.texts("mount");
        let at = names.iter().position(|name| name == mount).expect("of the table");
        let mut moved = [0.0; 3];
        if !self.bodies.has("body") {
            return moved;
        }
        let own = &self.bodies.texts("body")[at];
        let first_rad = self.angle_rad(0);
        for id in ["body-sag", "body-tilt"] {
            for (subject, found) in subjects(self.json, id) {
                let (name, wave) = subject.split_once(", ").expect("of a body with a wave");
                if name != own {
                    continue;
                }
                let wave = |angle: f64| if wave == "cosine" { angle.cos() } else { angle.sin() };
                let size = wave(self.angle_rad(row)) - wave(first_rad);
                let by = if id == "body-sag" {
                    AXES.map(|axis| 1e-3 * size * amplitude(found, axis))
                } else {
                    cross(["a", "b", "c"].map(|c| 1e-6 * size * amplitude(found, c)), body)
                };
                moved = add(moved, turn(by));
            }
        }
        moved
    }
}
