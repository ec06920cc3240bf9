//! `truing loop FOLDER` on the cases of one machine: what is said where they cannot be joined.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::command::{Case, Ended, truing};

/// A folder with committed cases and a `machine.toml`.
fn machine(toml: &str, cases: &[&str]) -> Case {
    let machine = Case::new(&[("machine.toml", toml)]);
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    for case in cases {
        let to = machine.file(&case.replace('/', "-"));
        fs::create_dir_all(&to).unwrap();
        for entry in fs::read_dir(fixtures.join(case)).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
        }
    }
    machine
}

fn closed(machine: &Case, more: &[&str]) -> Ended {
    let folder = machine.path().to_str().unwrap();
    truing(&[&["loop", folder, "--threads", "1"], more].concat())
}

fn listed(cases: &[&str]) -> String {
    cases
        .iter()
        .map(|case| format!("[[case]]\nfolder = \"{}\"\n", case.replace('/', "-")))
        .collect()
}

fn refused(toml: &str, cases: &[&str], expected: &str) {
    let ended = closed(&machine(toml, cases), &["--json"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains(expected), "{}", ended.stderr);
    assert_eq!(ended.stdout, "");
}

const PROBED: &str = "probe-comp/nothing-white";
const TOUCHED: &str = "pose-icp/nothing-white";

#[test]
fn what_cannot_be_joined_is_refused_in_words() {
    let both = listed(&[PROBED, TOUCHED]);
    refused(&listed(&[PROBED]), &[PROBED], "1 cases are listed; a machine needs two at least");
    refused(&listed(&[PROBED, PROBED]), &[PROBED], "is listed twice");
    let outside = format!("{}[[case]]\nfolder = \"../elsewhere\"\n", listed(&[PROBED]));
    refused(&outside, &[PROBED], "lies outside of the machine's folder");
    let missing = format!("{}[[case]]\nfolder = \"mirror\"\n", listed(&[PROBED]));
    refused(&missing, &[PROBED], "mirror");
    let unknown = format!("shared = [\"axis-sale\"]\n{both}");
    refused(
        &unknown,
        &[PROBED, TOUCHED],
        "no two of these cases have `axis-sale`; two or more have",
    );
    let key = format!("share = [\"axis-scale\"]\n{both}");
    refused(&key, &[PROBED, TOUCHED], "line 1");
}

#[test]
fn forces_and_lengths_are_not_joined() {
    let cases = [PROBED, "force-impedance/nothing-coloured"];
    let toml = format!("shared = [\"axis-scale\"]\n{}", listed(&cases));
    refused(&toml, &cases, "no two of these cases have `axis-scale`");
}

#[test]
fn exports_are_for_single_cases() {
    let machine = machine(&listed(&[PROBED, TOUCHED]), &[PROBED, TOUCHED]);
    let ended = closed(&machine, &["--compensation", "table.csv"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("--compensation is for single cases"), "{}", ended.stderr);
    assert!(!Path::new("table.csv").exists());
}

#[test]
fn a_machine_has_a_page_with_every_case() {
    let cases = ["probe-comp/bad-point", TOUCHED];
    let machine = machine(&listed(&cases), &cases);
    let page = machine.file("page.html");
    let ended = closed(&machine, &["--report", page.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let html = fs::read_to_string(&page).unwrap();
    for expected in
        ["2 cases: explained", "probe-comp-bad-point", "pose-icp-nothing-white", "bad-point ["]
    {
        assert!(html.contains(expected), "{expected}");
    }
}

#[test]
fn one_case_is_asked_for_by_the_other_commands() {
    let machine = machine(&listed(&[PROBED, TOUCHED]), &[PROBED, TOUCHED]);
    for verb in ["solve", "check", "plan"] {
        let message = machine.message(verb, 2);
        assert!(message.contains("give one of their folders"), "{message}");
    }
}

/// Two sound machines, one of whose parts was touched with errors of its own: nothing is shared, and
/// each case ends as it does alone.
#[test]
fn what_one_case_shows_stays_with_it() {
    let cases = ["probe-comp/bad-point", TOUCHED];
    let machine = machine(&listed(&cases), &cases);
    let json = machine.json("loop");
    assert_eq!(json["steps"], json!([]));
    assert_eq!(json["cases"][0]["steps"][0]["effect"], "bad-point");
    assert_eq!(json["cases"][0]["with_others"], Value::Null);
    assert_eq!(json["cases"][1]["verdict"], "nothing-missing");
    assert_eq!(json["verdict"], "explained");
    let inputs: Vec<&str> =
        json["inputs"].as_array().unwrap().iter().filter_map(|i| i["file"].as_str()).collect();
    assert!(inputs.contains(&"machine.toml"), "{inputs:?}");
    assert!(inputs.contains(&"probe-comp-bad-point/touches.csv"), "{inputs:?}");
    let text = closed(&machine, &[]).stdout;
    assert!(
        text.starts_with("machine, 2 cases: explained\n  nothing that the cases share"),
        "{text}"
    );
    assert!(text.contains("probe-comp-bad-point, beside it:\n  bad-point ["), "{text}");
}
