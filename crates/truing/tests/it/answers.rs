//! What is on standard output: the keys that every release keeps, and values known beforehand.

use serde_json::{Value, json};

use crate::command::Case;

/// Coordinates below are exact to 1e-12 mm at 1e3 mm; a fit adds a few digits of round-off.
const ROUND_OFF_MM: f64 = 1e-9;

/// Removes what may differ between two runs.
fn without_timing(mut answer: Value) -> Value {
    answer.as_object_mut().unwrap().remove("timing");
    answer
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number, not {value}"))
}

fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    let value = number(value);
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected}");
}

fn assert_keys(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "no {key} in {value}");
    }
}

/// Keys that the contract names for every kind.
fn assert_solve_contract(answer: &Value) {
    assert_keys(answer, &["kind", "version", "timing", "estimates", "residual", "warnings"]);
    assert_keys(&answer["timing"], &["read_s", "solve_s"]);
    assert_keys(&answer["residual"], &["unit", "n", "dof", "rms", "max_abs", "chi2_per_dof"]);
    assert!(answer["warnings"].is_array());
}

fn assert_loop_contract(answer: &Value) {
    let keys = ["kind", "version", "before", "after", "steps", "verdict", "remaining"];
    assert_keys(answer, &keys);
    assert_keys(answer, &["not_observable", "estimates"]);
    for side in ["before", "after"] {
        assert_keys(&answer[side], &["train_rms", "held_out_rms", "unit"]);
    }
    let verdicts =
        ["nothing-missing", "explained", "structure-remains", "noise-larger-than-declared"];
    assert!(verdicts.contains(&answer["verdict"].as_str().unwrap()));
    for step in answer["steps"].as_array().unwrap() {
        let keys = ["effect", "description", "parameters", "p_value", "held_out_rms", "train_rms"];
        assert_keys(step, &keys);
        assert_keys(step, &["indistinguishable_from", "separate_by"]);
        for parameter in step["parameters"].as_array().unwrap() {
            assert_keys(parameter, &["name", "value", "unit", "std"]);
        }
    }
    for left in answer["remaining"].as_array().unwrap() {
        assert_keys(left, &["covariate", "shape", "p_value"]);
    }
    for unseen in answer["not_observable"].as_array().unwrap() {
        assert_keys(unseen, &["effect", "aliased_with"]);
    }
}

#[test]
fn every_example_keeps_the_contract() {
    for (kind, _) in truing::kinds() {
        let case = Case::example(kind);
        let solved = case.json("solve");
        assert_eq!(solved["kind"], kind);
        assert_solve_contract(&solved);
        let closed = case.json("loop");
        assert_eq!(closed["kind"], kind);
        assert_loop_contract(&closed);
        let checked = case.json("check");
        assert_keys(&checked, &["counts", "parameters", "observable", "not_observable"]);
        let estimates = [&solved["estimates"], &closed["estimates"]];
        for estimates in estimates {
            match kind {
                "frame-fit" => {
                    assert_keys(estimates, &["matrix", "translation_mm", "angles_deg", "scale"]);
                    let point = &estimates["points"][0];
                    assert_keys(point, &["point", "dx_mm", "dy_mm", "dz_mm"]);
                }
                "ft-center" => {
                    assert_keys(&estimates["frame"], &["angle_deg", "tx_mm", "ty_mm"]);
                    let center = &estimates["centers"][0];
                    assert_keys(center, &["press", "x_mm", "y_mm", "machine_x_mm", "machine_y_mm"]);
                    assert_keys(center, &["std_x_mm", "std_y_mm", "offset_x_mm", "offset_y_mm"]);
                }
                "force-impedance" => {
                    let force = &estimates["contact_force"];
                    assert_keys(force, &["rms_error_n", "max_error_n"]);
                    assert_keys(estimates, &["samples"]);
                }
                "tracker-lm" => {
                    assert_keys(
                        &estimates["stations"][0],
                        &["station", "x_mm", "y_mm", "z_mm", "std_mm"],
                    );
                    assert!(estimates["points"].is_u64());
                    let errors = &estimates["axis_errors"][1];
                    assert_keys(errors, &["angle_deg", "e_x_mm", "e_y_mm", "e_z_mm"]);
                    assert_keys(errors, &["e_a_rad", "e_b_rad", "e_c_rad"]);
                    assert_keys(errors, &["std_e_x_mm", "std_e_y_mm", "std_e_z_mm"]);
                    assert_keys(errors, &["std_e_a_rad", "std_e_b_rad", "std_e_c_rad"]);
                }
                "positioning" => {
                    let run = &estimates["run"];
                    assert_keys(run, &["target_unit", "unit", "figures", "corrected", "targets"]);
                    assert_keys(&run["figures"][0], &["symbol", "name", "value", "std"]);
                    assert_keys(&run["targets"][0], &["target", "mean", "reversal"]);
                    let reading = &estimates["readings"][0];
                    assert_keys(reading, &["point", "target", "deviation", "correction"]);
                }
                "pose-icp" => {
                    let pose = &estimates["pose"];
                    assert_keys(pose, &["x_mm", "y_mm", "z_mm"]);
                    assert_keys(pose, &["alpha_deg", "beta_deg", "gamma_deg"]);
                    assert_keys(pose, &["std_x_mm", "std_y_mm", "std_z_mm"]);
                    assert_keys(pose, &["std_alpha_deg", "std_beta_deg"]);
                    assert!(estimates["checks"].is_array());
                }
                "probe-comp" => {
                    let touch = &estimates["touches"][0];
                    assert_keys(touch, &["touch", "x_mm", "y_mm", "z_mm", "nx", "ny", "nz"]);
                    assert_keys(touch, &["deviation_mm", "std_deviation_mm"]);
                }
                other => panic!("the contract of {other} is not tested"),
            }
        }
    }
}

#[test]
fn two_runs_print_the_same_and_threads_change_nothing() {
    for (kind, _) in truing::kinds() {
        let case = Case::example(kind);
        for command in ["solve", "loop", "check"] {
            let mut texts = Vec::new();
            for threads in ["1", "1", "2", "7"] {
                let path = case.path().to_str().unwrap();
                let ended =
                    crate::command::truing(&[command, path, "--json", "--threads", threads]);
                assert_eq!(ended.code, 0, "{}", ended.stderr);
                let timed = |line: &&str| !line.contains("_s\": ");
                texts.push(ended.stdout.lines().filter(timed).collect::<Vec<_>>().join("\n"));
            }
            assert!(texts.iter().all(|text| *text == texts[0]), "{command} {kind}");
        }
    }
}

#[test]
fn a_known_planar_transform() {
    // 90° and (10, −5): every coordinate below is exact.
    let case = Case::new(&[
        ("case.toml", "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.001\n"),
        (
            "pairs.csv",
            "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n\
             a,0,0,10,-5\nb,100,0,10,95\nc,100,40,-30,95\nd,0,40,-30,-5\n",
        ),
    ]);
    let answer = case.json("solve");
    let estimates = &answer["estimates"];
    assert_near(&estimates["angles_deg"][0], 90.0, ROUND_OFF_MM);
    assert_near(&estimates["translation_mm"][0], 10.0, ROUND_OFF_MM);
    assert_near(&estimates["translation_mm"][1], -5.0, ROUND_OFF_MM);
    assert_near(&estimates["scale"], 1.0, ROUND_OFF_MM);
    let matrix = [[0.0, -1.0, 10.0], [1.0, 0.0, -5.0], [0.0, 0.0, 1.0]];
    for (row, expected) in matrix.iter().enumerate() {
        for (column, expected) in expected.iter().enumerate() {
            assert_near(&estimates["matrix"][row][column], *expected, ROUND_OFF_MM);
        }
    }
    assert_eq!(estimates["points"][0]["dz_mm"], Value::Null, "planar");
    assert_eq!(answer["residual"]["n"], 8);
    assert_eq!(answer["residual"]["dof"], 5);
    assert_near(&answer["residual"]["max_abs"], 0.0, ROUND_OFF_MM);
    // Uncertainty of the angle of n points: σ/√(Σ r²) about their centroid.
    let sum_of_squares = 4.0 * (50.0_f64.powi(2) + 20.0_f64.powi(2));
    let std_deg = (0.001 / sum_of_squares.sqrt()).to_degrees();
    assert_near(&estimates["std"]["angles_deg"][0], std_deg, 1e-9 * std_deg);
    // The image of the origin moves with the centroid, σ/√n, and turns about it.
    let lever_x = (0.001_f64.powi(2) / 4.0 + (20.0 * std_deg.to_radians()).powi(2)).sqrt();
    let lever_y = (0.001_f64.powi(2) / 4.0 + (50.0 * std_deg.to_radians()).powi(2)).sqrt();
    // Rotated by 90° the lever of 20 mm lies along x.
    let std = &estimates["std"]["translation_mm"];
    assert_near(&std[0], lever_y, 1e-9);
    assert_near(&std[1], lever_x, 1e-9);
}

#[test]
fn angles_are_those_of_rz_ry_rx() {
    let turned = |(x, y, z): (f64, f64, f64)| {
        let [a, b, g] = [10.0_f64, -20.0, 30.0].map(f64::to_radians);
        let (y, z) = (a.cos() * y - a.sin() * z, a.sin() * y + a.cos() * z);
        let (x, z) = (b.cos() * x + b.sin() * z, -b.sin() * x + b.cos() * z);
        (g.cos() * x - g.sin() * y, g.sin() * x + g.cos() * y, z)
    };
    let mut pairs = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n".to_owned();
    for (i, p) in
        [(0.0, 0.0, 0.0), (90.0, 0.0, 5.0), (0.0, 70.0, 0.0), (10.0, 0.0, 80.0)].iter().enumerate()
    {
        let (x, y, z) = turned(*p);
        pairs += &format!("{i},{},{},{},{},{},{}\n", p.0, p.1, p.2, x + 1.0, y + 2.0, z + 3.0);
    }
    let case = Case::new(&[("case.toml", "kind = \"frame-fit\"\n"), ("pairs.csv", &pairs)]);
    let estimates = &case.json("solve")["estimates"];
    for (i, expected) in [10.0, -20.0, 30.0].into_iter().enumerate() {
        assert_near(&estimates["angles_deg"][i], expected, ROUND_OFF_MM);
    }
    for (i, expected) in [1.0, 2.0, 3.0].into_iter().enumerate() {
        assert_near(&estimates["translation_mm"][i], expected, ROUND_OFF_MM);
    }
}

#[test]
fn a_point_counts_once_by_the_length_of_its_residual() {
    // Lengths 5, 0 and 10 are fitted; 13 is only judged.
    let case = Case::new(&[
        ("case.toml", "kind = \"frame-fit\"\n[model]\ntransform = \"none\"\n"),
        (
            "pairs.csv",
            "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,use\n\
             a,0,0,3,4,fit\nb,100,0,100,0,\nc,0,100,6,108,fit\nd,9,9,14,21,check\n",
        ),
    ]);
    let answer = case.json("solve");
    let residual = &answer["residual"];
    assert_eq!((&residual["n"], &residual["dof"]), (&json!(6), &json!(6)));
    assert_near(&residual["rms"], (125.0_f64 / 3.0).sqrt(), ROUND_OFF_MM);
    assert_near(&residual["max_abs"], 10.0, ROUND_OFF_MM);
    assert_eq!(residual["unit"], "mm");
    assert_near(&answer["check"]["rms"], 13.0, ROUND_OFF_MM);
    let points = &answer["estimates"]["points"];
    assert_near(&points[0]["dx_mm"], 3.0, ROUND_OFF_MM);
    assert_near(&points[3]["dy_mm"], 12.0, ROUND_OFF_MM);
}

#[test]
fn declared_noise_gives_chi_squared() {
    // Residuals of 1 and −1 σ in x about the mean translation: χ² = 2 over 4 − 2.
    let case = Case::new(&[
        (
            "case.toml",
            "kind = \"frame-fit\"\n[model]\ntransform = \"translation\"\n[noise]\npoint_mm = 0.5\n",
        ),
        ("pairs.csv", "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\na,0,0,0.5,0\nb,10,0,9.5,0\n"),
    ]);
    let answer = case.json("solve");
    assert_eq!(answer["residual"]["dof"], 2);
    assert_near(&answer["residual"]["chi2_per_dof"], 1.0, ROUND_OFF_MM);
}

#[test]
fn the_loop_finds_what_is_missing_and_the_estimates_hold_it() {
    // A tracker with a scale error of 300 ppm: the rigid fit cannot take it.
    let case = Case::example("frame-fit");
    let text = std::fs::read_to_string(case.file("pairs.csv")).unwrap();
    let scaled = text.lines().map(|line| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if cells.len() > 6 && cells[4].parse::<f64>().is_ok() {
            for cell in &mut cells[4..7] {
                *cell = format!("{:.6}", cell.parse::<f64>().unwrap() * 1.0003);
            }
        }
        cells.join(",") + "\n"
    });
    case.write("pairs.csv", scaled.collect::<String>());
    let answer = case.json("loop");
    assert_loop_contract(&answer);
    assert_eq!(answer["verdict"], "explained", "{answer}");
    assert_eq!(answer["steps"][0]["effect"], "scale");
    let after = number(&answer["after"]["held_out_rms"]);
    let before = number(&answer["before"]["held_out_rms"]);
    // 300 ppm over some 250 mm is 0.075 mm; the noise is 0.017 mm in three coordinates.
    assert!(before > 0.05 && after < 0.03, "{before} → {after}");
    let report = case.file("report.html");
    let path = case.path().to_str().unwrap();
    let ended =
        crate::command::truing(&["loop", path, "--report", report.to_str().unwrap(), "--json"]);
    let again: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(without_timing(again), without_timing(answer));
    assert!(std::fs::read_to_string(report).unwrap().contains("<svg"));
}

#[test]
fn check_names_sizes_and_aliases() {
    let case = Case::example("frame-fit");
    case.replace("case.toml", "transform = \"rigid\"", "transform = \"similarity\"");
    let answer = case.json("check");
    assert_eq!(answer["counts"]["parameters"], 7);
    assert_eq!(answer["counts"]["equations"], 30);
    assert_eq!(answer["counts"]["dof"], 23);
    assert_eq!(answer["counts"]["check_groups"], 2);
    let effect = |list: &str, id: &str| {
        let all = answer[list].as_array().unwrap();
        all.iter().find(|e| e["effect"] == id).cloned()
    };
    let anisotropic = effect("observable", "anisotropic-scale").expect("seen");
    assert!(number(&anisotropic["detectable_rms"]) > 0.0);
    assert!(number(&anisotropic["detectable"][0]["value"]) > 0.0);
    assert!(effect("observable", "scale").is_none(), "it is in the declared model");
}

#[test]
fn check_says_when_there_is_too_little_for_the_loop() {
    let case = Case::new(&[
        ("case.toml", "kind = \"frame-fit\"\n"),
        ("pairs.csv", "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\na,0,0,0.5,0\nb,10,0,9.5,0\n"),
    ]);
    let answer = case.json("check");
    assert_eq!(answer["counts"]["dof"], 1);
    assert!(answer["warnings"].to_string().contains("the loop cannot be closed: 2 fitted groups"));
    let message = case.message("loop", 3);
    assert!(message.contains("measure at least 3 groups"), "{message}");
}

#[test]
fn a_mirrored_frame_is_said_by_every_command() {
    let case = Case::example("frame-fit");
    let text = std::fs::read_to_string(case.file("pairs.csv")).unwrap();
    let mirrored = text.lines().map(|line| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if cells.len() > 6 && cells[6].parse::<f64>().is_ok() {
            cells[6] = format!("{}", -cells[6].parse::<f64>().unwrap());
        }
        cells.join(",") + "\n"
    });
    case.write("pairs.csv", mirrored.collect::<String>());
    for command in ["solve", "loop", "check"] {
        let warnings = case.json(command)["warnings"].to_string();
        assert!(warnings.contains("set `[model] handedness = \\\"improper\\\"`"), "{warnings}");
    }
    case.replace("case.toml", "# handedness = \"proper\"", "handedness = \"improper\"");
    let answer = case.json("loop");
    assert_eq!(answer["warnings"], json!([]));
    assert_eq!(answer["estimates"]["handedness"], "improper");
    assert_eq!(answer["estimates"]["angles_deg"], Value::Null, "a reflection has no angles");
    // The noise of the example, 0.01 mm in three coordinates, and half as much again.
    assert!(number(&answer["residual"]["rms"]) < 0.026);
}
