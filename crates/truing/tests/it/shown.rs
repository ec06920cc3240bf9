//! What an answer for people shows, and how much of it.

use std::fs;
use std::path::Path;

use crate::command::{Case, truing};

#[test]
fn the_verdict_comes_first_and_details_are_asked_for() {
    let case = Case::example("frame-fit");
    let path = case.path().to_str().unwrap();
    let shown = |flags: &[&str]| {
        let ended = truing(&[&["loop", path], flags].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stdout
    };
    let (quiet, usual, full) = (shown(&["-q"]), shown(&[]), shown(&["--verbose"]));
    for text in [&quiet, &usual, &full] {
        assert!(text.starts_with("frame-fit: explained\n  scale — "), "{text}");
        assert!(text.contains("error on data the fit never saw: "), "{text}");
    }
    assert_eq!(quiet.lines().count(), 3, "{quiet}");
    assert!(usual.starts_with(&quiet) && full.starts_with(&quiet));
    // Tests and steps are details; what was solved for is not.
    assert!(usual.contains("\nestimates\n") && !usual.contains("chi2/dof"), "{usual}");
    assert!(full.contains("chi2/dof") && full.contains("added 1: scale"), "{full}");
    let refused = truing(&["loop", path, "-q", "-v"]);
    assert_eq!(refused.code, 2);
}

#[test]
fn quiet_commands_still_warn() {
    let case = Case::example("tracker-lm");
    let path = case.path().to_str().unwrap();
    let (usual, quiet) = (truing(&["loop", path]), truing(&["loop", path, "--quiet"]));
    assert!(usual.stderr.contains("warning: "), "{}", usual.stderr);
    assert_eq!(usual.stderr, quiet.stderr);
    let solved = truing(&["solve", path, "--quiet"]);
    assert_eq!(solved.stdout.lines().count(), 1, "{}", solved.stdout);
    assert!(solved.stdout.starts_with("tracker-lm: residual "), "{}", solved.stdout);
}

#[test]
fn the_first_page_shows_what_is_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = fs::read_to_string(root.join("README.md")).unwrap();
    let case = Case::example("frame-fit");
    let printed = truing(&["loop", case.path().to_str().unwrap()]).stdout;
    let head: Vec<&str> =
        printed.lines().take_while(|line| !line.starts_with("residual")).collect();
    let block = head.join("\n");
    assert!(page.contains(block.trim_end()), "README.md does not show\n{block}");
}
