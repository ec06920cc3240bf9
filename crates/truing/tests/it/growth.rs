//! Frames that grow with a temperature.

use std::fmt::Write as _;

use serde_json::Value;

use crate::command::Case;

/// What grows with a temperature stays where it is clamped, which nobody says.
#[test]
fn growth_about_any_place_is_a_temperature() {
    let mut table =
        "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm,air_c\n".to_owned();
    for n in 0..48_u32 {
        let place = [n % 4, n / 4 % 3, n / 12 % 2].map(|k| 150.0 * f64::from(k) + 300.0);
        let warmer = 2.0 * (0.13 * f64::from(n)).sin();
        let noise = |k: u32| 1e-3 * (12.9 * f64::from(6 * n + k).powi(2)).sin();
        let to = place.map(|p| p + 50.0 + 40e-6 * warmer * (p - 500.0));
        let _ = write!(table, "N{n}");
        for (value, k) in place.into_iter().zip(0..).chain(to.into_iter().zip(3..)) {
            let _ = write!(table, ",{:.5}", value + noise(k));
        }
        let _ = writeln!(table, ",{:.3}", 20.0 + warmer);
    }
    let toml = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.001\n";
    let answer = Case::new(&[("case.toml", toml), ("pairs.csv", &table)]).json("loop");
    assert_eq!(answer["verdict"], "explained", "{}", answer["remaining"]);
    let named: Vec<&Value> =
        answer["steps"].as_array().unwrap().iter().map(|s| &s["effect"]).collect();
    assert_eq!(named, ["temperature"]);
    let growth = answer["steps"][0]["parameters"][0]["value"].as_f64().unwrap();
    assert!((growth - 40.0).abs() < 2.0, "{growth}");
}
