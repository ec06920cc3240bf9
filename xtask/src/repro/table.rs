//! The table of error before → after.

use serde_json::Value;

use super::Outcome;
use crate::program::{class_of, number_at, strings};

const HEADER: [&str; 8] = [
    "case",
    "source",
    "published",
    "train before → after",
    "held out before → after",
    "named",
    "verdict",
    "",
];

/// Prints the table, then each mismatch.
pub(crate) fn print(outcomes: &[Outcome]) {
    let mut lines = vec![HEADER.map(str::to_owned)];
    lines.extend(outcomes.iter().map(line));
    let widths: Vec<usize> = (0..HEADER.len())
        .map(|column| lines.iter().map(|l| l[column].chars().count()).max().unwrap_or(0))
        .collect();
    for line in &lines {
        let cells: Vec<String> =
            line.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}")).collect();
        println!("{}", cells.join("  ").trim_end());
    }
    println!();
    for outcome in outcomes {
        details(outcome);
    }
    for outcome in outcomes {
        for mismatch in &outcome.mismatches {
            println!("{}: {mismatch}", outcome.name);
        }
    }
}

/// What was added to a published case, and everywhere how rivals could be told apart.
fn details(outcome: &Outcome) {
    let steps = outcome.loop_json["steps"].as_array().map_or(&[][..], Vec::as_slice);
    for step in steps {
        let mut parts = Vec::new();
        if outcome.provenance.published.is_some() {
            parts.extend(step["parameters"].as_array().into_iter().flatten().map(parameter));
            parts.extend(step["p_value"].as_f64().map(|p| format!("p = {p:.2e}")));
        }
        if let Some(how) = step["separate_by"].as_str() {
            parts.push(format!("told apart by: {how}"));
        }
        if !parts.is_empty() {
            println!("{}: {}: {}", outcome.name, step_name(step), parts.join("; "));
        }
    }
    if outcome.provenance.published.is_some() {
        for warning in strings(&outcome.loop_json["warnings"], None) {
            println!("{}: {warning}", outcome.name);
        }
    }
}

fn parameter(parameter: &Value) -> String {
    let number = |key: &str| parameter[key].as_f64().unwrap_or(f64::NAN);
    let text = |key: &str| parameter[key].as_str().unwrap_or_default();
    format!("{} = {:.4} ± {:.4} {}", text("name"), number("value"), number("std"), text("unit"))
}

fn line(outcome: &Outcome) -> [String; 8] {
    let json = &outcome.loop_json;
    let source = match outcome.provenance.seed {
        Some(seed) => format!("simulated, seed {seed}"),
        None => outcome.provenance.source.clone(),
    };
    [
        outcome.name.clone(),
        source,
        outcome.provenance.published.clone().unwrap_or_else(|| "–".to_owned()),
        change(json, "train_rms"),
        change(json, "held_out_rms"),
        named(json),
        json["verdict"].as_str().unwrap_or("–").to_owned(),
        if outcome.mismatches.is_empty() { "ok" } else { "MISMATCH" }.to_owned(),
    ]
}

fn change(json: &Value, key: &str) -> String {
    let error = |when: &str| number_at(json, &format!("{when}.{key}"));
    let (Some(before), Some(after)) = (error("before"), error("after")) else {
        return "–".to_owned();
    };
    match json["before"]["unit"].as_str() {
        Some("mm") if before < 0.1 => format!("{:.2} → {:.2} µm", before * 1e3, after * 1e3),
        unit => format!("{before:.3} → {after:.3} {}", unit.unwrap_or("")),
    }
}

fn named(json: &Value) -> String {
    let steps = json["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let classes: Vec<String> = steps.iter().map(step_name).collect();
    if classes.is_empty() { "nothing".to_owned() } else { classes.join(", ") }
}

/// The effect first, then those it cannot be told from.
fn step_name(step: &Value) -> String {
    let mut class = class_of(step);
    class.rotate_right(1);
    class.join(" | ")
}
