//! The documents' own methods from the command line: ITLICP of [D], the micro-plane of [E].

use serde_json::Value;

use crate::command::{Ended, truing};

const PUBLISHED: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pose-icp/published-d-table-4");

fn itlicp(case: &str, more: &[&str]) -> Ended {
    truing(&[&["itlicp", case], more].concat())
}

/// Both find the published points to what their last digit allows, and the exact pose is never worse.
#[test]
fn the_published_points_are_found_by_both_methods() {
    let ended = itlicp(PUBLISHED, &["--fine", "0.01", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let json: Value = serde_json::from_str(&ended.stdout).unwrap();
    let rms = |method: &str| json[method]["rms_mm"].as_f64().unwrap();
    assert!(rms("exact") <= rms("itlicp") && rms("itlicp") < 0.007, "{json}");
    assert_eq!(json["points"].as_array().unwrap().len(), 8);
    // π D²/4 Δw² of 1 mm on Φ100, and (Δw/Δw1)² about each of eight touches.
    let points = |level: usize| json["levels"][level]["model_points"].as_f64().unwrap();
    assert!((points(0) / 7854.0 - 1.0).abs() < 0.01, "{}", points(0));
    assert!((points(1) / 80_000.0 - 1.0).abs() < 0.02, "{}", points(1));
    let text = itlicp(PUBLISHED, &["--fine", "0.01"]).stdout;
    assert!(text.starts_with("ITLICP [D]: "), "{text}");
    assert!(text.contains("-284.8742"), "five decimals of z: {text}");
}

#[test]
fn what_cannot_be_sampled_is_refused_in_words() {
    let coarse = itlicp(PUBLISHED, &["--classical", "0.0001"]);
    assert_eq!(coarse.code, 2);
    assert!(coarse.stderr.contains("points"), "{}", coarse.stderr);
    let other = itlicp(&PUBLISHED.replace("pose-icp/published-d-table-4", "frame-fit/scale"), &[]);
    assert!(other.stderr.contains("give one of kind pose-icp"), "{}", other.stderr);
}

#[test]
fn the_micro_plane_balances_curvature_and_noise() {
    let words = ["design", "micro-plane", "--curvatures", "-0.02,0", "--noise", "0.001", "--json"];
    let ended = truing(&words);
    let json: Value = serde_json::from_str(&ended.stdout).unwrap();
    let of = |key: &str| json[key].as_f64().unwrap();
    // A cylinder of R 50 outside: its offset by r = 3 has κ' = 1/53; ρ² = 4 √(4/3) σ/κ', and both
    // parts of what is missed are alike.
    let radius_mm = (4.0 * (4.0_f64 / 3.0).sqrt() * 0.001 * 53.0).sqrt();
    assert!((of("radius_mm") - radius_mm).abs() < 1e-12, "{json}");
    assert!((of("bias_mm") - 3.0 * radius_mm / 53.0 / 4.0).abs() < 1e-12, "{json}");
    assert!((of("noise_mm") - of("bias_mm")).abs() < 1e-12, "{json}");
    let refused = truing(&["design", "micro-plane", "--curvatures", "0.5,0"]);
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("radius"), "{}", refused.stderr);
    let wrong = truing(&["design", "micro-plane", "--curvatures", "0.5"]);
    assert!(wrong.stderr.contains("two numbers with a comma"), "{}", wrong.stderr);
}
