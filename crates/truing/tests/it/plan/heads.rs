//! Runs of a polishing head.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{json, message};
use crate::command::Case;

#[test]
fn a_late_reference_is_seen_where_the_load_changes() {
    let case = Case::example("force-impedance");
    let plan = "\n[noise]\n";
    case.replace(
        "case.toml",
        plan,
        &format!("\n[plan]\nloads_n = [20, 60]\nseconds = 0.5\n{plan}"),
    );
    let folder = case.file("next");
    let written = ["--for", "delay", "--budget", "6", "--out", folder.to_str().unwrap()];
    let answer = json(&case, &written);
    let planned = answer["plan"].as_array().unwrap();
    assert!((1..=6).contains(&planned.len()), "{planned:?}");
    // Under a load that stands still nobody sees when it was read.
    let changes = |run: &&Value| run["cells"]["load_from_n"] != run["cells"]["load_to_n"];
    assert!(2 * planned.iter().filter(changes).count() > planned.len(), "{planned:?}");
    let of = |key: &str| answer["predicted"][key].as_f64().unwrap();
    assert!(of("after") < of("before"), "{}", answer["predicted"]);
    // A controller writes the log: what it is to do is one row a run, and nothing to be filled in.
    let rows = answer["measurements"].as_array().unwrap();
    assert_eq!(rows.len(), planned.len());
    assert_eq!(rows[0]["segment"], "N1");
    let log = |folder: &Path| fs::read_to_string(folder.join("log.csv")).unwrap();
    assert_eq!(log(&folder), log(case.path()));
    let runs = fs::read_to_string(folder.join("plan.csv")).unwrap();
    assert_eq!(runs.lines().count(), 1 + planned.len());
    assert!(runs.starts_with("segment,nx,ny,nz,lean_deg,lean_towards_deg,load_from_n,load_to_n,"));
}

#[test]
fn what_a_head_cannot_do_is_said() {
    for (plan, said) in [
        ("loads_n = [-3]", "expected a force from 0 on, found -3"),
        ("leans_deg = [200]", "expected an angle from upright, from 0 to 180, found 200"),
        ("leans_deg = [170]", "`[plan]` leaves no place to measure at"),
    ] {
        let case = Case::example("force-impedance");
        case.replace("case.toml", "\n[noise]\n", &format!("\n[plan]\n{plan}\n\n[noise]\n"));
        let told = message(&case, &["--for", "delay"]);
        assert!(told.contains(said), "{plan}: {told}");
    }
}
