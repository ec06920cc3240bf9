//! `truing init`: what it writes must solve, close the loop and check as it is.

use std::fs;

use crate::command::{Case, truing};

/// What is hidden in the example of every kind: one name of the step, or of its rivals.
const HIDDEN: [(&str, &str); 7] = [
    ("frame-fit", "scale"),
    ("ft-center", "moment-gain"),
    ("tracker-lm", "dead-path-jump [S2-R2 at 6]"),
    ("pose-icp", "drift"),
    ("probe-comp", "drift"),
    ("force-impedance", "leg-gain"),
    ("positioning", "reversal"),
];

#[test]
fn every_example_runs_as_it_is_and_its_first_loop_finds_what_is_hidden_in_it() {
    let kinds: Vec<&str> = truing::kinds().map(|(kind, _)| kind).collect();
    assert_eq!(kinds, HIDDEN.map(|(kind, _)| kind), "every kind hides something");
    for (kind, hidden) in HIDDEN.into_iter().chain([("tracker-lm-targets", "station-drift")]) {
        let case = Case::new(&[]);
        let folder = case.file("new/case");
        let folder = folder.to_str().unwrap();
        let written = truing(&["init", kind, folder]);
        assert_eq!(written.code, 0, "{kind}: {}", written.stderr);
        for command in ["solve", "loop", "check"] {
            let ended = truing(&[command, folder]);
            assert_eq!(ended.code, 0, "{command} {kind}: {}", ended.stderr);
            assert!(kind.starts_with(first_word(&ended.stdout)));
        }
        let found = truing(&["loop", folder, "--json"]).stdout;
        let found: serde_json::Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found["verdict"], "explained", "{kind}");
        let step = &found["steps"][0];
        let rivals = step["indistinguishable_from"].as_array().unwrap();
        let is_named = step["effect"] == hidden || rivals.iter().any(|rival| rival == hidden);
        assert!(is_named, "{kind}: {step}");
        let error = |which: &str| found[which]["held_out_rms"].as_f64().unwrap();
        assert!(error("after") < 0.8 * error("before"), "{kind}");
    }
}

#[test]
fn nothing_is_overwritten() {
    let case = Case::new(&[("pairs.csv", "mine\n")]);
    let folder = case.path().to_str().unwrap();
    let refused = truing(&["init", "frame-fit", folder]);
    assert_eq!(refused.code, 2);
    assert!(refused.one_message().ends_with("pairs.csv exists already; choose another folder"));
    assert_eq!(fs::read_to_string(case.file("pairs.csv")).unwrap(), "mine\n");
    assert!(!case.file("case.toml").exists(), "nothing is written beside it either");
}

#[test]
fn unknown_kinds_are_named_with_the_known_ones() {
    let refused = truing(&["init", "frame-fot"]);
    assert_eq!(refused.code, 2);
    assert_eq!(
        refused.one_message(),
        "unknown kind `frame-fot`; did you mean `frame-fit`?; the kinds are frame-fit, ft-center, \
         tracker-lm, pose-icp, probe-comp, force-impedance, positioning, tracker-lm-targets"
    );
}

/// The kind, which a colon parts from the verdict of a loop.
fn first_word(text: &str) -> &str {
    text.split_whitespace().next().unwrap().trim_end_matches(':')
}
