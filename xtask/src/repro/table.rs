//! What the terminal shows: measured data set by set, simulated cases by kind, and a count.

use std::collections::BTreeMap;

use serde_json::Value;

use super::Outcome;
use crate::program::{class_of, number_at};

/// A terminal has at least this many columns.
const WIDTH: usize = 120;
/// Where the text of a line starts.
const INDENT: usize = 14;

/// Prints everything; the last line is the count.
pub(crate) fn print(outcomes: &[Outcome]) {
    for line in lines(outcomes) {
        println!("{line}");
    }
}

/// Every line, none wider than a terminal.
fn lines(outcomes: &[Outcome]) -> Vec<String> {
    let mut lines = vec!["measured data".to_owned(), String::new()];
    for outcome in outcomes.iter().filter(|o| o.provenance.seed.is_none()) {
        lines.extend(measured(outcome));
        lines.push(String::new());
    }
    let mut kinds: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes.iter().filter(|o| o.provenance.seed.is_some()) {
        let kind = outcome.name.split('/').next().unwrap_or_default();
        kinds.entry(kind).or_default().push(outcome);
    }
    lines.push("simulated cases, known to be so".to_owned());
    lines.push(String::new());
    for (kind, outcomes) in &kinds {
        lines.push(folded(kind, outcomes));
    }
    lines.push(String::new());
    for outcome in outcomes {
        for mismatch in &outcome.mismatches {
            lines.extend(wrapped("", &format!("{}: {mismatch}", outcome.name), 2));
        }
    }
    lines.push("report: target/repro/report.html".to_owned());
    lines.push(format!("{} of {} as recorded", as_recorded(outcomes.iter()), outcomes.len()));
    lines
}

fn as_recorded<'o>(outcomes: impl Iterator<Item = &'o Outcome>) -> usize {
    outcomes.filter(|outcome| outcome.mismatches.is_empty()).count()
}

/// What a set is, what it is asked, the error, what was named, and what stays open.
fn measured(outcome: &Outcome) -> Vec<String> {
    let (provenance, json) = (&outcome.provenance, &outcome.loop_json);
    let mark = if outcome.mismatches.is_empty() { "as recorded" } else { "NOT AS RECORDED" };
    let mut lines = wrapped("", &format!("{}: {}, {mark}", outcome.name, provenance.title), 2);
    let verdict = json["verdict"].as_str().unwrap_or("–");
    let found = [
        ("question", provenance.question.clone()),
        ("unseen data", Some(change(json, "held_out_rms"))),
        ("independent", provenance.independent.clone()),
        ("published", provenance.published.clone()),
        ("named", Some(format!("{}; verdict {verdict}", named(json)))),
        ("open", provenance.open.clone()),
    ];
    for (name, text) in found {
        lines.extend(text.iter().flat_map(|text| wrapped(&format!("  {name}"), text, INDENT)));
    }
    lines
}

fn folded(kind: &str, outcomes: &[&Outcome]) -> String {
    let all = outcomes.len();
    let good = as_recorded(outcomes.iter().copied());
    let verdict = |wanted: &str| {
        outcomes.iter().filter(|o| o.loop_json["verdict"].as_str() == Some(wanted)).count()
    };
    format!(
        "{kind:<16}{all:>3} cases, {good:>3} as recorded: {:>2} explained, {:>2} nothing missing, \
         {:>2} other",
        verdict("explained"),
        verdict("nothing-missing"),
        all - verdict("explained") - verdict("nothing-missing")
    )
}

/// Text behind a name, broken at spaces, further lines indented.
fn wrapped(name: &str, text: &str, indent: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = if name.is_empty() { String::new() } else { format!("{name:<indent$}") };
    let mut is_empty = true;
    for word in text.split_whitespace() {
        let needed = usize::from(!is_empty) + word.chars().count();
        if !is_empty && line.chars().count() + needed > WIDTH {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    lines.push(line);
    lines
}

fn change(json: &Value, key: &str) -> String {
    let error = |when: &str| number_at(json, &format!("{when}.{key}"));
    let (Some(before), Some(after)) = (error("before"), error("after")) else {
        return "–".to_owned();
    };
    match json["before"]["unit"].as_str() {
        Some("mm") if before < 0.1 => format!("{:.2} → {:.2} µm", before * 1e3, after * 1e3),
        unit => format!("{before:.4} → {after:.4} {}", unit.unwrap_or("")),
    }
}

fn named(json: &Value) -> String {
    let steps = json["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let carried = json["carried"]["effects"].as_array().map_or(&[][..], Vec::as_slice);
    let carried = carried.iter().map(|effect| format!("{} carried", step_name(effect)));
    let classes: Vec<String> = carried.chain(steps.iter().map(step_name)).collect();
    if classes.is_empty() { "nothing".to_owned() } else { classes.join(", ") }
}

/// The effect first, what it is about, then those it cannot be told from.
fn step_name(step: &Value) -> String {
    let subject = step["subject"].as_str().map(|s| format!(" [{s}]")).unwrap_or_default();
    let mut class: Vec<String> = class_of(step).into_iter().map(str::to_owned).collect();
    class.rotate_right(1);
    if let Some(own) = class.first_mut() {
        own.push_str(&subject);
    }
    class.join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expectation::Provenance;
    use serde_json::json;

    fn outcome(name: &str, seed: Option<u64>, mismatches: &[&str]) -> Outcome {
        let long = "a word of some length, ".repeat(20);
        let provenance = Provenance {
            title: format!("Case {name}"),
            seed,
            question: Some(long),
            ..Provenance::default()
        };
        let loop_json = json!({
            "verdict": "explained",
            "before": { "held_out_rms": 2.0, "unit": "mm" }, "after": { "held_out_rms": 0.5 },
            "steps": [ { "effect": "bad-point", "subject": "P1", "indistinguishable_from": [] } ]
        });
        let mismatches = mismatches.iter().map(|&m| m.to_owned()).collect();
        Outcome { name: name.to_owned(), provenance, loop_json, mismatches }
    }

    #[test]
    fn measured_data_come_first_and_the_count_comes_last() {
        let outcomes = [
            outcome("frame-fit/measured", None, &[]),
            outcome("frame-fit/simulated", Some(1), &["verdict explained, expected none"]),
        ];
        let lines = lines(&outcomes);
        let at = |text: &str| lines.iter().position(|line| line.contains(text)).unwrap();
        assert!(at("frame-fit/measured: Case") < at("1 cases,   0 as recorded"));
        assert!(lines[at("named")].contains("bad-point [P1]; verdict explained"));
        assert!(at("2.0000 → 0.5000 mm") < at("frame-fit/simulated: verdict explained, expected"));
        assert_eq!(lines.last().unwrap(), "1 of 2 as recorded");
        assert!(lines.iter().all(|line| line.chars().count() <= WIDTH));
    }
}
