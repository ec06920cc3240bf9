//! Results held against limits, and the forms that say so.

use serde_json::Value;

use crate::command::{Case, truing};

/// Digits of the tables of the normal distribution.
const TABLE: f64 = 1e-4;

fn limited(kind: &str, limits: &str) -> Case {
    let case = Case::example(kind);
    let toml = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", format!("{toml}\n[conformity]\nlimits = {{ {limits} }}\n"));
    case
}

fn page(case: &Case, command: &str) -> String {
    let (path, page) = (case.path().to_str().unwrap(), case.file("page.html"));
    let ended = truing(&[command, path, "--report", page.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    std::fs::read_to_string(page).unwrap()
}

fn figure(answer: &Value, symbol: &str) -> [f64; 2] {
    let figures = answer["estimates"]["run"]["figures"].as_array().unwrap();
    let figure = figures.iter().find(|figure| figure["symbol"] == symbol).unwrap();
    ["value", "std"].map(|key| figure[key].as_f64().unwrap())
}

#[test]
fn a_result_passes_as_far_from_its_limit_as_its_guard_band() {
    let [accuracy, std] = figure(&Case::example("positioning").json("solve"), "A");
    for (share, decision) in
        [(1.7, "pass"), (1.6, "undecided"), (-1.6, "undecided"), (-1.7, "fail")]
    {
        let limit = accuracy + share * std;
        let answer = limited("positioning", &format!("A = {limit}")).json("solve");
        let decided = &answer["conformity"][0];
        assert_eq!((&decided["parameter"], &decided["unit"]), (&"A".into(), &"mm".into()));
        assert_eq!(decided["decision"], decision, "{decided}");
        // The noise is declared: the 95 % point of the normal distribution.
        let guard = decided["guard_band"].as_f64().unwrap() / std;
        assert!((guard - 1.6449).abs() < TABLE, "{decided}");
    }
}

#[test]
fn limits_name_results_and_nothing_else() {
    let case = limited("positioning", "Aa = 0.01");
    let message = case.message("solve", 2);
    assert!(message.contains("case.toml, line"), "{message}");
    assert!(message.contains("`Aa`") && message.contains("`A`"), "{message}");
    let case = limited("positioning", "A = -0.01");
    assert!(case.message("solve", 2).contains("expected a number between"));
    case.replace("case.toml", "limits = { A = -0.01 }", "limit = { A = 0.01 }");
    assert!(case.message("check", 2).contains("unknown key `limit`"));
    let case = limited("positioning", "A = 0.01");
    case.replace("case.toml", "[conformity]", "[conformity]\nconformance = 0.4");
    assert!(case.message("loop", 2).contains("above 0.5 and below 1"));
}

#[test]
fn the_form_of_a_positioning_test_says_who_and_what_passes() {
    let case = limited("positioning", "A = 1.0, M = 1e-9, \"A, effects taken off\" = 1e-9");
    case.write(
        "provenance.toml",
        "machine = \"M <1>\"\ndate = 2026-03-01\n[temperatures]\nair_c = 20.3\n",
    );
    let page = page(&case, "loop");
    for expected in [
        "Test of positioning (ISO 230-2)",
        "M &lt;1&gt;",
        "2026-03-01",
        "air 20.3 °C",
        "not declared",
        ">pass<",
        ">fail<",
        "Decision rule",
        "The same with the named effects taken off",
    ] {
        assert!(page.contains(expected), "{expected}");
    }
}

#[test]
fn every_kind_takes_limits_and_has_a_form_for_them() {
    let named = [
        ("frame-fit", "x = 1000.0"),
        ("pose-icp", "x = 1000.0"),
        ("tracker-lm", "EXB = 1000.0"),
        ("ft-center", "\"frame angle\" = 1000.0"),
    ];
    for (kind, limits) in named {
        let case = limited(kind, limits);
        let answer = case.json("loop");
        assert_eq!(answer["conformity"][0]["decision"], "pass", "{kind}: {}", answer["conformity"]);
        assert!(page(&case, "solve").contains(">pass<"), "{kind}");
    }
}

#[test]
fn the_form_of_an_axis_has_the_range_of_every_error() {
    let case = Case::example("tracker-lm");
    let solved = case.json("solve");
    let errors = solved["estimates"]["axis_errors"].as_array().unwrap();
    let all = |key: &str| errors.iter().map(|e| e[key].as_f64().unwrap()).collect::<Vec<_>>();
    let range = |values: Vec<f64>| {
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let letter = solved["estimates"]["axis"]["letter"].as_str().unwrap();
    for (key, name, factor) in [("e_x_mm", "EX", 1e3), ("e_b_rad", "EB", 1e6)] {
        let limited = limited("tracker-lm", &format!("{name}{letter} = 1000.0")).json("solve");
        let found = limited["conformity"][0]["value"].as_f64().unwrap();
        let expected = factor * range(all(key));
        assert!((found - expected).abs() < 1e-9 * expected, "{name}: {found} {expected}");
    }
}
