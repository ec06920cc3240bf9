//! NURBS surfaces out of case folders.

use std::fmt::Write as _;

use crate::command::Case;

const TOML: &str = "kind = \"probe-comp\"\n[surface]\nshape = \"nurbs\"\ndegree = [2, 1]\n\
                    knots_u = [0, 0, 0, 1, 1, 1]\n[probe]\ntip_radius_mm = 3.0\n";
/// A quarter of a cylinder of 20 mm about y, which hangs under its axis: exactly, by weights. The
/// rows come in no order.
const CONTROL: &str = "i,j,x_mm,y_mm,z_mm,weight\n\
                       3,2,14.142135623730951,40,-14.142135623730951,1\n\
                       1,1,-14.142135623730951,0,-14.142135623730951,1\n\
                       2,1,0,0,-28.284271247461902,0.7071067811865476\n\
                       3,1,14.142135623730951,0,-14.142135623730951,1\n\
                       1,2,-14.142135623730951,40,-14.142135623730951,1\n\
                       2,2,0,40,-28.284271247461902,0.7071067811865476\n";

fn gutter(touches: &str) -> Case {
    Case::new(&[("case.toml", TOML), ("control.csv", CONTROL), ("touches.csv", touches)])
}

/// Balls of 3 mm in the gutter, `off_mm` above it.
fn touches(off_mm: f64) -> String {
    let mut table = "touch,x_mm,y_mm,z_mm\n".to_owned();
    for k in 0..7 {
        let (sin, cos) = (0.2 * (f64::from(k) - 3.0)).sin_cos();
        let reach = 17.0 - off_mm;
        let _ = writeln!(table, "T{k},{},{},{}", reach * sin, 5 * k + 2, -reach * cos);
    }
    table
}

fn message(case: &Case) -> String {
    case.message("solve", 2).replace(&format!("{}/", case.path().display()), "")
}

#[test]
fn balls_in_a_gutter_are_put_back_on_it() {
    let solved = gutter(&touches(0.004)).json("solve");
    let touches = solved["estimates"]["touches"].as_array().unwrap();
    for touch in touches {
        let [x, z, deviation] =
            ["x_mm", "z_mm", "deviation_mm"].map(|k| touch[k].as_f64().unwrap());
        assert!((deviation - 0.004).abs() < 1e-10, "{touch}");
        assert!((x.hypot(z) - 19.996).abs() < 1e-10, "{touch}");
    }
    assert_eq!(touches.len(), 7);
    let swapped = gutter(&touches_of_a_large_ball());
    swapped.replace("case.toml", "tip_radius_mm = 3.0", "tip_radius_mm = 25.0");
    assert!(message(&swapped).contains("use a smaller ball"), "{}", message(&swapped));
}

/// A ball that is larger than the gutter.
fn touches_of_a_large_ball() -> String {
    "touch,x_mm,y_mm,z_mm\nT1,0,20,-3\n".to_owned()
}

#[test]
fn a_pose_is_found_on_a_nurbs() {
    let toml = "kind = \"pose-icp\"\n[surface]\nshape = \"nurbs\"\ndegree = [2, 2]\n\
                [noise]\npoint_mm = 0.001\n";
    let (mut control, mut points) =
        ("i,j,x_mm,y_mm,z_mm\n".to_owned(), "point,x_mm,y_mm,z_mm\n".to_owned());
    // z = x²/100 + y²/160 + x y/200 over 40 × 40 mm: one Bézier patch repeats it.
    let at = [-20.0, 0.0, 20.0];
    for (i, x) in at.iter().enumerate() {
        for (j, y) in at.iter().enumerate() {
            let [xx, yy] = [x, y].map(|v: &f64| if *v == 0.0 { -400.0 } else { 400.0 });
            let z = xx / 100.0 + yy / 160.0 + x * y / 200.0;
            let _ = writeln!(control, "{},{},{x},{y},{z}", i + 1, j + 1);
        }
    }
    for k in 0..30_u32 {
        let [x, y] = [f64::from(k % 6) * 6.0 - 15.0, f64::from(k / 6) * 7.0 - 14.0];
        let z = x * x / 100.0 + y * y / 160.0 + x * y / 200.0;
        let _ = writeln!(points, "P{k},{},{},{}", x + 0.3, y - 0.2, z + 0.05);
    }
    let case =
        Case::new(&[("case.toml", toml), ("control.csv", &control), ("points.csv", &points)]);
    let solved = case.json("solve");
    let pose = &solved["estimates"]["pose"];
    for (key, truth) in [("x_mm", 0.3), ("y_mm", -0.2), ("z_mm", 0.05), ("gamma_deg", 0.0)] {
        assert!((pose[key].as_f64().unwrap() - truth).abs() < 1e-10, "{pose}");
    }
}

#[test]
fn nets_that_cannot_be() {
    let edited = |file: &str, from: &str, to: &str| {
        let case = gutter(&touches(0.0));
        case.replace(file, from, to);
        message(&case)
    };
    let said = [
        (
            edited("case.toml", "degree = [2, 1]\n", ""),
            "case.toml, line 3, column 9: `[surface] degree` is missing",
        ),
        (
            edited("case.toml", "[2, 1]", "[0, 1]"),
            "`[surface] knots_u`: 6 knots, but 3 control points of degree 0 need 4",
        ),
        (
            edited("case.toml", "knots_u = [0, 0, 0, 1, 1, 1]", "knots_u = [0, 0, 0, 1, 0.5, 1]"),
            "knot 5 along u is smaller than the one before it",
        ),
        (
            edited("case.toml", "knots_u = [0, 0, 0, 1, 1, 1]", "knots_u = [0, 0, 1]"),
            "3 knots, but 3 control points of degree 2 need 6",
        ),
        (edited("case.toml", "[0, 0, 0, 1, 1, 1]", "[1, 1, 1, 1, 1, 1]"), "tears the surface"),
        (
            edited("control.csv", "3,2,14", "3,3,14"),
            "control.csv: 6 rows are no full net: i to 3 and j to 3 make 9 control points",
        ),
        (
            edited("control.csv", "3,2,14", "3,1,14"),
            "control.csv, line 5: i = 3, j = 1 is already on line 2",
        ),
        (
            edited("control.csv", "3,2,14", "0,2,14"),
            "control.csv, line 2, column 1 (`i`): expected a number 1, 2, 3, …, found `0`",
        ),
        (
            edited("control.csv", "902,0.7", "902,-0.7"),
            "control.csv, line 4: expected a positive weight, found -0.7",
        ),
        (edited("control.csv", "902,0.7071067811865476", "902,"), "control.csv, line 4, column 6"),
        (edited("control.csv", "i,j,x_mm", "i,k,x_mm"), "`j`"),
    ];
    for (message, part) in said {
        assert!(message.contains(part), "{message}\n  has no: {part}");
    }
    let absent = Case::new(&[("case.toml", TOML), ("touches.csv", &touches(0.0))]);
    assert!(message(&absent).contains("control.csv: the file is missing"), "{}", message(&absent));
}
