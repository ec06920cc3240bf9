//! The residual against every covariate: small multiples on one scale.

use std::collections::HashMap;

use model_discrepancy::Covariate;

use super::order::mark_layers;
use super::{Context, MOST_COMPONENTS, SMALL, paragraph};
use crate::axis::{Range, drawable};
use crate::layer::{Layer, mark_sign};
use crate::markup::Markup;
use crate::number::count;
use crate::panel::{Axis, Panel};
use crate::reading::Reading;
use crate::unit::column_title;
use crate::{thin, trend};

/// Marks of one component in one plot.
const MOST_MARKS: usize = 300;
/// Covariates drawn, those with structure left first.
const MOST_COVARIATES: usize = 12;

pub(super) fn covariate_figures(
    out: &mut Markup,
    context: &Context,
    readings: &[Reading],
    range: Range,
    model: &str,
) {
    let chosen = drawn(context);
    if chosen.is_empty() {
        return;
    }
    out.element("h3", &[], "Against what was recorded beside it");
    legend(out, context, readings);
    out.open("div", &[("class", &"grid")]);
    let by_component = split(readings, context.components.len().min(MOST_COMPONENTS));
    for covariate in &chosen {
        out.append(&panel(context, &by_component, covariate, (range, model)).draw("plot small"));
    }
    out.close("div");
    let notes = notes(context, &by_component, chosen.len());
    if !notes.is_empty() {
        paragraph(out, "quiet", &notes);
    }
}

/// Those that a finding names first, then in the order given.
pub(super) fn drawn<'a>(context: &Context<'a>) -> Vec<&'a Covariate> {
    let mut rank: HashMap<&str, usize> = HashMap::new();
    if let Some(closure) = context.closure {
        let steps = closure.steps.iter().filter_map(|s| s.effect.strip_prefix("covariate:"));
        for name in steps.chain(closure.remaining.iter().map(|r| r.covariate.as_str())) {
            let next = rank.len();
            rank.entry(name).or_insert(next);
        }
    }
    let mut chosen: Vec<&Covariate> =
        context.input.covariates.iter().filter(|c| varies(c, context)).collect();
    chosen.sort_by_key(|c| rank.get(c.name.as_str()).copied().unwrap_or(usize::MAX));
    chosen.truncate(MOST_COVARIATES);
    chosen
}

fn varies(covariate: &Covariate, context: &Context) -> bool {
    let values = &covariate.values;
    values.len() == context.input.layout.observations.len()
        && values.iter().any(|v| drawable(*v) && v.total_cmp(&values[0]).is_ne())
}

fn split(readings: &[Reading], components: usize) -> Vec<Vec<Reading>> {
    let of = |c: usize| readings.iter().filter(|r| r.component == c).copied().collect();
    (0..components).map(of).collect()
}

fn panel(
    context: &Context,
    by_component: &[Vec<Reading>],
    covariate: &Covariate,
    (range, model): (Range, &str),
) -> Panel {
    let at = |r: &Reading| covariate.values[r.observation];
    let values = by_component.iter().flatten().map(at);
    let x = Range::of(values).unwrap_or(Range { low: 0.0, high: 1.0 }).padded(0.04);
    let mut layers = Vec::new();
    let mut trends = Vec::new();
    for (component, own) in by_component.iter().enumerate() {
        let stride = thin::stride(own.len(), MOST_MARKS);
        let kept: Vec<Reading> = own.iter().step_by(stride).copied().collect();
        layers.extend(mark_layers(&kept, at, component));
        let places = own.iter().map(|r| [at(r), r.value]);
        let all: Vec<[f64; 2]> = places.filter(|p| drawable(p[0])).collect();
        trends.push(Layer::Line { points: trend::means(&all), colour: component, trend: true });
    }
    layers.append(&mut trends);
    let title = column_title(&covariate.name);
    Panel {
        size: (SMALL, 210.0),
        alternative: format!("Residual, {model}, against {title}"),
        x: Axis::new(x, title),
        y: Axis::new(range, context.shown.title("residual")),
        layers,
    }
}

/// What colours and shapes mean, where there is more than one.
fn legend(out: &mut Markup, context: &Context, readings: &[Reading]) {
    let components = &context.components[..context.components.len().min(MOST_COMPONENTS)];
    if components.len() < 2 {
        return;
    }
    out.open("p", &[("class", &"legend")]);
    for (i, name) in components.iter().enumerate() {
        out.open("span", &[("class", &"key")]);
        out.append(&mark_sign(i));
        out.name(name);
        out.close("span");
    }
    if readings.iter().any(|r| r.check) {
        out.element("span", &[("class", &"key")], "hollow: never fitted");
    }
    out.close("p");
}

/// What is not drawn, and what the lines are.
fn notes(context: &Context, by_component: &[Vec<Reading>], drawn: usize) -> String {
    let mut notes = Vec::new();
    let varying = context.input.covariates.iter().filter(|c| varies(c, context)).count();
    if varying > drawn {
        notes.push(format!("{drawn} of {varying} covariates are drawn."));
    }
    let longest = by_component.iter().map(Vec::len).max().unwrap_or(0);
    let stride = thin::stride(longest, MOST_MARKS);
    if stride > 1 {
        notes.push(format!(
            "Of {} readings of a component, 1 in {stride} is shown; the line is the mean of all.",
            count(longest)
        ));
    } else if longest >= trend::LEAST {
        notes.push("Line: mean of readings at neighbouring values.".to_string());
    }
    notes.join(" ")
}
