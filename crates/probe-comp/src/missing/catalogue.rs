//! What a probe leaves out: the catalogue of effects.
//!
//! A positive amplitude is a ball or a part that is larger, a reading that is longer or that is
//! further along the approach than declared.

use model_discrepancy::{Covariate, Effect, Parameter, Quantity, Role, Scope};
use nalgebra::{Unit, Vector3};

use super::approach_reversal::{EACH_WAY, reversed_axes};
use super::columns::{REFERENCE_C, TIME, as_f64, feed};
use super::form::{Form, FormScale};
use super::measured::MeasuredTouch;
use super::term::Term;
use crate::nominal::NominalFoot;

/// Mean square of a normal's component from which a motion along that axis can be told: the touches
/// see a tenth of it. Below it a turn of the workpiece frame does the same, and of what is not offered
/// another effect bears the name.
const SHOWN: f64 = 0.01;
/// No machine is further out of square than this.
const GROSS_RAD: f64 = 1e-3;
/// No machine reads an axis longer than this; the touches would show less than they can where they
/// do not spread along it.
const GROSS_SCALE: f64 = 1e-3;
/// No axis reads longer than this, even without any compensation, and no axes are further out of
/// square: what needs more is no error of the machine. A hundredth.
const NO_MACHINE: f64 = 1e-2;
/// No probe that triggers at all gives way by more, or travels farther until it does.
const NO_PROBE_MM: f64 = 0.5;
/// The column that says which way each touch was made.
const DIRECTION: &str = "direction";
/// What a touch can show at all.
const SEEN_MM: f64 = 1e-3;

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];
pub(crate) const ABOUT_THE_PART: [&str; 3] =
    ["x, about the part", "y, about the part", "z, about the part"];

/// An effect as the loop sees it, and what it does.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) effect: Effect,
    pub(crate) term: Term,
}

/// What the catalogue depends on.
pub(crate) struct Setting<'a> {
    pub(crate) touches: &'a [MeasuredTouch],
    /// Of the ball at each, on the nominal part.
    pub(crate) centers_mm: &'a [Vector3<f64>],
    /// From the ball towards the part.
    pub(crate) approaches: &'a [Unit<Vector3<f64>>],
    /// Of the balls as they were read, on the nominal part.
    pub(crate) feet: &'a [NominalFoot],
    pub(crate) covariates: &'a [Covariate],
    /// Families of errors of form that the part may have, with the columns that the touches see,
    /// and in what unit.
    pub(crate) forms: Vec<(Form, Vec<usize>)>,
    pub(crate) form_scale: FormScale,
    /// Mean squares of the normals' components.
    pub(crate) normal_squares: Vector3<f64>,
    /// Root mean square of `normal[i] × center[j]`.
    pub(crate) levers_mm: [[f64; 3]; 3],
    /// Root mean square of what a turn by 1 rad about each axis adds to a distance.
    pub(crate) turns_mm: Vector3<f64>,
}

/// The catalogue.
pub(crate) fn catalogue(setting: &Setting<'_>) -> Vec<Entry> {
    let mut entries = probe(setting);
    entries.extend(machine(setting));
    entries.extend(drifts(setting));
    entries.extend(temperatures(setting));
    entries.extend(frame(setting));
    entries.extend(setting.forms.iter().map(|(form, seen)| {
        let parameters = seen.iter().map(|&k| micrometres(form.parameters()[k])).collect();
        let term = Term::Form { form: *form, seen: seen.clone(), scale: setting.form_scale };
        let (id, subject) = form.id();
        let mut entry = entry(id, form.description(), parameters, term);
        entry.effect.subject = subject.map(str::to_owned);
        entry
    }));
    entries.extend(bad_points(setting.touches));
    entries
}

impl Entry {
    fn about(mut self, subject: &str) -> Self {
        self.effect.subject = Some(subject.to_owned());
        self
    }

    fn at_most(mut self, maximum: f64) -> Self {
        self.effect.maximum = Some(maximum);
        self
    }

    fn driven_by(mut self, covariate: &str) -> Self {
        self.effect.driver = Some(covariate.to_owned());
        self
    }
}

fn entry(id: &str, description: &str, parameters: Vec<Parameter>, term: Term) -> Entry {
    let effect = Effect::new(id, description, parameters).within(scope(&term));
    Entry { effect, term }
}

/// What a term moves; approaches along the stylus, a feed that was not recorded and temperatures
/// that stand at 20 °C show nothing of some.
fn scope(term: &Term) -> Scope {
    match term {
        Term::BadPoint { observation } => Scope::Observation(*observation),
        Term::Ball | Term::Shift { .. } | Term::Turn { .. } | Term::Form { .. } => {
            Scope::Everywhere
        }
        _ => Scope::SomeDesigns,
    }
}

fn parameter(name: &str, unit: &str, report_factor: f64) -> Parameter {
    Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor }
}

fn micrometres(name: &str) -> Parameter {
    parameter(name, "µm", 1e3)
}

fn probe(setting: &Setting<'_>) -> Vec<Entry> {
    let text = "the probe's ball is larger than declared";
    let ball = entry("tip-radius", text, vec![parameter("radius", "mm", 1.0)], Term::Ball);
    let text = "the probe triggers after this travel along its approach";
    let parameters = vec![parameter("travel", "mm", 1.0)];
    let pretravel = entry("pretravel", text, parameters, Term::Pretravel).at_most(NO_PROBE_MM);
    let text = "the travel until the probe triggers goes with the direction, in three lobes about \
                the stylus";
    let lobing = |power: i32, subject: &str| {
        let parameters = vec![micrometres("cos"), micrometres("sin")];
        entry("lobing", text, parameters, Term::Lobing { power })
            .about(subject)
            .at_most(NO_PROBE_MM)
    };
    let text = "the stylus gives way sideways until the probe triggers; at right angles to it";
    let bending =
        entry("bending", text, vec![micrometres("sideways")], Term::Bending).at_most(NO_PROBE_MM);
    let lobing_tilted = lobing(1, "with the sideways part of the approach");
    let lobing_even = lobing(0, "at every inclination");
    vec![ball, pretravel, lobing_tilted, lobing_even, bending, latency(setting)]
}

/// Without a recorded feed, its trace is nothing, and the loop says what would show it.
fn latency(setting: &Setting<'_>) -> Entry {
    let text = "the machine is read this late after the trigger";
    let parameters = vec![parameter("time", "ms", 1e3)];
    match feed(setting.covariates) {
        Some((column, factor)) => {
            let speed_mm_per_s = column.values.iter().map(|v| v * factor).collect();
            let term = Term::Latency { speed_mm_per_s };
            entry("latency", text, parameters, term).driven_by(&column.name)
        }
        None => entry("latency", text, parameters, Term::Latency { speed_mm_per_s: Vec::new() }),
    }
}

fn machine(setting: &Setting<'_>) -> Vec<Entry> {
    let long = |axis: usize, more: &str, (about_mm, lever_mm): (f64, f64)| {
        let text = format!("the machine's {} axis reads long{more}", AXES[axis]);
        let parameters = vec![parameter(AXES[axis], "ppm", 1e6)];
        let seen = lever_mm * GROSS_SCALE > SEEN_MM;
        let term = if seen { Term::Scale { axis, about_mm } } else { Term::Unseen };
        entry("axis-scale", &text, parameters, term).at_most(NO_MACHINE)
    };
    let of_machine =
        |axis: usize| long(axis, "", (0.0, setting.levers_mm[axis][axis])).about(AXES[axis]);
    let mut entries: Vec<Entry> = (0..3).map(of_machine).collect();
    let middle_mm = setting.form_scale.center_mm.coords;
    let is_far = |axis: &usize| middle_mm[*axis].abs() * GROSS_SCALE > SEEN_MM;
    entries.extend((0..3).filter(is_far).map(|axis| {
        let lever = (middle_mm[axis], setting.form_scale.radius_mm);
        long(axis, ", and the workpiece frame was found with it", lever).about(ABOUT_THE_PART[axis])
    }));
    let pairs: Vec<(usize, usize)> = [(0, 1), (0, 2), (1, 2)]
        .into_iter()
        .filter(|&(i, j)| setting.levers_mm[i][j] * GROSS_RAD > SEEN_MM)
        .collect();
    let named =
        |&(i, j): &(usize, usize)| parameter(&format!("{}{}", AXES[i], AXES[j]), "µrad", 1e6);
    if !pairs.is_empty() {
        let square = |text: &str, about_mm: Vector3<f64>| {
            let parameters = pairs.iter().map(named).collect();
            let term = Term::Squareness { pairs: pairs.clone(), about_mm };
            entry("squareness", text, parameters, term).at_most(NO_MACHINE)
        };
        let text = "the machine's axes are not square to each other";
        entries.push(square(text, Vector3::zeros()));
        if middle_mm.norm() * GROSS_RAD > SEEN_MM {
            let text = "the machine's axes are not square to each other, and the workpiece frame was found with them";
            entries.push(square(text, middle_mm).about("about the part"));
        }
    }
    entries.push(reversal(setting));
    let forms = (setting.forms.iter().map(|(form, _)| *form), &setting.form_scale);
    let shown = axes_beyond(SHOWN, setting);
    let reversed = reversed_axes(&shown, (setting.feet, setting.approaches), forms);
    entries.extend(reversed.into_iter().map(approach_reversal));
    entries.extend(shown.iter().filter_map(|axis| column_reversal(setting, *axis)));
    entries
}

/// Half of what an axis reads more when it came from below than when it came from above.
///
/// From which side the axes came to the first touch is not known: what it reads is its own.
fn reversal(setting: &Setting<'_>) -> Entry {
    // Of the nominal places: on a plane the noise of two readings decides which lies higher, and the
    // way would follow the residual.
    let places = setting.centers_mm;
    let mut way = Vector3::zeros();
    let mut ways = Vec::with_capacity(places.len());
    for (i, place) in places.iter().enumerate() {
        let from = if i == 0 { place } else { &places[i - 1] };
        // An axis that stands still stays on the side it came from.
        way = (place - from).zip_map(&way, |moved: f64, before| {
            if moved.abs() > SEEN_MM { moved.signum() } else { before }
        });
        ways.push(way);
    }
    let axes = axes_beyond(SHOWN, setting);
    let text = "an axis reads otherwise when it comes to a touch from the other side";
    let names = axes.iter().map(|&k| AXES[k]).chain(["first touch"]);
    let parameters = names.map(micrometres).collect();
    entry("reversal", text, parameters, Term::Reversal { ways, axes })
}

/// The same of one axis, where the ball comes along its approach from the side that it came from.
fn approach_reversal((axis, only_instead): (usize, bool)) -> Entry {
    let name = AXES[axis];
    let text = format!(
        "the machine's {name} axis reads otherwise where the ball comes from the other side"
    );
    let term = Term::ApproachReversal { axis };
    let mut entry = entry("reversal", &text, vec![micrometres(name)], term)
        .about(&format!("{name}, by approach"));
    entry.effect.only_instead = only_instead;
    entry
}

/// The same of one axis, where a recorded direction has touches of either sign, as of lines that are measured to and fro.
fn column_reversal(setting: &Setting<'_>, axis: usize) -> Option<Entry> {
    let recorded = setting.covariates.iter().find(|c| c.name == DIRECTION)?;
    let ways: Vec<f64> = recorded.values.iter().map(|v| sign(*v)).collect();
    let either_way = |way: f64| ways.iter().filter(|w| **w * way > 0.0).count();
    if either_way(1.0).min(either_way(-1.0)) < EACH_WAY {
        return None;
    }
    let name = AXES[axis];
    let text = format!(
        "the machine's {name} axis reads otherwise where the touches were made the other way, as `{DIRECTION}` says"
    );
    let term = Term::ColumnReversal { axis, ways };
    let about = format!("{name}, by direction");
    Some(entry("reversal", &text, vec![micrometres(name)], term).about(&about))
}

/// The sign of a value; none of zero.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Axes along which the touches show more than this mean square of a motion.
fn axes_beyond(least: f64, setting: &Setting<'_>) -> Vec<usize> {
    (0..3).filter(|&axis| setting.normal_squares[axis] > least).collect()
}

fn drifts(setting: &Setting<'_>) -> Vec<Entry> {
    let time = setting.covariates.iter().find(|c| c.name == TIME);
    let count = setting.touches.len();
    let (elapsed, unit, factor): (Vec<f64>, _, _) = match time {
        Some(time) => {
            let start = time.values.first().copied().unwrap_or(0.0);
            (time.values.iter().map(|t| t - start).collect(), "µm/h", 3.6e6)
        }
        // Internally per touch, so that a longer series has the same parameter; reported over all.
        None => ((0..count).map(as_f64).collect(), "µm", 1e3 * as_f64(count.max(2) - 1)),
    };
    let axes = axes_beyond(SHOWN, setting);
    let parameters = axes.iter().map(|&k| parameter(AXES[k], unit, factor)).collect();
    let term = Term::Drift { elapsed: elapsed.clone(), axes };
    let text = "the machine drifts against the part while it is touched";
    let place = entry("drift", text, parameters, term).about("machine");
    let text = "the probe triggers later and later along its approach";
    let parameters = vec![parameter("travel", unit, factor)];
    let trigger = entry("drift", text, parameters, Term::TriggerDrift { elapsed }).about("trigger");
    let driven = |entry: Entry| if time.is_some() { entry.driven_by(TIME) } else { entry };
    vec![driven(place), driven(trigger)]
}

fn temperatures(setting: &Setting<'_>) -> Vec<Entry> {
    let columns: Vec<_> =
        setting.covariates.iter().filter(|c| c.quantity == Quantity::Temperature).collect();
    let several = columns.len() > 1;
    // Where a part stays as it grows, nobody knows; along z the machine grows too.
    let mut axes = axes_beyond(SHOWN, setting);
    if !axes.contains(&2) {
        axes.push(2);
    }
    (columns.into_iter())
        .map(|column| {
            let text = if axes.len() == 1 {
                format!("the readings of z and the part's size go with {}", column.name)
            } else {
                format!("the part's size, and where its middle is, go with {}", column.name)
            };
            let excess_k = column.values.iter().map(|t| t - REFERENCE_C).collect();
            let about_mm = setting.form_scale.center_mm.coords;
            let growth = |&axis: &usize| parameter(&format!("{} growth", AXES[axis]), "µm/K", 1e3);
            let mut parameters: Vec<_> = axes.iter().map(growth).collect();
            parameters.push(parameter("expansion", "ppm/K", 1e6));
            let term = Term::Temperature { excess_k, axes: axes.clone(), about_mm };
            let entry = entry("temperature", &text, parameters, term).driven_by(&column.name);
            if several { entry.about(&column.name) } else { entry }
        })
        .collect()
}

/// The frame in which the readings come may lie beside the part's own.
fn frame(setting: &Setting<'_>) -> Vec<Entry> {
    let axes = axes_beyond(SHOWN, setting);
    let text = "the workpiece frame lies beside where it is declared";
    let parameters = axes.iter().map(|&k| micrometres(AXES[k])).collect();
    let shift = entry("datum-shift", text, parameters, Term::Shift { axes });
    let text = "the workpiece frame is turned against the part";
    let about_mm = setting.form_scale.center_mm.coords;
    let axes: Vec<usize> =
        (0..3).filter(|&axis| setting.turns_mm[axis] * GROSS_RAD > SEEN_MM).collect();
    if axes.is_empty() {
        return vec![shift];
    }
    let parameters = axes.iter().map(|&k| parameter(AXES[k], "µrad", 1e6)).collect();
    vec![shift, entry("datum-turn", text, parameters, Term::Turn { about_mm, axes })]
}

fn bad_points(touches: &[MeasuredTouch]) -> Vec<Entry> {
    let fitted = touches.iter().enumerate().filter(|(_, t)| t.role == Role::Fit);
    fitted
        .map(|(observation, touch)| {
            let text = format!("touch {} is off on its own", touch.name);
            let parameters = vec![parameter("along the normal", "mm", 1.0)];
            let term = Term::BadPoint { observation };
            entry("bad-point", &text, parameters, term).about(&touch.name)
        })
        .collect()
}
