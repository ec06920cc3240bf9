//! What a tip and places that stand still leave out: the catalogue of effects.

use model_discrepancy::{Covariate, Effect, Parameter, Scope};

use crate::missing::effects::{Passed, passed};
use crate::tip::Design;

/// What an amplitude adds to a residual.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Term {
    /// Something moves, per unit of how far it has come at each pose.
    Drift(Drifting, Vec<f64>),
    /// The tip sits elsewhere in the flange from this pose on, mm.
    TipSlip(usize),
    /// The tool bends under its weight across its axis, mm.
    Sag,
    /// One pose is off, mm.
    BadPose(usize),
}

/// What moves while the poses are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drifting {
    /// The base against the places, along the axes of the base.
    Places,
    /// The tip against the flange, along the axes of the flange.
    Tip,
}

pub(crate) fn parameter(name: &str, unit: &str) -> Parameter {
    let report_factor = if unit == "µm" { 1e3 } else { 1.0 };
    Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor }
}

/// Fewest poses on either side of a slip that is looked for.
const FEWEST: usize = 3;

/// A scale is not among them: of the measured positions, shrinking everything to nothing would
/// explain the residual to the last digit; of the predicted ones, tip and places take it up.
pub(crate) fn catalogue(
    design: &Design,
    labels: &[String],
    covariates: &[Covariate],
) -> Vec<(Effect, Term)> {
    let axes = || ["x", "y", "z"].map(|axis| parameter(axis, "mm")).to_vec();
    let effect = |id: &str, subject: Option<&String>, text: &str, parameters: Vec<Parameter>| {
        Effect { subject: subject.cloned(), ..Effect::new(id, text, parameters) }
    };
    // A tool that hangs or stands in every pose does not bend across its axis.
    let sag = Effect {
        scope: Scope::SomeDesigns,
        ..effect(
            "tool-sag",
            None,
            "the tool bends across its axis under its weight",
            vec![parameter("sag of a level tool", "µm")],
        )
    };
    let mut all = Vec::from(drifts(design.at.len(), covariates));
    all.push((sag, Term::Sag));
    let n = design.at.len();
    let is_new = |i: &usize| design.at[*i] != design.at[i - 1];
    for from in (FEWEST..(n + 1).saturating_sub(FEWEST)).filter(is_new) {
        let subject = format!("from {} on", labels[from]);
        let text = "the tip sits elsewhere in the flange from one pose on";
        all.push((effect("tip-slip", Some(&subject), text, axes()), Term::TipSlip(from)));
    }
    for (pose, label) in labels.iter().enumerate() {
        let text = "one pose misses its place, unlike the others";
        let one = effect("bad-pose", Some(label), text, axes());
        all.push((Effect { scope: Scope::Observation(pose), ..one }, Term::BadPose(pose)));
    }
    all
}

/// Drifts by recorded time where there is any, else by the order of the poses.
fn drifts(n: usize, covariates: &[Covariate]) -> [(Effect, Term); 2] {
    let Passed { elapsed, unit, report_factor, driver } = passed(n, covariates);
    let along = |axis: &str| Parameter { report_factor, ..parameter(axis, unit) };
    let of = |subject: Option<&str>, text: &str, what: Drifting| {
        let parameters = ["x", "y", "z"].map(along).to_vec();
        let effect = Effect {
            subject: subject.map(str::to_owned),
            driver: driver.clone(),
            // A tip goes nowhere that places do not where the flange hardly turns.
            scope: Scope::SomeDesigns,
            ..Effect::new("drift", text, parameters)
        };
        (effect, Term::Drift(what, elapsed.clone()))
    };
    [
        of(
            None,
            "machine and places move evenly against each other from the first pose to the last",
            Drifting::Places,
        ),
        of(
            Some("tip"),
            "the tip moves evenly in the flange from the first pose to the last: a tool or spindle that grows",
            Drifting::Tip,
        ),
    ]
}
