//! The form of a calibration of rotary axes.

use tracker_lm::AxisLetter;
use truing_report::{Fact, Form, FormResult};

use super::axis_error::{AxisErrorEstimate, AxisLocationEstimate};

/// One axis as its form needs it.
pub(super) struct AxisOfForm<'a> {
    pub(super) letter: AxisLetter,
    /// Errors by angle; those about the axis where it was found, where there are such.
    pub(super) errors: &'a [AxisErrorEstimate],
    /// Whether they are about the axis where it was found.
    pub(super) is_motion: bool,
    pub(super) location: Option<&'a AxisLocationEstimate>,
}

/// Ranges of the six errors and the location of every axis, by the names of ISO 230-1 and 230-7.
pub(super) fn axis_form(axes: &[AxisOfForm<'_>], stations: usize, points: usize) -> Form {
    let letters: Vec<String> = axes.iter().map(|axis| axis.letter.letter().to_string()).collect();
    let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
    let mut conditions = Vec::new();
    for axis in axes {
        let angles = || axis.errors.iter().map(|error| error.angle_deg);
        let (low, high) = angles()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| {
                (low.min(angle), high.max(angle))
            });
        let name = format!("angles of axis {}", axis.letter.letter());
        conditions.push(fact(
            &name,
            format!("{}, from {low} to {high}°", angles().count()).replace('-', "−"),
        ));
    }
    conditions.push(fact("stations of the tracker", stations.to_string()));
    conditions.push(fact("target points", points.to_string()));
    let mut notes = vec![
        "Range: largest less smallest value over the angles measured, the axis standing at each. Its \
         uncertainty takes the two angles as independent."
            .to_owned(),
    ];
    notes.push(if axes.iter().all(|axis| axis.is_motion) {
        "Errors are about the axis where it was found, as far as they were named (ISO 230-7)."
            .to_owned()
    } else {
        "Errors are against the axis as declared: they contain what its location causes.".to_owned()
    });
    Form {
        title: format!(
            "Calibration of axis {} (names of ISO 230-1 and ISO 230-7)",
            letters.join(" and ")
        ),
        conditions,
        results: axes.iter().flat_map(|axis| [location(axis), ranges(axis)].concat()).collect(),
        notes,
        ..Form::default()
    }
}

fn location(axis: &AxisOfForm<'_>) -> Vec<FormResult> {
    let Some(location) = axis.location else { return Vec::new() };
    let result = |(i, symbol): (usize, &String)| {
        let (unit, factor) = if i < 2 { ("mm", 1.0) } else { ("µrad", 1e6) };
        let name = match symbol.chars().nth(1) {
            Some(about @ 'A'..='C') => format!("orientation of the axis about {}", linear(about)),
            Some(along) => format!("offset of the axis along {along}"),
            None => "location of the axis".to_owned(),
        };
        FormResult {
            symbol: symbol.clone(),
            name,
            unit: unit.to_owned(),
            value: Some(factor * location.values[i]),
            std: Some(factor * location.std[i]),
            limit: None,
        }
    };
    location.names.iter().enumerate().map(result).collect()
}

/// The linear axis about which a rotary one turns.
fn linear(rotary: char) -> char {
    match rotary {
        'A' => 'X',
        'B' => 'Y',
        _ => 'Z',
    }
}

fn ranges(axis: &AxisOfForm<'_>) -> Vec<FormResult> {
    let own = match axis.letter {
        AxisLetter::A => 0,
        AxisLetter::B => 1,
        AxisLetter::C => 2,
    };
    let names = axis.letter.error_names();
    let result = |(c, name): (usize, &String)| {
        let what = match (c < 3, c % 3 == own) {
            (true, true) => "axial error",
            (true, false) => "radial error",
            (false, true) => "angular positioning error",
            (false, false) => "tilt error",
        };
        // About the axis where it is: what ISO 230-7 calls so.
        let motion = if axis.is_motion && !what.contains("position") { " motion" } else { "" };
        let (unit, factor) = if c < 3 { ("µm", 1e3) } else { ("µrad", 1e6) };
        let of = |error: &AxisErrorEstimate| {
            let numbers = error.numbers();
            [factor * numbers[c], factor * numbers[6 + c]]
        };
        let all = || axis.errors.iter().map(of);
        let low = all().min_by(|a, b| a[0].total_cmp(&b[0]));
        let high = all().max_by(|a, b| a[0].total_cmp(&b[0]));
        FormResult {
            symbol: name.clone(),
            name: format!("{what}{motion}, range"),
            unit: unit.to_owned(),
            value: low.zip(high).map(|(low, high)| high[0] - low[0]),
            std: low.zip(high).map(|(low, high)| low[1].hypot(high[1])),
            limit: None,
        }
    };
    names.iter().enumerate().map(result).collect()
}
