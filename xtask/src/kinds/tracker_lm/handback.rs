//! Stations, reflectors and the six errors of an axis, its tables, and what is left of every range.

use serde_json::Value;

use crate::generators::vector::{add, cross, dot, norm, rotate, scale};
use crate::handback::Left;
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{accepted, amplitude, close, comes_to_rest, settled, step, subjects};
use crate::kinds::tracker_lm::tracker_scenes::{EFFECTS, scenes};

#[test]
fn an_axis_as_printed_leaves_the_error_that_is_printed() {
    for folder in Folder::committed("tracker-lm").into_iter().filter(|f| f.has("ranges.csv")) {
        let json = close(&folder);
        assert_is(&folder, &json);
    }
}

#[test]
fn every_effect_on_ranges_is_in_what_is_printed() {
    let mut missing: Vec<&str> = EFFECTS.to_vec();
    for (name, files) in scenes() {
        let folder = Folder::written(&format!("tracker-lm/{name}"), &files);
        let json = close(&folder);
        assert_is(&folder, &json);
        let found = accepted(&json);
        missing.retain(|effect| !found.iter().any(|f| f.starts_with(effect)));
    }
    assert!(missing.is_empty(), "never accepted: {missing:?}");
}

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
pub(crate) const ERRORS: [&str; 6] =
    ["e_x_mm", "e_y_mm", "e_z_mm", "e_a_rad", "e_b_rad", "e_c_rad"];

/// Index of refraction that the shape of a prism's path is taken with.
const GLASS: f64 = 1.515;

/// Nearer to the axis than this, in mm, a reflector looks along it.
const ON_AXIS_MM: f64 = 1.0;

fn assert_is(folder: &Folder, json: &Value) {
    applied(folder, json).assert_is(&folder.name(), json);
}

/// One survey, and what was found of it.
struct Survey<'a> {
    json: &'a Value,
    table: Table,
    origin: [f64; 3],
    direction: [f64; 3],
    letter: String,
    /// Origin and direction of an axis that rides on the other one.
    second: Option<([f64; 3], [f64; 3])>,
    one_dead_path: bool,
    time: Vec<f64>,
    timed: bool,
}

impl<'a> Survey<'a> {
    fn new(folder: &Folder, json: &'a Value) -> Self {
        let document = folder.document();
        let axis = &document["axis"];
        let triple = |list: &toml::Value| -> [f64; 3] {
            let list = list.as_array().expect("three numbers");
            std::array::from_fn(|k| list[k].as_float().expect("a number with a point"))
        };
        // Along the axis of its letter where the case does not say.
        let line = |axis: &toml::Value| {
            let along = || match axis["letter"].as_str() {
                Some("A") => [1.0, 0.0, 0.0],
                Some("B") => [0.0, 1.0, 0.0],
                _ => [0.0, 0.0, 1.0],
            };
            let direction = axis.get("direction").map_or_else(along, triple);
            (triple(&axis["origin_mm"]), scale(1.0 / norm(&direction), direction))
        };
        let table = folder.table("ranges.csv");
        let timed = table.has("time_s");
        let time = if timed {
            let time_s = table.numbers("time_s");
            let first = time_s.iter().copied().fold(f64::INFINITY, f64::min);
            time_s.iter().map(|t| t - first).collect()
        } else {
            let last = crate::handback::as_f64(table.rows() - 1);
            (0..table.rows()).map(|row| crate::handback::as_f64(row) / last).collect()
        };
        let (origin, direction) = line(axis);
        let dead_path = document.get("model").and_then(|m| m.get("dead_path"));
        Self {
            json,
            origin,
            direction,
            second: document.get("second_axis").map(line),
            letter: axis["letter"].as_str().expect("a letter").to_owned(),
            one_dead_path: dead_path.is_some_and(|name| name.as_str() == Some("station")),
            table,
            time,
            timed,
        }
    }

    fn text(&self, column: &str, row: usize) -> &str {
        &self.table.texts(column)[row]
    }

    fn place(&self, list: &str, key: &str, name: &str) -> [f64; 3] {
        let all = self.json["estimates"][list].as_array().expect("a list");
        let own = all.iter().find(|one| one[key] == name).expect("every name is printed");
        AXES.map(|axis| own[format!("{axis}_mm")].as_f64().expect("a coordinate"))
    }

    fn lock(&self, row: usize) -> (String, String) {
        let mount = if self.one_dead_path { "" } else { self.text("mount", row) };
        (self.text("station", row).to_owned(), mount.to_owned())
    }

    /// Displacement and rotation of the axis at the angle of a row.
    fn error(&self, row: usize) -> ([f64; 3], [f64; 3]) {
        let estimates = &self.json["estimates"];
        let (all, angle) = if self.turns_second(row) {
            (&estimates["second_axis"]["axis_errors"], self.table.numbers("second_angle_deg")[row])
        } else {
            (&estimates["axis_errors"], self.table.numbers("angle_deg")[row])
        };
        let all = all.as_array().expect("errors");
        let is_own = |e: &&Value| (e["angle_deg"].as_f64().expect("an angle") - angle).abs() < 1e-8;
        let own = all.iter().find(is_own).expect("errors of every angle");
        let six = ERRORS.map(|name| own[name].as_f64().expect("an error"));
        let (mut moved, mut turned) = ([six[0], six[1], six[2]], [six[3], six[4], six[5]]);
        if let Some(play) = step(self.json, "backlash", None) {
            let half = 0.5 * self.way(row);
            for (k, name) in ["X", "Y", "Z"].iter().enumerate() {
                moved[k] += half * 1e-3 * amplitude(play, &format!("E{name}{}", self.letter));
            }
            for (k, name) in ["A", "B", "C"].iter().enumerate() {
                turned[k] += half * 1e-6 * amplitude(play, &format!("E{name}{}", self.letter));
            }
        }
        for (subject, shift) in subjects(self.json, "session-shift") {
            let first = subject.strip_prefix("from ").and_then(|s| s.strip_suffix(" on"));
            let (lock, at) = first.and_then(|f| f.split_once(" at ")).expect("of a lock at a step");
            let (station, mount) = lock.split_once('-').expect("of a station and a reflector");
            if self.has_begun(row, station, mount, at) {
                moved = add(moved, AXES.map(|axis| 1e-3 * amplitude(shift, axis)));
                turned = add(turned, ["a", "b", "c"].map(|c| 1e-6 * amplitude(shift, c)));
            }
        }
        (moved, turned)
    }

    /// Whether the second of two axes is away from where it stands.
    fn turns_second(&self, row: usize) -> bool {
        self.second.is_some()
            && (self.table.numbers("second_angle_deg")[row]
                - stands(&self.json["estimates"]["second_axis"]))
            .abs()
                > 1e-8
    }

    /// Directions and angles of the rotations that take the body of a row to where it is without errors, in
    /// the order applied.
    fn turns(&self, row: usize) -> Vec<([f64; 3], f64)> {
        let angle = |column: &str| self.table.numbers(column)[row].to_radians();
        let Some((_, along)) = self.second else {
            return vec![(self.direction, angle("angle_deg"))];
        };
        let since = angle("angle_deg") - stands(&self.json["estimates"]).to_radians();
        vec![(along, angle("second_angle_deg")), (self.direction, since)]
    }

    /// The point that errors move, and the reflector from there without them.
    fn nominal(&self, row: usize, body: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let turns = self.turns(row);
        let arm = rotate(turns[0].0, turns[0].1, body);
        match self.second {
            None => (self.origin, arm),
            Some((origin, _)) if self.turns_second(row) => (origin, arm),
            Some((origin, _)) => {
                let from_first = add(add(origin, scale(-1.0, self.origin)), arm);
                (self.origin, rotate(turns[1].0, turns[1].1, from_first))
            }
        }
    }

    /// 1 where the axis came with rising angles, −1 with falling ones.
    fn way(&self, row: usize) -> f64 {
        if self.table.has("direction") {
            return self.table.numbers("direction")[row];
        }
        let angles = self.table.numbers("angle_deg");
        let before = (0..row).rev().find(|&r| angles[r].to_bits() != angles[row].to_bits());
        if before.is_none_or(|r| angles[r] < angles[row]) { 1.0 } else { -1.0 }
    }

    /// Row at which a change begins, of the rows that `is_own` takes.
    fn from(&self, step: &str, is_own: impl Fn(usize) -> bool) -> usize {
        let at = |&row: &usize| is_own(row) && self.text("step", row) == step;
        (0..self.table.rows()).find(at).expect("the step was measured")
    }

    /// Station, and target from it, of a row: where both are by what is printed.
    fn sight(&self, row: usize) -> Sight {
        let mount = self.text("mount", row);
        let mut body = self.place("mounts", "mount", mount);
        for (subject, slip) in subjects(self.json, "mount-slip") {
            let (slipped, rest) = subject.split_once(" at ").expect("of a reflector at a step");
            let (at, station) = rest.split_once(" from ").expect("seen from a station");
            let seen =
                |r: usize| self.text("mount", r) == slipped && self.text("station", r) == station;
            if slipped == mount && row >= self.from(at, seen) {
                body = add(body, AXES.map(|axis| 1e-3 * amplitude(slip, axis)));
            }
        }
        let name = self.text("station", row);
        let mut station = self.place("stations", "station", name);
        for (subject, since) in
            [(None, self.since_middle(row)), (Some(name), self.since_first(row))]
        {
            if let Some(drift) = step(self.json, "station-drift", subject) {
                let come = AXES.map(|axis| amplitude(drift, axis));
                let share = if comes_to_rest(drift) {
                    self.settled(drift, row, subject.is_some())
                } else {
                    since / if self.timed { 3600.0 } else { 1.0 }
                };
                station = add(station, scale(share, come));
            }
        }
        for (subject, shift) in subjects(self.json, "station-shift") {
            let from = subject.strip_suffix(" on").and_then(|s| s.split_once(" from "));
            let (own, first) = from.expect("of a station from a reading on");
            let (mount, at) = first.split_once(" at ").expect("of a reflector at a step");
            if own == name && self.has_begun(row, own, mount, at) {
                station = add(station, AXES.map(|axis| 1e-3 * amplitude(shift, axis)));
            }
        }
        let (moved, turned) = self.error(row);
        let (pivot, mut arm) = self.nominal(row, body);
        let size = norm(&turned);
        if size > 0.0 {
            arm = rotate(scale(1.0 / size, turned), size, arm);
        }
        let beam = add(add(pivot, add(moved, arm)), scale(-1.0, station));
        let length = norm(&beam);
        // The beam as the reflector sees it.
        let mut seen = scale(1.0 / length, beam);
        if size > 0.0 {
            seen = rotate(scale(1.0 / size, turned), -size, seen);
        }
        for (along, angle) in self.turns(row).into_iter().rev() {
            seen = rotate(along, -angle, seen);
        }
        let carrier = self.second.map_or(self.direction, |(_, along)| along);
        let radial = cross(cross(carrier, body), carrier);
        let looks =
            if norm(&radial) > ON_AXIS_MM { scale(1.0 / norm(&radial), radial) } else { carrier };
        Sight { length, cosine: dot(seen, looks).abs().min(1.0) }
    }

    /// What the tracer's readings are longer by, without a constant of the dead path.
    fn reading(&self, row: usize, sight: &Sight) -> f64 {
        let json = self.json;
        let read = self.table.numbers("displacement_mm")[row];
        let station = self.text("station", row);
        let size = |id: &str, subject: Option<&str>, name: &str| {
            step(json, id, subject).map_or(0.0, |s| amplitude(s, name))
        };
        let mut longer = 1e-6
            * read
            * (size("range-scale", None, "scale") + size("bad-station", Some(station), "scale"));
        for column in self.table.ending("_c") {
            let excess_k = self.table.numbers(&column)[row] - 20.0;
            let size = |name: &str| size("temperature", Some(&column), name);
            let dead = sight.length - read;
            longer += 1e-6 * excess_k * (read * size("scale") + dead * size("of dead path"));
        }
        if let Some(drift) = step(json, "scale-drift", None) {
            let passed = self.time[row] - self.time.iter().copied().fold(f64::INFINITY, f64::min);
            let come = if comes_to_rest(drift) {
                settled(drift, passed, false, 2)
            } else {
                passed / if self.timed { 3600.0 } else { 1.0 }
            };
            let dead = sight.length - read;
            let along = read * amplitude(drift, "scale") + dead * amplitude(drift, "of dead path");
            longer += 1e-6 * come * along;
        }
        let hours = self.since_lock_on(row) / if self.timed { 3600.0 } else { 1.0 };
        longer += hours * size("range-drift", None, "rate at lock-on")
            + hours * hours * size("range-drift", None, "half the change of rate")
            + hours * size("range-drift", Some(station), "rate");
        let square = 1.0 - sight.cosine * sight.cosine;
        let path = |c: f64| (GLASS * GLASS - 1.0 + c * c).sqrt() - c;
        let prism = (path(sight.cosine) - path(1.0)) / (path(0.0) - path(1.0));
        longer += 1e-3 * square * size("incidence", None, "at grazing incidence")
            + 1e-3 * (prism - square) * size("incidence", None, "of that, as a glass prism has it");
        for (subject, jump) in subjects(json, "dead-path-jump") {
            let (lock, at) = subject.split_once(" at ").expect("of a lock at a step");
            let is_own = |r: usize| {
                let of_lock = format!("{}-{}", self.text("station", r), self.text("mount", r));
                lock == of_lock || lock == self.text("station", r)
            };
            if is_own(row) && row >= self.from(at, is_own) {
                longer -= 1e-3 * amplitude(jump, "jump");
            }
        }
        longer
    }

    /// How far a stand has come that comes to rest: since the first reading of its own station, or,
    /// where all move, since that of the run, from the mean over those of its station on.
    fn settled(&self, drift: &Value, row: usize, is_alone: bool) -> f64 {
        let earliest =
            |rows: &[usize]| rows.iter().map(|&r| self.time[r]).fold(f64::INFINITY, f64::min);
        // Times are in seconds, or shares of the run.
        let come = |r: usize, start: f64| settled(drift, self.time[r] - start, false, 2);
        if is_alone {
            return come(row, earliest(&self.of_its_station(row)));
        }
        let start = earliest(&(0..self.table.rows()).collect::<Vec<_>>());
        self.about_middle(row, |r| come(r, start))
    }

    fn since_middle(&self, row: usize) -> f64 {
        self.about_middle(row, |r| self.time[r])
    }

    /// Time since the first reading from the station of a row.
    fn since_first(&self, row: usize) -> f64 {
        let own = self.of_its_station(row).into_iter();
        self.time[row] - own.map(|r| self.time[r]).fold(f64::INFINITY, f64::min)
    }

    /// Whether a row was read when that of a reflector at a step by a station was, or later.
    fn has_begun(&self, row: usize, station: &str, mount: &str, at: &str) -> bool {
        let seen = |r: usize| self.text("mount", r) == mount && self.text("station", r) == station;
        self.time[row] >= self.time[self.from(at, seen)]
    }

    /// A value from its mean over the rows of the station on.
    fn about_middle(&self, row: usize, value: impl Fn(usize) -> f64) -> f64 {
        let rows = self.of_its_station(row);
        let sum: f64 = rows.iter().map(|&r| value(r)).sum();
        value(row) - sum / crate::handback::as_f64(rows.len())
    }

    /// Rows of the station that measured one.
    fn of_its_station(&self, row: usize) -> Vec<usize> {
        let is_own = |&r: &usize| self.text("station", r) == self.text("station", row);
        (0..self.table.rows()).filter(is_own).collect()
    }

    fn since_lock_on(&self, row: usize) -> f64 {
        let own = |&r: &usize| {
            self.text("station", r) == self.text("station", row)
                && self.text("mount", r) == self.text("mount", row)
        };
        let rows = (0..self.table.rows()).filter(own);
        self.time[row] - rows.map(|r| self.time[r]).fold(f64::INFINITY, f64::min)
    }
}

/// Where an axis of two stands while the other one turns: its errors begin there.
fn stands(errors: &Value) -> f64 {
    errors["axis_errors"][0]["angle_deg"].as_f64().expect("an angle")
}

/// One line of sight.
struct Sight {
    length: f64,
    /// Between the beam and where the reflector looks.
    cosine: f64,
}

/// `|P − S| − displacement + effects` less the dead path; what of it the six errors of every angle
/// after the first take up is in none of the rows that are judged.
fn applied(folder: &Folder, json: &Value) -> Left {
    let survey = Survey::new(folder, json);
    let rows = survey.table.rows();
    let read = survey.table.numbers("displacement_mm");
    let sights: Vec<Sight> = (0..rows).map(|row| survey.sight(row)).collect();
    let off: Vec<f64> = (0..rows)
        .map(|row| sights[row].length - read[row] + survey.reading(row, &sights[row]))
        .collect();
    let locks: Vec<_> = (0..rows).map(|row| survey.lock(row)).collect();
    let dead_path = |row: usize| {
        let own: Vec<f64> = (0..rows).filter(|&r| locks[r] == locks[row]).map(|r| off[r]).collect();
        own.iter().sum::<f64>() / crate::handback::as_f64(own.len())
    };
    let squares: f64 = (0..rows).map(|row| (off[row] - dead_path(row)).powi(2)).sum();
    let estimates = &json["estimates"];
    // None of the first angle of an axis, where its errors are zero.
    let free = |of: &Value| of["axis_errors"].as_array().map_or(0, |errors| errors.len() - 1);
    let judged = rows - 6 * (free(estimates) + free(&estimates["second_axis"]));
    Left {
        fitted: vec![vec![(squares / crate::handback::as_f64(judged)).sqrt()]],
        checked: Vec::new(),
        scale: sights.iter().map(|s| s.length).fold(0.0, f64::max),
    }
}
