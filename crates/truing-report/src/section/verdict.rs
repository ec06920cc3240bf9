//! The conclusion in one sentence.

use model_discrepancy::{Closure, HoldOut, ParameterEstimate, Role, Verdict};

use super::{Context, sentence};
use crate::markup::Markup;
use crate::number::{counted, percent, plural, significant, with_expanded};
use crate::reading::rms;
use crate::wording::after_number;

/// Amplitudes of one effect whose sizes the first sentence gives.
const MOST_SIZES: usize = 4;

/// The verdict in words.
pub(crate) fn verdict_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NothingMissing => "nothing missing",
        Verdict::Explained => "explained",
        Verdict::StructureRemains => "structure remains",
        Verdict::NoiseLargerThanDeclared => "more noise than declared",
    }
}

/// What a case is called whose input is wrong.
pub(crate) const INPUT_WRONG: &str = "input wrong";

/// The page's opening: what was found, in one or two sentences.
pub(crate) fn lede(out: &mut Markup, context: &Context) {
    mistakes(out, context);
    out.open("p", &[("class", &"lede")]);
    match context.closure {
        Some(closure) => closed(out, context, closure),
        None => solved(out, context),
    }
    out.close("p");
}

/// What is wrong with the input, before anything else is said.
fn mistakes(out: &mut Markup, context: &Context) {
    for mistake in context.input.mistakes {
        out.open("p", &[("class", &"lede")]);
        out.element("span", &[("class", &"verdict open")], INPUT_WRONG);
        out.text(" ");
        out.name(&mistake.subject);
        out.text(": ");
        out.prose(&sentence(&mistake.description));
        out.close("p");
    }
    if !context.input.mistakes.is_empty() {
        let note = "Whatever follows is of the data as they would be with that corrected, where \
                    it can be; the files are as they were.";
        out.element("p", &[("class", &"quiet")], note);
    }
}

fn closed(out: &mut Markup, context: &Context, closure: &Closure) {
    let verdict = format!("verdict {}", verdict_class(closure.verdict));
    out.element("span", &[("class", &verdict)], verdict_words(closure.verdict));
    out.text(" ");
    let one = closure.steps.len() == 1;
    match closure.verdict {
        Verdict::NothingMissing => out.text("The declared model explains the data."),
        Verdict::Explained => {
            out.text("The declared model lacks ");
            effect_names(out, closure);
            out.text(if one {
                "; with it the data are explained."
            } else {
                "; with them the data are explained."
            });
        }
        Verdict::StructureRemains if closure.steps.is_empty() => {
            out.text("The declared model lacks something that has no name here.");
        }
        Verdict::StructureRemains => {
            out.text("The declared model lacks ");
            effect_names(out, closure);
            out.text(", and something more that has no name here.");
        }
        Verdict::NoiseLargerThanDeclared if closure.steps.is_empty() => {
            out.text("No structure is left, but more noise than was declared.");
        }
        Verdict::NoiseLargerThanDeclared => {
            out.text("The declared model lacks ");
            effect_names(out, closure);
            out.text("; then no structure is left, but more noise than was declared.");
        }
    }
    error_sentence(out, context, closure);
}

fn error_sentence(out: &mut Markup, context: &Context, closure: &Closure) {
    let (before, after) = (closure.before.held_out_rms, closure.after.held_out_rms);
    let unit = &context.shown.unit;
    let shown = |v: f64| significant(context.show(v), 3);
    let how = hold_out_short(context, closure.after.hold_out);
    out.text(" Error ");
    out.text(&how);
    out.text(": ");
    if closure.steps.is_empty() {
        out.element("strong", &[], &format!("{}\u{a0}{unit}", shown(before)));
    } else {
        let text = format!("{} → {}\u{a0}{unit}", shown(before), shown(after));
        out.element("strong", &[], &text);
        out.text(&format!(" ({}).", change(before, after)));
        return;
    }
    out.text(".");
}

/// Change of an error in percent, with its sign.
pub(crate) fn change(before: f64, after: f64) -> String {
    let share = after / before - 1.0;
    if !share.is_finite() {
        return "no change can be given".to_string();
    }
    let sign = if share > 0.0 { "+" } else { "−" };
    format!("{sign}{}", percent(share.abs()))
}

fn effect_names(out: &mut Markup, closure: &Closure) {
    for (i, step) in closure.steps.iter().enumerate() {
        if i > 0 {
            out.text(if i + 1 == closure.steps.len() { " and " } else { ", " });
        }
        out.open("strong", &[]);
        out.name(&super::added::step_name(step));
        out.close("strong");
        match step.indistinguishable_from.len() {
            0 => {}
            1 => out.text(" (or another effect that looks the same here)"),
            n => out.text(&format!(" (or one of {n} effects that look the same here)")),
        }
        let sized = clearest(&step.parameters).into_iter().map(|p| {
            let (value, expanded) = with_expanded(p.value, p.std);
            let name = if step.parameters.len() == 1 { "" } else { &p.name };
            let unit = after_number(&p.unit);
            format!("{name} {value}\u{a0}±\u{a0}{expanded}{unit}").trim().to_owned()
        });
        let sizes: Vec<String> = sized.collect();
        if !sizes.is_empty() {
            let more = match step.parameters.len() - sizes.len() {
                0 => String::new(),
                n => format!(" and {n} less clear"),
            };
            out.text(&format!(", {}{more} (k\u{a0}=\u{a0}2)", sizes.join(", ")));
        }
    }
}

/// The amplitudes that differ most from zero for their uncertainty, in the order of the effect.
fn clearest(parameters: &[ParameterEstimate]) -> Vec<&ParameterEstimate> {
    let share = |k: usize| (parameters[k].value / parameters[k].std).abs();
    let mut order: Vec<usize> = (0..parameters.len()).collect();
    order.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
    order.truncate(MOST_SIZES);
    order.sort_unstable();
    order.into_iter().map(|k| &parameters[k]).collect()
}

fn solved(out: &mut Markup, context: &Context) {
    out.text("The declared model was solved. ");
    if let Some(rms) = rms(&context.before) {
        out.text("Residual: ");
        let text = format!("{}\u{a0}{} rms", significant(rms, 3), context.shown.unit);
        out.element("strong", &[], &text);
        out.text(". ");
    }
    out.text("Whether the model lacks something was not examined: that takes the loop.");
}

fn verdict_class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NothingMissing | Verdict::Explained => "good",
        Verdict::StructureRemains | Verdict::NoiseLargerThanDeclared => "open",
    }
}

/// «on 5 points never fitted», for use inside a sentence.
pub(super) fn hold_out_short(context: &Context, hold_out: HoldOut) -> String {
    let noun = context.input.group_noun;
    match hold_out {
        HoldOut::CheckGroups => {
            format!("on {} never fitted", counted(context.group_count(Role::Check), noun))
        }
        HoldOut::Nested | HoldOut::LeaveOneOut => format!("on {} left out in turn", plural(noun)),
    }
}
