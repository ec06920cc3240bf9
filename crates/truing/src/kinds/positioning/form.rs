//! The form of a test of positioning.

use truing_report::{Fact, Form, FormResult};

use super::axis_run::{AxisFigureEstimate, AxisRunEstimate, AxisTargetEstimate};

/// Figures, targets and cycles by the names of ISO 230-2.
pub(crate) fn positioning_form(run: &AxisRunEstimate) -> Form {
    let result = |figure: &AxisFigureEstimate| FormResult {
        symbol: figure.symbol.to_owned(),
        name: figure.name.to_owned(),
        unit: run.unit.to_owned(),
        value: figure.value,
        std: figure.std,
        limit: None,
    };
    let notes = vec![
        "Figures are of the readings as they are. Their uncertainty holds the scatter of the cycles and \
         the declared length standard; what its certificate, its alignment and the temperature add is \
         in it as far as it was declared."
            .to_owned(),
    ];
    Form {
        title: "Test of positioning (ISO 230-2)".to_owned(),
        conditions: conditions(run),
        results: run.figures.iter().map(result).collect(),
        compensated: run.corrected.iter().flatten().map(result).collect(),
        notes,
        ..Form::default()
    }
}

fn conditions(run: &AxisRunEstimate) -> Vec<Fact> {
    let fact = |name: &str, value: String| Fact { name: name.to_owned(), value };
    let unit = if run.target_unit == "deg" { "°" } else { run.target_unit };
    let mut facts = vec![fact("targets", run.targets.len().to_string())];
    if let (Some(first), Some(last)) = (run.targets.first(), run.targets.last()) {
        facts.push(fact(
            "travel",
            format!("{} to {} {unit}", first.target, last.target).replace('-', "−"),
        ));
    }
    let cycles = |of: fn(&AxisTargetEstimate) -> usize| {
        let counts = || run.targets.iter().map(of);
        match (counts().min().unwrap_or(0), counts().max().unwrap_or(0)) {
            (few, most) if few == most => most.to_string(),
            (few, most) => format!("{few} to {most}"),
        }
    };
    facts.push(fact("cycles, rising", cycles(|target| target.n_rising)));
    facts.push(fact("cycles, falling", cycles(|target| target.n_falling)));
    facts
}
