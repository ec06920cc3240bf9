//! Plans for committed cases.

use std::path::Path;

use serde_json::Value;

use crate::command::truing;

/// A plan for a committed case, which is not written to.
fn of_committed(case: &str, aim: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(case);
    let ended = truing(&["plan", folder.to_str().unwrap(), "--for", aim, "--json"]);
    assert_eq!(ended.code, 0, "{case}: {}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn of_two_loads_a_third_between_them_is_on_offer() {
    let answer = of_committed("ft-center/moment-bias-two-loads", "rivals");
    assert_eq!(answer["reached"], true, "{}", answer["would"]);
    let loads: Vec<f64> = (answer["plan"].as_array().unwrap().iter())
        .map(|one| one["cells"]["load_n"].as_f64().unwrap())
        .collect();
    // It was pressed with 20 and 60 N.
    assert!(loads.iter().any(|load| (30.0..50.0).contains(load)), "{loads:?}");
}

#[test]
fn what_no_measurement_answers_is_not_asked_of_anybody() {
    for (case, aim, said) in [
        // Both add to the force of the axial unit.
        ("force-impedance/axial-zero", "rivals", "by `leans_deg`, `loads_n`, `axial_mm_per_s`"),
        ("ft-center/force-gain", "rivals", "measure the machine's travel"),
        (
            "ft-center/bias-drift",
            "unobservable",
            "datum-offset does what frame translation x and frame translation y do, and is in these",
        ),
        ("probe-comp/bending", "unobservable", "`measured_feed_mm_per_min`"),
    ] {
        let answer = of_committed(case, aim);
        assert_eq!((&answer["planned"], &answer["reached"]), (&0.into(), &false.into()), "{case}");
        let would = answer["would"].as_str().unwrap();
        assert!(would.contains(said), "{case}: {would}");
        assert!(!would.contains("every test of the plan is met"), "{case}: {would}");
    }
}
