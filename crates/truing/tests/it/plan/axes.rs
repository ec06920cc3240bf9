//! Readings of a linear axis.

use std::fmt::Write as _;

use super::{json, noise_mm};
use crate::command::Case;

/// An axis that stops 8 µm apart from either side, sent to its targets from below.
fn one_sided() -> Case {
    let mut table = String::from("target_mm,actual_mm,direction\n");
    for i in 0..18_u32 {
        let target = f64::from(i % 9) * 40.0;
        let _ = writeln!(table, "{target},{:.5},+1", target + noise_mm(i as usize));
    }
    let toml = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\n[plan]\ncycles = 2\n";
    Case::new(&[("case.toml", toml), ("positions.csv", &table)])
}

#[test]
fn an_axis_sent_from_one_side_is_sent_from_the_other() {
    let case = one_sided();
    let answer = json(&case, &["--for", "reversal"]);
    let planned = answer["plan"].as_array().unwrap();
    let falling = planned.iter().filter(|one| one["cells"]["direction"] == -1.0).count();
    assert!(falling >= 2, "{planned:?}");
    let of = |key: &str| answer["predicted"][key].as_f64().unwrap();
    // From one side half of the reversal shows, as an offset of the declared noise; from both all of it:
    // with as many readings again the scatter of its size is 1/√2.
    assert!(of("after") < 0.71 * of("before"), "{}", answer["predicted"]);
    // The rows of the table: where to go, and nothing read.
    let rows = answer["measurements"].as_array().unwrap();
    assert_eq!(rows.len(), planned.len());
    for row in rows {
        assert_eq!(row["actual_mm"], "", "{row}");
        assert!(row["target_mm"].as_str().unwrap().parse::<f64>().is_ok(), "{row}");
    }
    assert!(answer["program"].is_null());
    case.replace("case.toml", "cycles = 2", "directions = \"rising\"");
    let rising = json(&case, &["--for", "reversal"]);
    // From one side half of it is an offset like any other: it is seen, and not told from these.
    let with = rising["classes"][0]["with"].to_string();
    assert!(with.contains("datum-offset"), "{rising}");
    assert!(rising["warnings"].to_string().contains("no reading tells reversal from"), "{rising}");
}
