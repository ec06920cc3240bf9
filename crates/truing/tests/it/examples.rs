//! `truing init`: what it writes must solve, close the loop and check as it is.

use std::fs;

use crate::command::{Case, truing};

#[test]
fn every_example_solves_as_it_is() {
    for (kind, _) in truing::kinds() {
        let case = Case::new(&[]);
        let folder = case.file("new/case");
        let folder = folder.to_str().unwrap();
        let written = truing(&["init", kind, folder]);
        assert_eq!(written.code, 0, "{kind}: {}", written.stderr);
        for command in ["solve", "loop", "check"] {
            let ended = truing(&[command, folder]);
            assert_eq!(ended.code, 0, "{command} {kind}: {}", ended.stderr);
            assert_eq!(ended.stderr, "", "{command} {kind} has nothing to warn of");
            assert!(ended.stdout.starts_with(kind));
        }
        let found = truing(&["loop", folder, "--json"]).stdout;
        assert!(found.contains("\"verdict\": \"nothing-missing\""), "{kind}: {found}");
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
