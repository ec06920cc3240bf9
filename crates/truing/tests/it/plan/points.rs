//! Points of two frames.

use std::fmt::Write as _;

use serde_json::Value;

use super::{json, noise_mm};
use crate::command::Case;

#[test]
fn what_a_plane_hides_is_seen_from_points_outside_of_it() {
    let mut table = String::from("point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n");
    for i in 0..16_u32 {
        let [x, y] = [f64::from(i % 4) * 50.0, f64::from(i / 4) * 40.0];
        let [a, b, c] = [0, 3, 6].map(|k| noise_mm(3 * i as usize + k));
        let _ = writeln!(table, "P{i},{x},{y},0,{:.5},{:.5},{:.5}", x + a, y + b, c);
    }
    let toml = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.001\n";
    let case = Case::new(&[("case.toml", toml), ("pairs.csv", &table)]);
    let flat = json(&case, &["--for", "anisotropic-scale"]);
    assert_eq!(flat["reached"], false);
    assert!(flat["would"].as_str().unwrap().contains("no point"), "{}", flat["would"]);
    case.write("case.toml", format!("{toml}[plan]\nz_mm = [-50, 50]\n"));
    let deep = json(&case, &["--for", "anisotropic-scale"]);
    assert_eq!(deep["reached"], true, "{}", deep["would"]);
    let z = |figure: &&Value| figure["of"].as_str().is_some_and(|of| of.ends_with(": z"));
    let figure = deep["figures"].as_array().unwrap().iter().find(z).unwrap();
    assert!(figure["before"].is_null() && figure["after"].is_number(), "{figure}");
}
