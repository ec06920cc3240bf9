//! What the declared model leaves out, as columns of predicted minus measured point.
//!
//! An amplitude of the tracker's readings is positive where it reads too long.

use std::fmt;

use model_discrepancy::{Covariate, Effect, Parameter, Quantity, Scope};
use nalgebra::Vector3;

use super::TargetSurvey;
use super::faults::{Fault, seen};
use super::sight::Sight;
use crate::Approach;
use crate::count::count;
use crate::missing::effects::{REFERENCE_C, approaches, coordinates, motion, parameter};
use crate::missing::session::Session;

/// An effect as the loop sees it, and what it does to every reading.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) effect: Effect,
    /// By amplitude: three components per reading, mm.
    pub(super) columns: Vec<Vec<f64>>,
}

/// What the catalogue is made from.
pub(super) struct Scene<'a> {
    pub(super) survey: &'a TargetSurvey,
    pub(super) sights: &'a [Sight],
    /// Time of every reading: seconds, or share of the run where no time was recorded.
    pub(super) time: &'a [f64],
    /// Whether `time` is in seconds.
    pub(super) timed: bool,
    pub(super) covariates: &'a [Covariate],
    /// Whether the axis is taken for perfect.
    pub(super) is_perfect: bool,
    /// Body that each mount belongs to.
    pub(super) bodies: &'a [String],
}

/// The catalogue: effects of the whole run, then faults at the given readings.
pub(super) fn catalogue(scene: &Scene<'_>, faults: &[Fault]) -> Vec<Entry> {
    let n_stations = scene.survey.stations.len();
    let mut entries = vec![backlash(scene), range_scale(scene)];
    entries.extend(body_motions(scene));
    entries.extend((0..n_stations).map(|i| station_drift(scene, i)));
    if n_stations > 1 {
        entries.extend((0..n_stations).map(|i| bad_station(scene, i)));
    }
    entries.extend(temperatures(scene));
    entries.extend(faults.iter().map(|fault| faulty(scene, *fault)));
    entries
}

impl Scene<'_> {
    /// `column` gives what an amplitude does to a reading.
    fn entry(
        &self,
        id: &str,
        subject: Option<String>,
        description: String,
        parameters: Vec<Parameter>,
        column: impl Fn(usize, usize) -> Vector3<f64>,
    ) -> Entry {
        let n = self.survey.targets.len();
        let columns = (0..parameters.len())
            .map(|p| (0..n).flat_map(|target| <[f64; 3]>::from(column(target, p))).collect())
            .collect();
        // What is held out may take all of it.
        let scope = Scope::SomeDesigns;
        let effect = Effect { subject, scope, description, ..Effect::new(id, "", parameters) };
        Entry { effect, columns }
    }
}

/// Half of the difference between coming with rising and with falling angles, error by error.
fn backlash(scene: &Scene<'_>) -> Entry {
    let text = "the axis stops elsewhere when it comes from the other side".to_owned();
    let approaches = approaches(&scene.survey.steps);
    let letter = scene.survey.axis.letter.letter();
    let parameters = motion(["µm", "µrad"], |c| format!("E{}{letter}", c.to_uppercase()));
    let way = |n: usize| match approaches[scene.survey.targets[n].step] {
        Approach::Positive => 0.5,
        Approach::Negative => -0.5,
    };
    // What a perfect axis does at every reading alike is its place.
    let n_targets = scene.survey.targets.len();
    let mean = if scene.is_perfect {
        (0..n_targets).map(way).sum::<f64>() / count(n_targets)
    } else {
        0.0
    };
    scene.entry("backlash", None, text, parameters, |n, c| {
        scene.sights[n].by_axis_motion(c) * (way(n) - mean)
    })
}

/// Of the predicted points: the measured ones hold the residual, and shrinking them to nothing
/// would explain it.
fn range_scale(scene: &Scene<'_>) -> Entry {
    let text = "the trackers read distances too long in proportion".to_owned();
    let parameters = vec![parameter("scale", "ppm", 1e6)];
    scene.entry("range-scale", None, text, parameters, |n, _| scene.sights[n].predicted_mm)
}

/// Reflectors of one body move against the others: the axis carries more than one rigid body.
///
/// In the turning frame weight turns once per turn of the axis, and with it what it bends.
fn body_motions(scene: &Scene<'_>) -> Vec<Entry> {
    let mut names: Vec<&String> = Vec::new();
    for name in scene.bodies {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let first_rad = scene.survey.steps[0].angle_rad;
    // Few amplitudes at a time: with as many as stops of the axis, none could be told from chance.
    let moved = |name: &String, (id, verb, first): (&str, &str, usize), wave: Wave| {
        let text =
            format!("the reflectors of {name} {verb} against the others with the angle's {wave}");
        let parameters = motion(["µm", "µrad"], str::to_owned)[first..first + 3].to_vec();
        scene.entry(id, Some(format!("{name}, {wave}")), text, parameters, |n, p| {
            let t = &scene.survey.targets[n];
            if scene.bodies[t.mount] != *name {
                return Vector3::zeros();
            }
            let size = wave.at(scene.survey.steps[t.step].angle_rad) - wave.at(first_rad);
            scene.sights[n].by_motion(first + p) * size
        })
    };
    // The first body's motion is that of the axis.
    let others = names.into_iter().skip(1);
    let kinds = [("body-sag", "sag", 0), ("body-tilt", "tilt", 3)];
    let waves = [Wave::Cosine, Wave::Sine];
    let all = others.flat_map(|name| kinds.map(|kind| waves.map(|wave| moved(name, kind, wave))));
    all.flatten().collect()
}

/// Part of a first harmonic.
#[derive(Clone, Copy)]
enum Wave {
    Cosine,
    Sine,
}

impl Wave {
    fn at(self, angle_rad: f64) -> f64 {
        match self {
            Self::Cosine => angle_rad.cos(),
            Self::Sine => angle_rad.sin(),
        }
    }
}

impl fmt::Display for Wave {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cosine => "cosine",
            Self::Sine => "sine",
        })
    }
}

/// A station moves and turns steadily since its first reading.
fn station_drift(scene: &Scene<'_>, station: usize) -> Entry {
    let name = &scene.survey.stations[station].name;
    let text = format!("station {name} moves steadily; its place is given at its first reading");
    let is_own = |n: usize| scene.survey.targets[n].station == station;
    let own = (0..scene.time.len()).filter(|&n| is_own(n)).map(|n| scene.time[n]);
    let first = own.fold(f64::INFINITY, f64::min);
    let (units, factor) = if scene.timed {
        (["µm/h", "µrad/h"], 3600.0)
    } else {
        (["µm over the run", "µrad over the run"], 1.0)
    };
    let mut parameters = motion(units, str::to_owned);
    for parameter in &mut parameters {
        parameter.report_factor *= factor;
    }
    scene.entry("station-drift", Some(name.clone()), text, parameters, |n, c| {
        let since = if is_own(n) { scene.time[n] - first } else { 0.0 };
        scene.sights[n].by_station_motion(c) * since
    })
}

fn bad_station(scene: &Scene<'_>, station: usize) -> Entry {
    let name = &scene.survey.stations[station].name;
    let text = format!("distances from station {name} alone are too long in proportion");
    let parameters = vec![parameter("scale", "ppm", 1e6)];
    scene.entry("bad-station", Some(name.clone()), text, parameters, |n, _| {
        let is_own = scene.survey.targets[n].station == station;
        scene.sights[n].predicted_mm * f64::from(u8::from(is_own))
    })
}

fn temperatures(scene: &Scene<'_>) -> Vec<Entry> {
    let columns = scene.covariates.iter().filter(|c| c.quantity == Quantity::Temperature);
    columns
        .map(|column| {
            let text = format!(
                "distances read too long in proportion to {} from {REFERENCE_C} °C",
                column.name
            );
            let parameters = vec![parameter("scale", "ppm/K", 1e6)];
            let subject = Some(column.name.clone());
            let mut entry = scene.entry("temperature", subject, text, parameters, |n, _| {
                scene.sights[n].predicted_mm * (column.values[n] - REFERENCE_C)
            });
            entry.effect.driver = Some(column.name.clone());
            entry
        })
        .collect()
}

/// From some reading on the machine, or one tracker, is elsewhere.
fn another_session(scene: &Scene<'_>, session: &Session) -> Entry {
    let survey = scene.survey;
    let first = &survey.targets[session.first];
    let station = &survey.stations[first.station].name;
    let (mount, step) = (&survey.mounts[first.mount].name, &survey.steps[first.step].name);
    let (id, subject, text) = session.named([station, mount, step]);
    let since = session.share(&seen(survey, scene.time));
    let parameters = motion(["µm", "µrad"], str::to_owned);
    let mut entry = scene.entry(id, Some(subject), text, parameters, |n, c| {
        Fault::Session(*session).column(survey, scene.sights, n, c) * since[n]
    });
    entry.effect.searched = session.searched;
    entry
}

fn faulty(scene: &Scene<'_>, fault: Fault) -> Entry {
    let survey = scene.survey;
    let from = &survey.targets[fault.reading()];
    let mount = &survey.mounts[from.mount].name;
    let station = &survey.stations[from.station].name;
    let step = &survey.steps[from.step].name;
    let (id, subject, text) = match fault {
        Fault::Session(session) => return another_session(scene, &session),
        Fault::Slip(_) => (
            "mount-slip",
            format!("{mount} at {step} from {station}"),
            format!("reflector {mount} slips in its mount before {station} sees it at step {step}"),
        ),
        Fault::BadPoint(_) => (
            "bad-point",
            format!("{mount} at {step} from {station}"),
            format!(
                "the reading of {mount} at step {step} from {station} is off, by so much along the \
                 axes of the station"
            ),
        ),
    };
    scene.entry(id, Some(subject), text, coordinates("µm", 1e3), |n, c| {
        fault.column(survey, scene.sights, n, c)
    })
}
