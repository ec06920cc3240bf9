//! What the declared model leaves out: the catalogue of effects.
//!
//! A column is `∂u/∂amplitude` of `u = |P − S| − (l + L)` with the shared parameters and the six
//! errors fixed. An amplitude of the tracer's readings is positive where it reads too long.

use std::collections::HashMap;

use model_discrepancy::{Covariate, Effect, Parameter, Quantity, Scope};
use nalgebra::DMatrix;

use crate::count::count;
use crate::missing::change::{Change, Offered};
use crate::missing::course::{self, Course};
use crate::missing::courses::{Courses, part, seen, ways_mm};
use crate::missing::moves::{Moves, Part};
use crate::missing::reduction::of_ranges;
use crate::missing::session::Session;
use crate::missing::sights::Sight;
use crate::{Approach, Range, Step, Survey};

/// Reference temperature of length, ISO 1.
pub(crate) const REFERENCE_C: f64 = 20.0;

/// A wavelength is off by parts in a million; by this much it is another unit, or readings that stand still.
const NO_WAVELENGTH: f64 = 0.01;
/// The same of one station alone.
const NO_STATION: f64 = 0.1;

/// An effect as the loop sees it, and what it does to every range.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) effect: Effect,
    /// One row per range, one column per amplitude, mm.
    pub(crate) columns: DMatrix<f64>,
    /// What the amplitudes move, where they are not of the readings.
    pub(crate) moves: Option<Moves>,
}

/// What the catalogue is made from.
pub(crate) struct Scene<'a> {
    pub(crate) survey: &'a Survey,
    /// Geometry of every range.
    pub(crate) sights: &'a [Sight],
    /// Time of every range: seconds, or share of the run where no time was recorded.
    pub(crate) time: &'a [f64],
    /// Whether `time` is in seconds.
    pub(crate) timed: bool,
    /// One value per range.
    pub(crate) covariates: &'a [Covariate],
    /// Way that the axis came to every step.
    pub(crate) approaches: &'a [Approach],
    /// Whether the axis is taken for perfect.
    pub(crate) is_perfect: bool,
    /// Dead path of every range.
    pub(crate) dead_path_of: &'a [usize],
    /// How stands move.
    pub(crate) courses: &'a Courses,
}

/// The catalogue: effects of the whole run, then changes at the given steps.
pub(crate) fn catalogue(scene: &Scene<'_>, changes: &[Offered]) -> Vec<Entry> {
    let n_stations = scene.survey.stations.len();
    let mut entries = vec![range_scale(scene), scale_drift(scene), range_drift(scene)];
    // Of two axes the one that stands keeps the side that it came from last, which is in the errors of
    // the other one.
    entries.extend(scene.survey.second.is_none().then(|| backlash(scene)));
    entries.push(incidence(scene));
    entries.extend((0..n_stations).map(|i| range_drift_alone(scene, i)));
    entries.extend((0..n_stations).map(|i| station_drift(scene, i)));
    entries.extend((n_stations > 1).then(|| common_drift(scene)));
    entries.extend((0..n_stations).map(|i| bad_station(scene, i)));
    entries.extend(scene.courses.sessions.iter().map(|session| another_session(scene, session)));
    entries.extend(temperatures(scene));
    entries.extend(changes.iter().map(|offered| {
        let mut entry = changed(scene, offered.change);
        entry.effect.searched = offered.searched;
        entry
    }));
    entries
}

impl Scene<'_> {
    fn entry(
        &self,
        id: &str,
        subject: Option<String>,
        description: String,
        parameters: Vec<Parameter>,
        column: impl Fn(usize) -> Vec<f64>,
    ) -> Entry {
        // Angles met from one side, and stations that see little, show nothing of some.
        let scope = Scope::SomeDesigns;
        let columns = of_ranges(self.survey.ranges.len(), parameters.len(), column);
        let effect = Effect { subject, scope, description, ..Effect::new(id, "", parameters) };
        Entry { effect, columns, moves: None }
    }

    /// An effect on the geometry: one unit moves its part of every range by `share`.
    fn entry_that_moves(
        &self,
        id: &str,
        subject: Option<String>,
        description: String,
        parameters: Vec<Parameter>,
        (part, share): (Part, impl Fn(usize) -> f64),
    ) -> Entry {
        let moves = Moves { part, share: (0..self.survey.ranges.len()).map(share).collect() };
        let column = |r: usize| {
            let slopes = part.slopes(&self.sights[r]);
            slopes.iter().map(|slope| moves.share[r] * slope).collect()
        };
        let entry = self.entry(id, subject, description, parameters, column);
        Entry { moves: Some(moves), ..entry }
    }

    /// An effect on the readings, from the mean over each dead path on: the mean is the dead path's,
    /// and says nothing of how much of the effect can be seen.
    fn entry_of_readings<const N: usize>(
        &self,
        id: &str,
        subject: Option<String>,
        description: String,
        parameters: &[Parameter; N],
        columns: impl Fn(usize) -> [f64; N],
    ) -> Entry {
        let n_paths = self.dead_path_of.iter().max().map_or(0, |last| last + 1);
        let mut sums = vec![([0.0; N], 0.0); n_paths];
        for (range, &path) in self.dead_path_of.iter().enumerate() {
            let (sum, n) = &mut sums[path];
            *n += 1.0;
            for (sum, value) in sum.iter_mut().zip(columns(range)) {
                *sum += value;
            }
        }
        self.entry(id, subject, description, parameters.to_vec(), |r| {
            let (sum, n) = &sums[self.dead_path_of[r]];
            columns(r).iter().zip(sum).map(|(value, sum)| value - sum / n).collect()
        })
    }

    fn displacement_mm(&self, range: usize) -> f64 {
        self.survey.ranges[range].displacement_mm
    }

    /// The way of the light to the target that was counted, and that which was not.
    fn ways_mm(&self, range: usize) -> [f64; 2] {
        ways_mm(self.survey, &self.sights[range], range)
    }

    /// Time of every range since the first one of its lock.
    fn since_lock_on(&self) -> Vec<f64> {
        let mut locked = HashMap::new();
        for (range, time) in self.survey.ranges.iter().zip(self.time) {
            let first = locked.entry((range.station, range.mount)).or_insert(*time);
            *first = first.min(*time);
        }
        let since = |(range, time): (&Range, &f64)| time - locked[&(range.station, range.mount)];
        self.survey.ranges.iter().zip(self.time).map(since).collect()
    }

    /// Law of a course that comes to rest.
    fn law(&self, course: &Course) -> Option<String> {
        course.law(if self.timed { "s" } else { "of the run" })
    }

    /// Unit and factor of something per unit of time.
    fn rate(&self) -> (&'static str, f64) {
        if self.timed { ("mm/h", 3600.0) } else { ("mm over the run", 1.0) }
    }

    /// Unit and factor of a proportion per unit of time.
    fn rate_of_scale(&self) -> (&'static str, f64) {
        if self.timed { ("ppm/h", 1e6 * 3600.0) } else { ("ppm over the run", 1e6) }
    }

    /// Unit and factor of something per unit of time squared.
    fn change_of_rate(&self) -> (&'static str, f64) {
        if self.timed { ("mm/h²", 3600.0 * 3600.0) } else { ("mm over the run", 1.0) }
    }
}

pub(crate) fn parameter(name: &str, unit: &str, report_factor: f64) -> Parameter {
    Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor }
}

pub(crate) fn coordinates(unit: &str, report_factor: f64) -> Vec<Parameter> {
    ["x", "y", "z"].iter().map(|name| parameter(name, unit, report_factor)).collect()
}

fn range_scale(scene: &Scene<'_>) -> Entry {
    let text = "the tracer reads displacements too long in proportion: its wavelength is off";
    let scale = parameter("scale", "ppm", 1e6);
    let mut entry = scene.entry_of_readings("range-scale", None, text.to_owned(), &[scale], |r| {
        [scene.displacement_mm(r)]
    });
    entry.effect.maximum = Some(NO_WAVELENGTH);
    entry
}

/// The wavelength drifts: a laser warms up, or air of which no column has the temperature; along the
/// displacement and along the dead path, as with a [temperature](temperatures).
fn scale_drift(scene: &Scene<'_>) -> Entry {
    let course = &scene.courses.of_scale;
    let law = scene.law(course);
    let (unit, factor) = if law.is_some() { ("ppm", 1e6) } else { scene.rate_of_scale() };
    let rest = law.map_or_else(String::new, |law| format!(" and comes to rest: {law}"));
    let text = format!(
        "displacements and dead paths read too long in a proportion that drifts, as the wavelength does \
         when a laser or the air warms up{rest}"
    );
    let parameters = ["scale", "of dead path"].map(|name| parameter(name, unit, factor));
    let share = course::of_readings(&seen(scene.survey, scene.time), course);
    let mut entry = scene.entry_of_readings("scale-drift", None, text, &parameters, |r| {
        scene.ways_mm(r).map(|mm| mm * share[r])
    });
    entry.effect.searched = course.searched;
    entry
}

/// Of all readings, as one tracer goes from station to station: it warms up and settles, so that the
/// rate may change.
fn range_drift(scene: &Scene<'_>) -> Entry {
    let text = "the reading drifts while the tracer stays locked on";
    let (unit, factor) = scene.rate();
    let (unit_of_change, factor_of_change) = scene.change_of_rate();
    let parameters = [
        parameter("rate at lock-on", unit, factor),
        parameter("half the change of rate", unit_of_change, factor_of_change),
    ];
    let locked = scene.since_lock_on();
    scene.entry_of_readings("range-drift", None, text.to_owned(), &parameters, |r| {
        [locked[r], locked[r].powi(2)]
    })
}

/// Of one station's tracer, steadily: with a rate that changes it would imitate a station that moves
/// along its beams.
fn range_drift_alone(scene: &Scene<'_>, station: usize) -> Entry {
    let name = &scene.survey.stations[station].name;
    let text = format!("the reading from station {name} alone drifts while it is locked on");
    let (unit, factor) = scene.rate();
    let rate = parameter("rate", unit, factor);
    let locked = scene.since_lock_on();
    scene.entry_of_readings("range-drift", Some(name.clone()), text, &[rate], |r| {
        [if scene.survey.ranges[r].station == station { locked[r] } else { 0.0 }]
    })
}

/// Half of the difference between coming with rising and with falling angles, error by error.
fn backlash(scene: &Scene<'_>) -> Entry {
    let text = "the axis stops elsewhere when it comes from the other side";
    let names = scene.survey.axis.letter.error_names();
    let parameters = (0..6)
        .map(|c| {
            if c < 3 {
                parameter(&names[c], "µm", 1e3)
            } else {
                parameter(&names[c], "µrad", 1e6)
            }
        })
        .collect();
    let way = |r: usize| match scene.approaches[scene.survey.ranges[r].step] {
        Approach::Positive => 0.5,
        Approach::Negative => -0.5,
    };
    let n = scene.survey.ranges.len();
    // What a perfect axis does at every reading alike is its place.
    let mean = if scene.is_perfect { (0..n).map(way).sum::<f64>() / count(n) } else { 0.0 };
    let half = |r: usize| way(r) - mean;
    scene.entry_that_moves("backlash", None, text.to_owned(), parameters, (Part::Error, half))
}

/// Path in the reflector that grows with the angle at which the beam meets it: with the square of the
/// sine, and beside it as a solid prism of glass makes it; the part linear in the direction is a
/// displacement of the reflector.
///
/// A prism of height h is √(n² − sin²) − cos of h long to a beam. That alone goes by a shape with
/// powers of the sine beyond the square, half as large, which left out move the axis' errors.
fn incidence(scene: &Scene<'_>) -> Entry {
    let text = "the reflector lengthens a beam that meets it at an angle to its axis, which is \
                taken to point away from the rotary axis";
    let parameters = [
        parameter("at grazing incidence", "µm", 1e3),
        parameter("of that, as a glass prism has it", "µm", 1e3),
    ];
    scene.entry_of_readings("incidence", None, text.to_owned(), &parameters, |r| {
        let cosine = scene.sights[r].cosine.abs().min(1.0);
        let square = 1.0 - cosine * cosine;
        [square, prism(cosine) - square]
    })
}

/// Index of refraction of crown glass at 633 nm; the shape hardly depends on it.
const GLASS_INDEX: f64 = 1.515;

/// Path in a glass prism beyond that of a beam along its axis, over that at grazing incidence.
fn prism(cosine: f64) -> f64 {
    let path = |cosine: f64| (GLASS_INDEX.powi(2) - 1.0 + cosine * cosine).sqrt() - cosine;
    (path(cosine) - path(1.0)) / (path(0.0) - path(1.0))
}

fn station_drift(scene: &Scene<'_>, station: usize) -> Entry {
    let name = &scene.survey.stations[station].name;
    let course = &scene.courses.of_station[station];
    let share = course::of_station(&seen(scene.survey, scene.time), station, course);
    drift(scene, Some(name.clone()), |law| course::words(name, law), course, &share)
}

/// Of all stands alike, or of the machine against them, as on a floor that warms up.
fn common_drift(scene: &Scene<'_>) -> Entry {
    let course = &scene.courses.of_all;
    let share = course::of_all(&seen(scene.survey, scene.time), course);
    let words = |rest: Option<String>| match rest {
        None => {
            "all stations move alike and steadily, or the machine moves against them; the place of \
                 each is that in the middle of its readings"
                .to_owned()
        }
        Some(rest) => format!(
            "all stations move alike and come to rest, or the machine moves against them; the place \
             of each is the mean over its readings: {rest}"
        ),
    };
    drift(scene, None, words, course, &share)
}

/// Stands that move along a course; `words` says so, with the law of one that comes to rest.
fn drift(
    scene: &Scene<'_>,
    subject: Option<String>,
    words: impl Fn(Option<String>) -> String,
    course: &Course,
    share: &[f64],
) -> Entry {
    let law = scene.law(course);
    let (unit, factor) = if law.is_some() { ("mm", 1.0) } else { scene.rate() };
    let parameters = coordinates(unit, factor);
    let moves = (Part::Station, |r: usize| share[r]);
    let mut entry = scene.entry_that_moves("station-drift", subject, words(law), parameters, moves);
    entry.effect.searched = course.searched;
    entry
}

/// From some reading on the machine, or one stand, is elsewhere: another session, or a stand that was
/// knocked.
fn another_session(scene: &Scene<'_>, session: &Session) -> Entry {
    let survey = scene.survey;
    let first = &survey.ranges[session.first];
    let station = &survey.stations[first.station].name;
    let (mount, step) = (&survey.mounts[first.mount].name, &survey.steps[first.step].name);
    let (id, subject, text) = session.named([station, mount, step]);
    let since = session.share(&seen(survey, scene.time));
    let moves = (part(session.moving()), |r: usize| since[r]);
    let parameters = match session.station {
        Some(_) => coordinates("µm", 1e3),
        None => motion(["µm", "µrad"], str::to_owned),
    };
    let mut entry = scene.entry_that_moves(id, Some(subject), text, parameters, moves);
    entry.effect.searched = session.searched;
    entry
}

/// Displacement and rotation, coordinate by coordinate.
pub(crate) fn motion([mm, rad]: [&str; 2], name: impl Fn(&str) -> String) -> Vec<Parameter> {
    let one = |(c, of): (usize, &&str)| {
        let (unit, factor) = if c < 3 { (mm, 1e3) } else { (rad, 1e6) };
        parameter(&name(of), unit, factor)
    };
    ["x", "y", "z", "a", "b", "c"].iter().enumerate().map(one).collect()
}

fn bad_station(scene: &Scene<'_>, station: usize) -> Entry {
    let name = &scene.survey.stations[station].name;
    let text = format!("readings from station {name} alone are too long in proportion");
    let scale = parameter("scale", "ppm", 1e6);
    let mut entry =
        scene.entry_of_readings("bad-station", Some(name.clone()), text, &[scale], |r| {
            let is_own = scene.survey.ranges[r].station == station;
            [if is_own { scene.displacement_mm(r) } else { 0.0 }]
        });
    entry.effect.maximum = Some(NO_STATION);
    entry
}

/// The wavelength follows the temperature of the air, about −1 ppm/K uncorrected: along the displacement,
/// and along the dead path, which an instrument may know less well than what it has counted.
fn temperatures(scene: &Scene<'_>) -> Vec<Entry> {
    let columns = scene.covariates.iter().filter(|c| c.quantity == Quantity::Temperature);
    columns
        .map(|column| {
            let text = format!(
                "displacements read too long in proportion to {} from {REFERENCE_C} °C, and by their \
                 dead paths as these do",
                column.name
            );
            let parameters =
                ["scale", "of dead path"].map(|name| parameter(name, "ppm/K", 1e6));
            let subject = Some(column.name.clone());
            let mut entry =
                scene.entry_of_readings("temperature", subject, text, &parameters, |r| {
                    let excess_k = column.values[r] - REFERENCE_C;
                    scene.ways_mm(r).map(|mm| mm * excess_k)
                });
            entry.effect.driver = Some(column.name.clone());
            entry
        })
        .collect()
}

fn changed(scene: &Scene<'_>, change: Change) -> Entry {
    let survey = scene.survey;
    let from = match change {
        Change::DeadPath { range, .. }
        | Change::Mount { range, .. }
        | Change::Reading { range } => &survey.ranges[range],
    };
    let station_name = &survey.stations[from.station].name;
    let at = &survey.steps[from.step].name;
    match change {
        Change::DeadPath { mount, .. } => {
            let lock = mount.map_or_else(
                || station_name.clone(),
                |j| format!("{station_name}-{}", survey.mounts[j].name),
            );
            let text = format!("the dead path of {lock} jumps at step {at}: the beam was lost");
            let subject = Some(format!("{lock} at {at}"));
            let parameters = vec![parameter("jump", "µm", 1e3)];
            scene.entry("dead-path-jump", subject, text, parameters, |r| {
                vec![-f64::from(u8::from(change.touches(survey, r)))]
            })
        }
        Change::Reading { .. } => {
            let lock = format!("{station_name}-{}", survey.mounts[from.mount].name);
            let text = format!("the range of {lock} at step {at} is off, unlike the others");
            let parameters = vec![parameter("off by", "µm", 1e3)];
            scene.entry("bad-point", Some(format!("{lock} at {at}")), text, parameters, |r| {
                vec![-f64::from(u8::from(change.touches(survey, r)))]
            })
        }
        Change::Mount { mount, .. } => {
            let name = &survey.mounts[mount].name;
            let text = format!(
                "reflector {name} slips in its mount before {station_name} sees it at step {at}"
            );
            let subject = Some(format!("{name} at {at} from {station_name}"));
            let slipped = |r: usize| f64::from(u8::from(change.touches(survey, r)));
            let parameters = coordinates("µm", 1e3);
            scene.entry_that_moves("mount-slip", subject, text, parameters, (Part::Mount, slipped))
        }
    }
}

/// Way that the axis came to every step: as recorded, else as the order of the steps shows it; to the first, and to those
/// at the angle of the one before, as it goes on.
pub(crate) fn approaches(steps: &[Step]) -> Vec<Approach> {
    let way = |from: usize, to: usize| match steps.get(to)?.angle_rad - steps[from].angle_rad {
        turned if turned > 0.0 => Some(Approach::Positive),
        turned if turned < 0.0 => Some(Approach::Negative),
        _ => None,
    };
    let mut last = Approach::Positive;
    let came = |(i, step): (usize, &Step)| {
        let before = i.checked_sub(1).and_then(|before| way(before, i));
        let seen = before.or_else(|| way(i, i + 1));
        last = step.approach.or(seen).unwrap_or(last);
        last
    };
    steps.iter().enumerate().map(came).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To the far end and back, the far end read twice: once from either side.
    #[test]
    fn a_step_at_the_angle_of_the_one_before_was_come_to_as_the_axis_goes_on() {
        let step = |angle_rad: f64| Step { name: String::new(), angle_rad, approach: None };
        let steps = [0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.5, 0.0].map(step);
        let [up, down] = [Approach::Positive, Approach::Negative];
        assert_eq!(approaches(&steps), [up, up, up, up, down, down, down, down]);
        // What is recorded goes before what the angles show.
        let mut said = steps.clone();
        said[4].approach = Some(up);
        assert_eq!(approaches(&said)[4], up);
    }
}
