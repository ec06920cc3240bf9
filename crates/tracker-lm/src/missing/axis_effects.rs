//! What a perfect axis may be missing: its location, and motion errors as functions of its angle.
//!
//! Names are those of ISO 230-1 and ISO 230-7. A motion error is offered as harmonics of the angle,
//! up to an order that the residual shows (see [`orders`](super::orders)), and where angles are
//! visited again as a value at each of them.

use model_discrepancy::{Effect, Parameter, Scope};

use crate::count::count;
use crate::curves::{LOCATION, Shape};
use crate::missing::effects::parameter;
use crate::missing::orders::Orders;
use crate::missing::stops::{Stops, along, harmonic};
use crate::{AxisLetter, AxisModel};

/// An effect on the axis, and what each of its amplitudes does to the six errors.
#[derive(Clone, Debug)]
pub(crate) struct AxisEffect {
    pub(crate) effect: Effect,
    pub(crate) shapes: Vec<Shape>,
}

/// All that may be missing of an axis taken for perfect; nothing of one with free errors.
pub(crate) fn axis_effects(
    model: AxisModel,
    stops: &Stops<'_>,
    orders: &Orders,
) -> Vec<AxisEffect> {
    if model == AxisModel::Free {
        return Vec::new();
    }
    let mut effects = Vec::new();
    if model == AxisModel::Fixed && orders.location {
        effects.push(location(stops.axis.letter));
    }
    effects.extend((0..6).filter_map(|c| harmonics(stops, c, orders)));
    effects.push(angle_scale(stops));
    if orders.by_angle {
        effects.extend((0..6).map(|c| levels(stops, c)));
    }
    effects
}

fn effect(
    id: &str,
    subject: Option<String>,
    description: String,
    parameters: Vec<Parameter>,
) -> Effect {
    // An arc that hardly turns shows little of a location.
    let scope = Scope::SomeDesigns;
    Effect { subject, scope, description, ..Effect::new(id, "", parameters) }
}

fn location(letter: AxisLetter) -> AxisEffect {
    let text = "the axis is not where it is declared: displaced by the first two and tilted by the \
                others (ISO 230-1)";
    let names = letter.location_names();
    let parameters = (0..4).map(|c| {
        let (unit, factor) = if c < 2 { ("µm", 1e3) } else { ("µrad", 1e6) };
        parameter(&names[c], unit, factor)
    });
    let mut effect = effect("axis-location", None, text.to_owned(), parameters.collect());
    // What the stations absorb of it is the same at every angle.
    effect.driver = Some("angle_deg".to_owned());
    AxisEffect { effect, shapes: LOCATION.to_vec() }
}

/// Catalogue id and words for one of the six errors.
fn kind(letter: AxisLetter, component: usize) -> (&'static str, &'static str) {
    let own = letter.own();
    match component {
        c if c == own => ("axial-motion", "moves along itself"),
        c if c == 3 + own => ("angular-positioning", "stops at another angle than commanded"),
        c if c < 3 => ("radial-motion", "moves across itself"),
        _ => ("tilt-motion", "tilts"),
    }
}

fn unit(component: usize) -> (&'static str, f64) {
    if component < 3 { ("µm", 1e3) } else { ("µrad", 1e6) }
}

fn harmonics(stops: &Stops<'_>, component: usize, orders: &Orders) -> Option<AxisEffect> {
    let letter = stops.axis.letter;
    let highest = orders.highest[component];
    if highest == 0 {
        return None;
    }
    let name = letter.error_names()[component].clone();
    let (id, verb) = kind(letter, component);
    let once = if highest == 1 { "once".to_owned() } else { format!("up to {highest} times") };
    let text = format!("the axis {verb} as it turns: {name} by harmonics {once} per turn");
    let (unit, factor) = unit(component);
    let (mut parameters, mut shapes) = (Vec::new(), Vec::new());
    for order in 1..=highest {
        let times = if order == 1 { String::new() } else { format!("{order}·") };
        for (function, wave) in [("cos", f64::cos as fn(f64) -> f64), ("sin", f64::sin)] {
            let term = format!("{name} {function} {times}{}", letter.letter().to_ascii_lowercase());
            parameters.push(parameter(&term, unit, factor));
            shapes.push(harmonic(stops.angles_rad, component, order, wave));
        }
    }
    let mut effect = effect(id, Some(name), text, parameters);
    effect.searched = orders.searched[component];
    Some(AxisEffect { effect, shapes })
}

/// Positions in proportion to the angle: the scale of an encoder, or a ratio of gears.
fn angle_scale(stops: &Stops<'_>) -> AxisEffect {
    let letter = stops.axis.letter;
    let own = 3 + letter.own();
    let name = &letter.error_names()[own];
    let text = format!("the axis turns too far in proportion to the angle: {name} grows with it");
    let effect = effect(
        "angle-scale",
        None,
        text,
        vec![parameter(&format!("{name} per angle"), "ppm", 1e6)],
    );
    let from_first = stops.angles_rad.iter().map(|angle| angle - stops.angles_rad[0]);
    AxisEffect { effect, shapes: vec![along(own, from_first)] }
}

/// A value of one error at every angle beside that at the first, about their mean over all visits:
/// what all share is the location of the axis.
fn levels(stops: &Stops<'_>, component: usize) -> AxisEffect {
    let letter = stops.axis.letter;
    let name = letter.error_names()[component].clone();
    let (id, verb) = kind(letter, component);
    let text = format!(
        "the axis {verb} by an amount of its own at every angle: {name}, each relative to the first"
    );
    let (unit, factor) = unit(component);
    let n_angles = stops.angles_rad.len();
    let n_visits: usize = stops.visits.iter().sum();
    let level = |k: usize| {
        let angle = format!("{name} at {}°", degrees(stops.angles_rad[k]));
        let mean = count(stops.visits[k]) / count(n_visits);
        let value = (0..n_angles).map(|j| if j == k { 1.0 - mean } else { -mean });
        (parameter(&angle, unit, factor), along(component, value))
    };
    let (parameters, shapes) = (1..n_angles).map(level).unzip();
    AxisEffect {
        effect: effect(id, Some(format!("{name} angle by angle")), text, parameters),
        shapes,
    }
}

/// An angle as the table has it.
fn degrees(angle_rad: f64) -> f64 {
    (angle_rad.to_degrees() * 1e6).round() / 1e6
}
