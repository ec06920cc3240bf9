//! Mistakes in poses of a tip.

use std::fmt::Write as _;

use serde_json::Value;

use super::first;
use crate::command::Case;

#[test]
fn a_quaternion_with_its_scalar_last_is_named() {
    let table = "place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n".to_owned() + &poses();
    let case = Case::new(&[
        ("case.toml", "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.01\n"),
        ("poses.csv", &table),
    ]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    case.write("poses.csv", table.replacen("qw,qx,qy,qz", "qx,qy,qz,qw", 1));
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    assert!(step["description"].as_str().unwrap().contains("scalar part"), "{step}");
}

/// Flange poses whose tip, [10, -20, 150] mm from the flange, touches [400, 100, 50] mm.
#[expect(clippy::cast_precision_loss, reason = "counts of rows")]
fn poses() -> String {
    let pose = |i: usize| {
        let phase = i as f64;
        let angle = 0.5 + 0.3 * (1.7 * phase).sin();
        let axis = [(2.1 * phase).sin(), (1.3 * phase).cos(), 0.4];
        let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        let [x, y, z] = axis.map(|a| a / length * (0.5 * angle).sin());
        let w = (0.5 * angle).cos();
        let tip = [10.0, -20.0, 150.0];
        // t + 2 v × (v × t + w t)
        let v = [x, y, z];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let inner = cross(v, tip);
        let inner = std::array::from_fn(|k| inner[k] + w * tip[k]);
        let outer = cross(v, inner);
        let noise = |k: f64| 0.01 * ((phase + 1.0) * (k + 1.0) * 12.9898).sin();
        let at: [f64; 3] = std::array::from_fn(|k| {
            [400.0, 100.0, 50.0][k] - tip[k] - 2.0 * outer[k] + noise(k as f64)
        });
        format!("cup,{:.5},{:.5},{:.5},{w:.9},{x:.9},{y:.9},{z:.9}\n", at[0], at[1], at[2])
    };
    (0..14).map(pose).collect()
}

/// Two cups in turn, of which single poses carry the name of the other one, and none of the other's carries theirs.
#[test]
fn single_poses_that_name_another_place_are_put_right() {
    let table = |wrong: &[usize]| {
        let mut table = "place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n".to_owned();
        for (row, line) in poses().lines().enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if row % 2 == 1 {
                cells[1] = format!("{:.5}", cells[1].parse::<f64>().unwrap() + 200.0);
            }
            if row % 2 == 1 || wrong.contains(&row) {
                "cone".clone_into(&mut cells[0]);
            }
            let _ = writeln!(table, "{}", cells.join(","));
        }
        table
    };
    let toml = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.01\n";
    let case = Case::new(&[("case.toml", toml), ("poses.csv", &table(&[]))]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    case.write("poses.csv", table(&[4, 8]));
    let (step, _) = first(&case);
    assert_eq!(
        (&step["effect"], &step["subject"]),
        (&"input:labels".into(), &"poses.csv: place".into())
    );
    assert!(step["description"].as_str().unwrap().contains("lines 6, 10"), "{step}");
}
