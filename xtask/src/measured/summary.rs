//! One line per set: before, after, and what was named.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use serde_json::Value;

use super::{Outcome, Set};

/// Prints what the loop made of one set.
pub(super) fn print(set: &Set, outcomes: &[Outcome]) {
    println!("{} (left out: {})", set.name, set.left_out);
    for outcome in outcomes {
        let [before, after] = ["before", "after"].map(|key| error(&outcome.answer, key));
        let unit = outcome.answer["before"]["unit"].as_str().unwrap_or("");
        println!(
            "  {}: {before:.4} -> {after:.4} {unit}, {}",
            outcome.case,
            named(&outcome.answer)
        );
        if let Some(line) = carried(&outcome.answer) {
            println!("    {line}");
        }
        for note in &outcome.notes {
            println!("    {note}");
        }
    }
    println!("  independent calculation: {}", set.reference);
}

/// Effects of another case, and the error without and with them where only the pose was fitted.
fn carried(answer: &Value) -> Option<String> {
    let carried = answer["carried"].as_object()?;
    let fitted = |key: &str| carried[key]["train_rms"].as_f64().unwrap_or(f64::NAN);
    let names = carried["effects"].as_array().map_or(&[][..], Vec::as_slice);
    let names: Vec<&str> = names.iter().filter_map(|e| e["effect"].as_str()).collect();
    Some(format!(
        "carried: {}; base model fitted to the same data: {:.4} -> {:.4}; with what the loop adds \
         to it here, held out: {:.4}",
        names.join(", "),
        fitted("without"),
        fitted("with"),
        answer["after"]["held_out_rms"].as_f64().unwrap_or(f64::NAN)
    ))
}

/// All sets as a table in Markdown: medians over the cases of a set.
///
/// Where effects are carried, over the cases that they are carried to: the error without and with
/// them, the pose of groups that are left out coming from the others.
///
/// «After» repeats the choice of effects without the groups that are judged; with the choice fixed,
/// only the fit is repeated, as in the independent calculation.
pub(super) fn markdown(found: &[(&Set, Vec<Outcome>)]) -> String {
    let mut text =
        "| set | cases | left out | before | after | after, choice fixed | independent calculation | found |\n\
                    |---|---|---|---|---|---|---|---|\n"
            .to_owned();
    for (set, outcomes) in found {
        let outcomes = &judged(outcomes);
        let middle = |of: &dyn Fn(&Value) -> f64| median(outcomes.iter().map(|o| of(&o.answer)));
        let (before, after) = (middle(&|a| error(a, "before")), middle(&|a| error(a, "after")));
        let (fixed, unit) = (middle(&choice_fixed), unit(&outcomes[0].answer));
        // A string takes every character.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {before:.4} {unit} | {after:.4} {unit} | {fixed:.4} {unit} | {} | {} |",
            set.name,
            outcomes.len(),
            set.left_out,
            set.reference,
            effects(outcomes)
        );
    }
    text
}

/// The cases that a set is about: those that effects are carried to, where there are any.
fn judged(outcomes: &[Outcome]) -> Vec<&Outcome> {
    let carrying: Vec<&Outcome> =
        outcomes.iter().filter(|o| o.answer["carried"].is_object()).collect();
    if carrying.is_empty() { outcomes.iter().collect() } else { carrying }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Error on groups left out in turn with the effects that all the data chose.
fn choice_fixed(answer: &Value) -> f64 {
    if answer["carried"].is_object() {
        return answer["carried"]["with"]["train_rms"].as_f64().unwrap_or(f64::NAN);
    }
    let last = answer["steps"].as_array().and_then(|steps| steps.last());
    // With nothing added there is no choice to fix.
    last.map_or_else(|| error(answer, "after"), |s| s["held_out_rms"].as_f64().unwrap_or(f64::NAN))
}

fn unit(answer: &Value) -> &str {
    answer["before"]["unit"].as_str().unwrap_or("")
}

fn error(answer: &Value, key: &str) -> f64 {
    let summary = match (key, &answer["carried"]) {
        ("before", carried) if carried.is_object() => &carried["without"],
        ("after", carried) if carried.is_object() => &carried["with"],
        _ => &answer[key],
    };
    summary["held_out_rms"].as_f64().unwrap_or(f64::NAN)
}

/// How many cases each class of effects was added in.
fn effects(outcomes: &[&Outcome]) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for outcome in outcomes {
        for class in classes(&outcome.answer).into_iter().collect::<BTreeSet<_>>() {
            *counts.entry(class).or_default() += 1;
        }
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    let all = outcomes.len();
    let lines: Vec<String> = counts
        .iter()
        .map(|(class, n)| if all == 1 { class.clone() } else { format!("{class} in {n} of {all}") })
        .collect();
    if lines.is_empty() { "nothing".to_owned() } else { lines.join("; ") }
}

fn named(answer: &Value) -> String {
    let classes = classes(answer);
    let verdict = answer["verdict"].as_str().unwrap_or("");
    if classes.is_empty() {
        verdict.to_owned()
    } else {
        format!("{}: {verdict}", classes.join("; "))
    }
}

/// Names of each step, its rivals beside it.
fn classes(answer: &Value) -> Vec<String> {
    if let Some(effects) = answer["carried"]["effects"].as_array() {
        return effects.iter().map(|e| format!("{} carried", class(e))).collect();
    }
    let steps = answer["steps"].as_array().map_or(&[][..], Vec::as_slice);
    steps.iter().map(class).collect()
}

/// The name of an effect with those of its rivals.
fn class(effect: &Value) -> String {
    let text = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let rivals = effect["indistinguishable_from"].as_array().map_or(&[][..], Vec::as_slice);
    let names = std::iter::once(&effect["effect"]).chain(rivals).map(text);
    names.collect::<Vec<_>>().join(" or ")
}
