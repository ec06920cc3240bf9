//! What was added, and how sure that is.

use model_discrepancy::{ParameterEstimate, Step};

use super::declared::shifted;
use super::{Cell, Context, Kind, paragraph, sentence, table};
use crate::markup::Markup;
use crate::number::{p_value, percent, significant, with_expanded};
use crate::wording::in_words;

pub(crate) fn added(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "What was added, and how sure that is");
    if closure.steps.is_empty() {
        paragraph(out, "quiet", "Nothing.");
        return;
    }
    for step in &closure.steps {
        one_step(out, context, step);
    }
    shifted(out, context.input.parameters);
}

/// Id of an effect with its subject in brackets.
pub(crate) fn step_name(step: &Step) -> String {
    match &step.subject {
        Some(subject) => format!("{} [{subject}]", step.effect),
        None => step.effect.clone(),
    }
}

fn one_step(out: &mut Markup, context: &Context, step: &Step) {
    out.open("h3", &[]);
    out.name(&step_name(step));
    out.close("h3");
    let amplitudes: Vec<(f64, f64, &str)> =
        step.parameters.iter().map(|p| (p.value, p.std, p.unit.as_str())).collect();
    paragraph(out, "", &sentence(&in_words(&step.description, &amplitudes)));
    if step.parameters.is_empty() {
        paragraph(out, "quiet", "It has no amplitude of its own.");
    } else {
        table(
            out,
            "Amplitudes, ± expanded uncertainty (k\u{a0}=\u{a0}2)",
            &[
                ("parameter", Kind::Name),
                ("value", Kind::Number),
                ("±", Kind::Number),
                ("unit", Kind::Unit),
                ("value ÷ standard uncertainty", Kind::Number),
            ],
            step.parameters.iter().map(amplitude),
        );
    }
    out.open("ul", &[]);
    for line in sureness(context, step) {
        out.element("li", &[], &line);
    }
    if !step.indistinguishable_from.is_empty() {
        rivals(out, step);
    }
    out.close("ul");
}

fn amplitude(parameter: &ParameterEstimate) -> Vec<Cell> {
    let (value, expanded) = with_expanded(parameter.value, parameter.std);
    let ratio = (parameter.value / parameter.std).abs();
    vec![
        Cell::new(&parameter.name),
        Cell::number(value, parameter.value),
        Cell::number(expanded, parameter.std),
        Cell::new(&parameter.unit),
        Cell::number(significant(ratio, 2), ratio),
    ]
}

fn sureness(context: &Context, step: &Step) -> Vec<String> {
    let shown = |v: f64| significant(context.show(v), 3);
    let unit = &context.shown.unit;
    let mut lines = vec![
        format!("Chance of seeing as much with no such effect: p = {}.", p_value(step.p_value))
            .replace("p = <", "p <"),
        format!(
            "With it, the error with groups left out in turn is {}\u{a0}{unit}, on the data \
             fitted {}\u{a0}{unit}.",
            shown(step.held_out_rms),
            shown(step.train_rms)
        ),
    ];
    lines.push(match step.stability.resampled {
        Some(share) => format!(
            "Chosen, it or one of its rivals, in {} of the repetitions with groups left out.",
            percent(share)
        ),
        None => "The choice was not repeated with groups left out.".to_string(),
    });
    lines.extend(step.stability.perturbed.map(|share| {
        format!(
            "Chosen, it or one of its rivals, in {} of the repetitions with every reading moved by \
             up to half of its last recorded decimal.",
            percent(share)
        )
    }));
    lines
}

fn rivals(out: &mut Markup, step: &Step) {
    out.open("li", &[("class", &"caution")]);
    out.text("These data fit as well with ");
    for (i, rival) in step.indistinguishable_from.iter().enumerate() {
        if i > 0 {
            out.text(", ");
        }
        out.name(rival);
    }
    out.text(": take it as one of the class, not as this one.");
    out.close("li");
}
