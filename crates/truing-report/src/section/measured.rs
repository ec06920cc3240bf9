//! What was measured.

use model_discrepancy::Role;

use super::{Context, facts, paragraph};
use crate::markup::Markup;
use crate::number::{count, counted, plural, trimmed};

pub(crate) fn measured(out: &mut Markup, context: &Context) {
    let input = context.input;
    out.element("h2", &[], "What was measured");
    for line in input.description {
        paragraph(out, "", line);
    }
    let given = input.measured.iter().map(|f| (f.name.clone(), f.value.clone()));
    let source = input.source.iter().map(|s| ("source".to_string(), (*s).to_string()));
    let rows = source.chain(given).chain(layout_facts(context));
    facts(out, rows);
}

/// What the layout itself says.
fn layout_facts(context: &Context) -> Vec<(String, String)> {
    let layout = context.input.layout;
    let noun = context.input.group_noun;
    let mut facts = Vec::new();
    let fitted = counted(context.group_count(Role::Fit), noun);
    let groups = match context.group_count(Role::Check) {
        0 => format!("{fitted} fitted"),
        check => format!("{fitted} fitted, {} set aside to judge", count(check)),
    };
    facts.push(("groups".to_string(), groups));
    let observed = counted(layout.observations.len(), "observation");
    let values = counted(context.before.len(), "residual");
    facts.push(("size".to_string(), format!("{observed}, {values} in {}", layout.unit)));
    if let Some(noise) = declared_noise(context) {
        facts.push(("declared noise".to_string(), noise));
    } else if !layout.sigma_declared {
        facts.push(("declared noise".to_string(), "none: estimated from the residual".into()));
    }
    if !context.input.covariates.is_empty() {
        let names: Vec<&str> = context.input.covariates.iter().map(|c| c.name.as_str()).collect();
        let recorded = names.iter().take(12).copied().collect::<Vec<_>>().join(", ");
        let more = names.len().saturating_sub(12);
        let rest = if more > 0 { format!(" and {} more", count(more)) } else { String::new() };
        facts.push((format!("recorded beside the {}", plural("observation")), recorded + &rest));
    }
    facts
}

/// Declared standard uncertainty of one residual, or its range.
fn declared_noise(context: &Context) -> Option<String> {
    if !context.input.layout.sigma_declared || context.before.is_empty() {
        return None;
    }
    let low = context.before.iter().map(|r| r.sigma).fold(f64::INFINITY, f64::min);
    let high = context.before.iter().map(|r| r.sigma).fold(0.0, f64::max);
    let unit = &context.shown.unit;
    let same = high <= low * (1.0 + 1e-9);
    Some(if same {
        format!("{} {unit} (one standard uncertainty)", trimmed(low, 3))
    } else {
        let (low, high) = (trimmed(low, 3), trimmed(high, 3));
        format!("{low} to {high} {unit} (one standard uncertainty)")
    })
}
