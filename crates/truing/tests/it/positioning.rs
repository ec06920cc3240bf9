//! Runs of an axis over its targets.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use crate::command::{Case, truing};

/// Profile of seven targets in µm.
const PROFILE_UM: [f64; 7] = [4.0, -9.0, 12.0, 0.0, -7.0, 10.0, -3.0];
/// Rising less falling, µm.
const REVERSAL_UM: f64 = 14.0;

/// Five cycles there and back over seven targets, `(target, deviation in µm, rises, cycle)`.
fn run() -> Vec<(f64, f64, bool, usize)> {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let mut rows = Vec::new();
    for cycle in 1..=5 {
        for step in 0..14_usize {
            let (place, rises) = if step < 7 { (step, true) } else { (13 - step, false) };
            let noise: f64 = StandardNormal.sample(&mut rng);
            let way = if rises { 0.5 } else { -0.5 };
            let target = [2.0, 51.3, 98.7, 152.2, 199.4, 251.9, 298.1][place];
            rows.push((target, PROFILE_UM[place] + way * REVERSAL_UM + noise, rises, cycle));
        }
    }
    rows
}

fn names(answer: &Value) -> Vec<&str> {
    let steps = answer["steps"].as_array().unwrap();
    let mut names: Vec<&str> = steps.iter().map(|s| s["effect"].as_str().unwrap()).collect();
    names.sort_unstable();
    names
}

fn figure(answer: &Value, list: &str, symbol: &str) -> f64 {
    let figures = answer["estimates"]["run"][list].as_array().unwrap();
    figures.iter().find(|f| f["symbol"] == symbol).unwrap()["value"].as_f64().unwrap()
}

fn table(row: impl Fn(&(f64, f64, bool, usize)) -> String) -> String {
    run().iter().map(row).collect()
}

#[test]
fn a_linear_axis_by_its_figures_effects_and_compensation() {
    let rows = table(|(target, um, rises, cycle)| {
        let way = if *rises { "rising" } else { "falling" };
        format!("{target},{:.6},{way},{cycle}\n", target + 1e-3 * um)
    });
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\nlength_ppm = 2.0\n"),
        ("positions.csv", &format!("target_mm,actual_mm,direction,cycle\n{rows}")),
    ]);
    let answer = case.json("loop");
    assert_eq!(names(&answer), ["profile", "reversal"], "{}", answer["steps"]);
    assert_eq!(answer["verdict"], "explained");
    // Means of five readings of 1 µm: 0.45 µm each; extremes of seven, so some three of these.
    assert!((figure(&answer, "figures", "B") - 0.014).abs() < 0.002);
    assert!((figure(&answer, "figures", "M") - 0.021).abs() < 0.002);
    assert!((figure(&answer, "figures", "E") - 0.035).abs() < 0.002);
    // With profile and reversal taken off the cycles' scatter is left.
    assert!(figure(&answer, "corrected", "B") < 0.002);
    assert!(figure(&answer, "corrected", "A") < 0.012);
    let targets = answer["estimates"]["run"]["targets"].as_array().unwrap();
    assert_eq!(targets.len(), 7);
    for (target, um) in targets.iter().zip(PROFILE_UM) {
        assert!((1e3 * target["mean"].as_f64().unwrap() - um).abs() < 1.3, "{target}");
        assert_eq!(target["n_rising"], 5);
    }
    // u(E) holds the standard of length over 296.1 mm; B does not.
    let std = |symbol: &str| {
        let figures = answer["estimates"]["run"]["figures"].as_array().unwrap();
        figures.iter().find(|f| f["symbol"] == symbol).unwrap()["std"].as_f64().unwrap()
    };
    let of_length = (std("E").powi(2) - std("B").powi(2)).sqrt();
    assert!((of_length - 2e-6 * 296.1).abs() < 1e-9, "{of_length}");

    let file = case.file("axis.comp");
    let folder = case.path().to_str().unwrap().to_owned();
    let ended = truing(&["solve", &folder, "--compensation", file.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let text = std::fs::read_to_string(&file).unwrap();
    let third: Vec<f64> =
        text.lines().nth(2).unwrap().split(' ').map(|v| v.parse().unwrap()).collect();
    let means = ["mean_rising", "mean_falling"].map(|k| targets[2][k].as_f64().unwrap());
    assert!((third[0] - 98.7).abs() < 1e-9);
    assert!((third[1] - 98.7 - means[0]).abs() < 1e-6 && (third[2] - 98.7 - means[1]).abs() < 1e-6);
}

#[test]
fn a_rotary_axis_passes_zero_and_is_read_in_seconds_of_arc() {
    let rows = table(|(target, um, rises, cycle)| {
        // Seven targets over a turn; what is below zero is written as just under 360.
        let at = target / 298.1 * 350.0 - 2.0 / 298.1 * 350.0;
        let actual = (at + um / 3600.0).rem_euclid(360.0);
        format!("{at:.6},{actual:.9},{},{cycle}\n", if *rises { 1 } else { -1 })
    });
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_arcsec = 1.0\n"),
        ("positions.csv", &format!("target_deg,actual_deg,direction,cycle\n{rows}")),
    ]);
    let answer = case.json("solve");
    assert_eq!(answer["estimates"]["run"]["unit"], "arcsec");
    assert!((figure(&answer, "figures", "B") - 14.0).abs() < 2.0);
    assert!((figure(&answer, "figures", "M") - 21.0).abs() < 2.0);
    // The first target is zero: coming down to it, five times, the axis stops below.
    let notes = answer["notes"].to_string();
    assert!(notes.contains("5 positions a full turn from their targets"), "{notes}");
}

#[test]
fn displacements_whose_points_recur_are_a_run_as_well() {
    let rows = table(|(target, um, rises, cycle)| {
        format!(
            "P{target},{target},{:.6},{},{cycle}\n",
            target + 1e-3 * um,
            if *rises { 1 } else { -1 }
        )
    });
    let case = Case::new(&[
        ("case.toml", "kind = \"ft-center\"\n"),
        ("displacements.csv", &format!("point,commanded_mm,solved_mm,direction,cycle\n{rows}")),
    ]);
    let answer = case.json("loop");
    assert_eq!(names(&answer), ["profile", "reversal"], "{}", answer["steps"]);
    assert_eq!(answer["estimates"]["points"].as_array().unwrap().len(), 70);
    assert!((figure(&answer, "figures", "B") - 0.014).abs() < 0.002);
    let taken = answer["after"]["held_out_rms"].as_f64().unwrap();
    assert!(taken < 0.0013, "{taken}");
}

#[test]
fn displacements_by_the_names_of_targets_are_a_run_of_one_axis() {
    let row = |(target, um, rises, cycle): &(f64, f64, bool, usize)| {
        let way = if *rises { "+" } else { "-" };
        format!("X,{target},{:.6},{way},{cycle}\n", target + 1e-3 * um)
    };
    let head = ("case.toml", "kind = \"ft-center\"\n[noise]\ndisplacement_mm = 0.001\n");
    let columns = "axis,target_mm,actual_mm,direction,cycle";
    let rows = table(row);
    let case = Case::new(&[head, ("displacements.csv", &format!("{columns}\n{rows}"))]);
    let answer = case.json("loop");
    assert_eq!(answer["kind"], "ft-center");
    assert_eq!(names(&answer), ["profile", "reversal"], "{}", answer["steps"]);
    let found = &answer["estimates"]["positioning"];
    let number = |name: &str| found[name].as_f64().unwrap();
    assert!((number("B_mm") - figure(&answer, "figures", "B")).abs() < 1e-12);
    assert!(number("A_rising_mm") > number("R_rising_mm") && number("u_E_mm") > 0.0);
    let corrections = found["table"].as_array().unwrap();
    for (correction, um) in corrections.iter().zip(PROFILE_UM) {
        let um_of = |way: &str| 1e3 * correction[way].as_f64().unwrap();
        // Means of five readings of 1 µm.
        assert!((um_of("correction_forward") + um + 0.5 * REVERSAL_UM).abs() < 1.8, "{correction}");
        assert!((um_of("correction_reverse") + um - 0.5 * REVERSAL_UM).abs() < 1.8, "{correction}");
        assert!((0.1..1.0).contains(&um_of("u")), "{correction}");
    }

    // Moved to millimetres that are metres.
    let metres = |(target, um, rises, cycle): &(f64, f64, bool, usize)| {
        let way = if *rises { "+" } else { "-" };
        format!("X,{target},{:.9},{way},{cycle}\n", 1e-3 * (target + 1e-3 * um))
    };
    let metres = table(metres);
    let case = Case::new(&[head, ("displacements.csv", &format!("{columns}\n{metres}"))]);
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "input-wrong", "{answer}");
    assert_eq!(answer["steps"][0]["effect"], "input:unit", "{}", answer["steps"]);

    let two = rows.replacen("X,2,", "Y,2,", 2).replacen("Y,2,", "X,2,", 1);
    let case = Case::new(&[head, ("displacements.csv", &format!("{columns}\n{two}"))]);
    let message = case.message("solve", 2);
    assert!(message.contains("`Y`") && message.contains("one axis"), "{message}");
}

#[test]
fn without_a_direction_the_target_before_says_it() {
    let rows = table(|(target, um, _, _)| format!("{target},{:.6}\n", 1e-3 * um));
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\n"),
        ("positions.csv", &format!("target_mm,deviation_mm\n{rows}")),
    ]);
    let answer = case.json("solve");
    assert!((figure(&answer, "figures", "B mean") - 0.014).abs() < 0.001);
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("the target before"), "{warnings}");
}

#[test]
fn what_contradicts_itself_is_refused() {
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n"),
        ("positions.csv", "target_mm,target_deg,actual_mm\n1,1,1\n"),
    ]);
    assert!(case.message("solve", 2).contains("`target_deg`"));
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n"),
        ("positions.csv", "target_mm,actual_mm,direction\n1,1.001,sideways\n"),
    ]);
    let message = case.message("solve", 2);
    assert!(message.contains("line 2") && message.contains("sideways"), "{message}");
}

#[test]
fn an_axis_that_misses_by_centimetres_is_not_compensated() {
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n"),
        (
            "positions.csv",
            "target_mm,deviation_mm,direction\n0,0,1\n100,12,1\n200,24,1\n300,36,1\n",
        ),
    ]);
    let file = case.file("axis.comp");
    let folder = case.path().to_str().unwrap().to_owned();
    let ended = truing(&["solve", &folder, "--compensation", file.to_str().unwrap()]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    assert!(ended.stderr.contains("misses its target 300 mm"), "{}", ended.stderr);
    assert!(!file.exists());
}
