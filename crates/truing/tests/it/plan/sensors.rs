//! Presses and poses of a force/torque sensor.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;

use super::{json, noise_mm};
use crate::command::{Case, truing};

#[test]
fn a_head_is_pressed_with_the_loads_that_tell() {
    let case = Case::example("ft-center");
    let toml = fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", format!("{toml}[plan]\nloads_n = [20, 60]\nleans_deg = [8]\n"));
    let folder = case.file("next");
    let answer =
        json(&case, &["--for", "load-shift", "--budget", "6", "--out", folder.to_str().unwrap()]);
    let loads: Vec<f64> = (answer["plan"].as_array().unwrap().iter())
        .map(|one| one["cells"]["load_n"].as_f64().unwrap())
        .collect();
    assert!(loads.contains(&20.0) && loads.contains(&60.0), "{loads:?}");
    let figure = |key: &str| answer["figures"][0][key].as_f64();
    assert!(figure("after").unwrap() < figure("before").unwrap_or(f64::INFINITY), "{answer}");
    // Presses to be made, and no record of any.
    let presses = fs::read_to_string(folder.join("presses.csv")).unwrap();
    assert_eq!(presses.lines().filter(|line| line.starts_with('N')).count(), loads.len());
    let wrench = fs::read_to_string(folder.join("wrench.csv")).unwrap();
    assert!(wrench.lines().all(|line| !line.starts_with('N')));
    let ended = truing(&["solve", folder.to_str().unwrap()]);
    assert!(ended.one_message().contains("press `N1` has no rows in wrench.csv; measure it"));
}

#[test]
fn a_free_tool_is_tilted_to_where_its_weight_tells() {
    let mut table = String::from("pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n");
    // Turned about x by steps: 25 N at (1, 2, 60) mm, zero (0.5, −0.3, 1).
    for i in 0..12_u32 {
        let half = 0.15 * f64::from(i);
        let (sin, cos) = half.sin_cos();
        let (weight, at) = (25.0, [1.0, 2.0, 60.0]);
        // Down in the sensor: Rx(−2·half) of −z.
        let down = [0.0, -(2.0 * half).sin(), -(2.0 * half).cos()];
        let f = down.map(|d| weight * d);
        let m =
            [at[1] * f[2] - at[2] * f[1], at[2] * f[0] - at[0] * f[2], at[0] * f[1] - at[1] * f[0]];
        let e = |k: usize| 20.0 * noise_mm(6 * i as usize + k);
        let _ = writeln!(
            table,
            "P{i},{cos:.9},{sin:.9},0,0,{:.5},{:.5},{:.5},{:.4},{:.4},{:.4}",
            f[0] + 0.5 + e(0),
            f[1] - 0.3 + e(1),
            f[2] + 1.0 + e(2),
            m[0] + 40.0 * e(3),
            m[1] + 40.0 * e(4),
            m[2] + 40.0 * e(5)
        );
    }
    let toml = "kind = \"ft-center\"\n[noise]\nforce_n = 0.02\nmoment_nmm = 0.8\n";
    let case = Case::new(&[("case.toml", toml), ("gravity.csv", &table)]);
    let answer = json(&case, &["--for", "all", "--budget", "4"]);
    assert_eq!((answer["planned"].as_u64(), &answer["noun"]), (Some(4), &Value::from("pose")));
    for figure in answer["figures"].as_array().unwrap() {
        let of = |key: &str| figure[key].as_f64().unwrap();
        assert!(of("after") <= of("before") * (1.0 + 1e-9), "{figure}");
    }
    // Turned about x alone, what goes with x is known least.
    let sideways = answer["plan"].as_array().unwrap().iter().any(|one| {
        let q = |name: &str| one["cells"][name].as_f64().unwrap();
        q("qy").abs() > 1e-3 || q("qz").abs() > 1e-3
    });
    assert!(sideways, "{}", answer["plan"]);
}
