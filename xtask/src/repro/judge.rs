//! Compares an answer with what is recorded beside the case.

use serde_json::Value;

use crate::expectation::{Expectation, Number};
use crate::program::{class_of, number_at, strings, without_subject};

/// Everything that is not as expected, one line each.
pub(crate) fn mismatches(expect: &Expectation, closed: &Value, solved: &Value) -> Vec<String> {
    let mut wrong = Vec::new();
    verdict(expect, closed, &mut wrong);
    effects(expect, closed, &mut wrong);
    structure(expect, closed, &mut wrong);
    not_observable(expect, closed, &mut wrong);
    said(expect, closed, solved, &mut wrong);
    held_out(expect, closed, &mut wrong);
    wrong.extend(expect.loop_numbers.iter().filter_map(|number| off(number, "loop", closed)));
    wrong.extend(expect.solve_numbers.iter().filter_map(|number| off(number, "solve", solved)));
    wrong
}

fn verdict(expect: &Expectation, closed: &Value, wrong: &mut Vec<String>) {
    let verdict = closed["verdict"].as_str().unwrap_or("none");
    if !expect.verdict.is_empty() && !expect.verdict.iter().any(|v| v == verdict) {
        wrong.push(format!("verdict {verdict}, expected {}", expect.verdict.join(" or ")));
    }
}

fn effects(expect: &Expectation, closed: &Value, wrong: &mut Vec<String>) {
    let steps = closed["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let in_class = |step: &Value, class: &[String]| {
        class_of(step).iter().any(|named| class.iter().any(|wanted| wanted == named))
    };
    for class in &expect.effects {
        if !steps.iter().any(|step| in_class(step, class)) {
            wrong.push(format!("no effect in {{{}}} was named", class.join(", ")));
        }
    }
    if !expect.nothing_else {
        return;
    }
    for step in steps {
        let effect = step["effect"].as_str().unwrap_or("?");
        let empirical = expect.empirical_allowed
            && class_of(step).iter().any(|name| name.starts_with("covariate:"));
        if !empirical && !expect.effects.iter().any(|class| in_class(step, class)) {
            wrong.push(format!("{effect} was added, which the data do not hold"));
        }
    }
}

fn structure(expect: &Expectation, closed: &Value, wrong: &mut Vec<String>) {
    let mut named = strings(&closed["remaining"], Some("covariate"));
    let steps = closed["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let classes = steps.iter().flat_map(class_of);
    named.extend(classes.filter_map(|effect| effect.strip_prefix("covariate:")));
    for covariates in &expect.structure {
        if !covariates.iter().any(|wanted| named.contains(&wanted.as_str())) {
            wrong.push(format!("no structure was found along {}", covariates.join(" or ")));
        }
    }
}

fn not_observable(expect: &Expectation, closed: &Value, wrong: &mut Vec<String>) {
    let unseen = strings(&closed["not_observable"], Some("effect"));
    for wanted in &expect.not_observable {
        if !unseen.iter().any(|effect| without_subject(effect) == wanted) {
            wrong.push(format!("{wanted} was not called unobservable"));
        }
    }
}

fn said(expect: &Expectation, closed: &Value, solved: &Value, wrong: &mut Vec<String>) {
    let text = format!("{closed}{solved}");
    for phrase in expect.says.iter().filter(|phrase| !text.contains(phrase.as_str())) {
        wrong.push(format!("«{phrase}» was not said"));
    }
}

fn held_out(expect: &Expectation, closed: &Value, wrong: &mut Vec<String>) {
    let Some(bound) = &expect.held_out else { return };
    match number_at(closed, "after.held_out_rms") {
        Some(error) if error <= bound.at_most * bound.noise => {}
        Some(error) => wrong.push(format!(
            "held-out error {error:.5} is {:.2} of the noise, expected at most {}",
            error / bound.noise,
            bound.at_most
        )),
        None => wrong.push("no held-out error".to_owned()),
    }
}

fn off(expected: &Number, command: &str, json: &Value) -> Option<String> {
    let Number { path, value, tolerance, .. } = expected;
    match number_at(json, path) {
        Some(found) if (found - value).abs() <= *tolerance => None,
        Some(found) => {
            Some(format!("{command} {path} = {found:.5}, expected {value} ± {tolerance}"))
        }
        None => Some(format!("{command} has no {path}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expectation::HeldOut;
    use serde_json::json;

    fn expectation() -> Expectation {
        Expectation {
            verdict: vec!["explained".to_owned()],
            effects: vec![vec!["scale".to_owned()]],
            nothing_else: true,
            held_out: Some(HeldOut { noise: 1.0, at_most: 1.2 }),
            ..Expectation::default()
        }
    }

    #[test]
    fn a_good_answer_passes_and_every_flaw_is_told() {
        let good = json!({
            "verdict": "explained", "after": { "held_out_rms": 1.1 },
            "steps": [ { "effect": "shear", "indistinguishable_from": ["scale"] } ]
        });
        assert!(mismatches(&expectation(), &good, &Value::Null).is_empty());
        let bad = json!({
            "verdict": "nothing-missing", "after": { "held_out_rms": 1.3 },
            "steps": [ { "effect": "drift", "indistinguishable_from": [] } ]
        });
        assert_eq!(mismatches(&expectation(), &bad, &Value::Null).len(), 4);
    }
}
