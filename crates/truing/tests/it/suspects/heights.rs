//! Mistakes in heights that a part is drawn by.

use std::fmt::Write as _;

use serde_json::Value;

use crate::command::Case;

/// A part drawn by its heights, touched where it lies: µm for mm, and x for y.
#[test]
fn heights_in_another_unit_or_order_are_named_by_their_file() {
    let height = |x: f64, y: f64| 6e-4 * x * x + 2e-4 * y * y + 3e-6 * x * x * y;
    let grid = || {
        (-10..=10).flat_map(|i| (-10..=10).map(move |j| (6.0 * f64::from(i), 6.0 * f64::from(j))))
    };
    let heights = |by: f64, heading: &str| {
        let mut table = format!("{heading}\n");
        for (x, y) in grid() {
            let _ = writeln!(table, "{x},{y},{:.6}", by * height(x, y));
        }
        table
    };
    let mut points = "point,x_mm,y_mm,z_mm\n".to_owned();
    for n in 0..36 {
        let (x, y) = (9.7 * f64::from(n % 6) - 24.0, 9.1 * f64::from(n / 6) - 22.0);
        let noise = 1e-3 * (12.9 * f64::from(n * n + 1)).sin();
        let _ = writeln!(points, "P{n},{x:.4},{y:.4},{:.5}", height(x, y) + noise);
    }
    let toml = "kind = \"pose-icp\"\n[surface]\nshape = \"grid\"\n[noise]\npoint_mm = 0.001\n";
    let case = Case::new(&[
        ("case.toml", toml),
        ("points.csv", &points),
        ("heights.csv", &heights(1.0, "x_mm,y_mm,z_mm")),
    ]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    for (table, said) in [
        (
            heights(1e3, "x_mm,y_mm,z_mm"),
            "`z_mm` of heights.csv is in another unit than its name says, µm",
        ),
        (heights(1.0, "y_mm,x_mm,z_mm"), "`x_mm`, `y_mm` of heights.csv are exchanged"),
    ] {
        case.write("heights.csv", table);
        let ended = case.run("loop");
        assert!(format!("{}{}", ended.stdout, ended.stderr).contains(said), "{}", ended.stderr);
    }
}
