//! `[surface.form]`: a part as drawn with the form that was measured of it, as one surface.

use std::fmt::Write as _;

use serde_json::Value;

use crate::command::{Case, truing};

/// A paraboloid of 480 mm vertex radius.
const BOWL: &str = "[surface]\nshape = \"asphere\"\nradius_mm = 480.0\nconic = -1.0\n\
    diameter_mm = 100.0\n";
const FORM: &str = "[surface.form]\n";
const AT: [f64; 3] = [10.0, -20.0, 5.0];

/// What was measured: a saddle and waves, µm in size, mm here.
fn deviation(x: f64, y: f64) -> f64 {
    2e-6 * (x * x - y * y) + 1e-6 * x * y + 1.5e-3 * (0.12 * x).sin()
}

fn sag(x: f64, y: f64) -> f64 {
    (x * x + y * y) / 960.0
}

fn normal(x: f64, y: f64) -> [f64; 3] {
    let length = (1.0 + (x * x + y * y) / (480.0 * 480.0)).sqrt();
    [-x / 480.0 / length, -y / 480.0 / length, 1.0 / length]
}

/// A point of the real part, over x, y of the drawn one, along the drawn normal.
fn real(x: f64, y: f64) -> [f64; 3] {
    let (n, w) = (normal(x, y), deviation(x, y));
    [x + w * n[0], y + w * n[1], sag(x, y) + w * n[2]]
}

/// A point beside the real part: its normal by differences of its points.
fn over(x: f64, y: f64, by_mm: f64) -> [f64; 3] {
    let h = 1e-2;
    let along = |dx: f64, dy: f64| {
        let (a, b) = (real(x + dx, y + dy), real(x - dx, y - dy));
        [0, 1, 2].map(|k| (a[k] - b[k]) / (2.0 * h))
    };
    let (u, v) = (along(h, 0.0), along(0.0, h));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    let p = real(x, y);
    [0, 1, 2].map(|k| p[k] + by_mm * cross[k] / length)
}

/// The map 2 mm apart where the round part is.
fn map() -> String {
    let mut table = "x_mm,y_mm,deviation_mm\n".to_owned();
    for (i, j) in (-26..=26).flat_map(|j| (-26..=26).map(move |i| (i, j))) {
        let (x, y) = (2.0 * f64::from(i), 2.0 * f64::from(j));
        if x.hypot(y) <= 54.0 {
            let _ = writeln!(table, "{x},{y},{:.9}", deviation(x, y));
        }
    }
    table
}

/// The same at places that follow no grid.
fn scattered() -> String {
    let mut table = "x_mm,y_mm,deviation_um\n".to_owned();
    for k in 0..2500_u32 {
        let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
        let r = 1.08 * f64::from(k).sqrt();
        let (x, y) = (r * cos, r * sin);
        let _ = writeln!(table, "{x:.6},{y:.6},{:.6}", 1e3 * deviation(x, y));
    }
    table
}

const TOUCHED: [[f64; 2]; 12] = [
    [0.0, 0.0],
    [20.0, 0.0],
    [0.0, 20.0],
    [-40.0, 0.0],
    [0.0, -40.0],
    [25.0, 25.0],
    [-31.0, 27.0],
    [33.0, -24.0],
    [-17.0, -29.0],
    [44.0, 5.0],
    [8.0, 43.0],
    [-12.0, 9.0],
];

fn touches(heading: &str, at: [f64; 3]) -> String {
    let mut table = format!("{heading},x_mm,y_mm,z_mm\n");
    for (n, [x, y]) in TOUCHED.into_iter().enumerate() {
        let p = over(x, y, 3.0);
        let _ = writeln!(table, "P{n},{:.8},{:.8},{:.8}", p[0] + at[0], p[1] + at[1], p[2] + at[2]);
    }
    table
}

fn clamped(form: &str, map: &str) -> Case {
    let toml = format!(
        "kind = \"pose-icp\"\n{BOWL}{form}[pose]\nheld = [\"x\", \"y\"]\n\
         initial = {{ x_mm = 10.0, y_mm = -20.0, z_mm = 5.0 }}\n[probe]\ntip_radius_mm = 3.0\n\
         [noise]\npoint_mm = 0.001\n[tool]\nfilm_mm = 1.5\n"
    );
    let points = touches("point", AT);
    Case::new(&[("case.toml", &toml), ("points.csv", &points), ("form.csv", map)])
}

/// Coordinates to 1e-8, the map's to 1e-9, and a bicubic spline 2 mm apart of waves of 0.12 /mm: 5e-9 mm.
const READ_MM: f64 = 1e-7;

fn pose(solved: &Value) -> [f64; 3] {
    ["z_mm", "alpha_deg", "beta_deg"].map(|k| solved["estimates"]["pose"][k].as_f64().unwrap())
}

#[test]
fn the_pose_is_that_of_the_part_as_it_is() {
    let solved = clamped(FORM, &map()).json("solve");
    let [z, alpha, beta] = pose(&solved);
    assert!((z - 5.0).abs() < READ_MM && alpha.abs() < 1e-6 && beta.abs() < 1e-6, "{solved}");
    assert!(solved["residual"]["max_abs"].as_f64().unwrap() < READ_MM);
    assert!(!solved["warnings"].to_string().contains("form.csv"), "{}", solved["warnings"]);
    let inputs = solved["inputs"].as_array().unwrap();
    assert!(inputs.iter().any(|input| input["file"] == "form.csv"));
    // As drawn, the part does not fit, and the saddle tilts it.
    let drawn = clamped("", &map()).json("solve");
    assert!(drawn["residual"]["rms"].as_f64().unwrap() > 5e-4, "{}", drawn["residual"]);
    assert!(drawn["warnings"].to_string().contains("form.csv"));
}

#[test]
fn scattered_places_are_brought_to_a_grid() {
    let solved = clamped("[surface.form]\nspacing_mm = 2.5\n", &scattered()).json("solve");
    // A quadric over 5 mm of waves of 1.5 µm and 0.12 /mm leaves (0.12 · 2.5)⁴/8 of them: 2 nm; the
    // ball is 3 mm, and the edge of the map is worse.
    let [z, alpha, beta] = pose(&solved);
    assert!((z - 5.0).abs() < 2e-5 && alpha.abs() < 5e-5 && beta.abs() < 5e-5, "{solved}");
    assert!(solved["residual"]["max_abs"].as_f64().unwrap() < 1e-4, "{}", solved["residual"]);
}

#[test]
fn the_depth_follows_the_form() {
    let case = clamped(FORM, &map());
    // The tool's lowest point follows the part as drawn at 1.2 mm.
    let mut program = "G21 G90\n".to_owned();
    for [x, y] in [[0.0, 0.0], [13.0, 0.0], [-39.0, 0.0], [30.0, -30.0]] {
        let (n, z) = (normal(x, y), sag(x, y));
        let p = [x + 1.2 * n[0] + AT[0], y + 1.2 * n[1] + AT[1], z + 1.2 * n[2] + AT[2]];
        let _ = writeln!(program, "G1 X{:.7} Y{:.7} Z{:.7} F300", p[0], p[1], p[2]);
    }
    case.write("part.ngc", program);
    let (folder, file) = (case.path(), case.file("part.ngc"));
    let words = ["depth", folder.to_str().unwrap(), file.to_str().unwrap()];
    let ended = truing(&[&words[..], &["--planned", "10,-20,5,0,0,0", "--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let json: Value = serde_json::from_str(&ended.stdout).unwrap();
    let depths = json["depths"].as_array().unwrap();
    for (at, [x, y]) in depths.iter().zip([[0.0, 0.0], [13.0, 0.0], [-39.0, 0.0], [30.0, -30.0]]) {
        // Along the drawn normal the film is pressed by the deviation more; the slopes of the map, 2e-4,
        // count with their square.
        let expected = 0.3 + deviation(x, y);
        assert!((at["depth_mm"].as_f64().unwrap() - expected).abs() < 2e-7, "{at} {expected}");
    }
    assert_eq!(depths.len(), 4);
}

#[test]
fn touches_of_the_real_part_have_no_deviation_left() {
    let toml = format!("kind = \"probe-comp\"\n{BOWL}{FORM}[probe]\ntip_radius_mm = 3.0\n");
    let table = touches("touch", [0.0; 3]);
    let with = |toml: &str| {
        Case::new(&[("case.toml", toml), ("touches.csv", &table), ("form.csv", &map())])
    };
    let left = |case: &Case| {
        let solved = case.json("solve");
        let touches = solved["estimates"]["touches"].as_array().unwrap().clone();
        touches.iter().map(|t| t["deviation_mm"].as_f64().unwrap()).collect::<Vec<f64>>()
    };
    assert!(left(&with(&toml)).iter().all(|deviation| deviation.abs() < READ_MM));
    for (found, [x, y]) in left(&with(&toml.replace(FORM, ""))).iter().zip(TOUCHED) {
        // Without the map it is what the map says, but for r δ²/2 and the place of the foot.
        assert!((found - deviation(x, y)).abs() < 1e-6, "{found} at ({x}, {y})");
    }
}

#[test]
fn a_mesh_is_moved_corner_by_corner() {
    // A plate of two triangles, and what was measured of it along z.
    let mesh = "v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nf 1 2 3\nf 1 3 4\n";
    let toml = "kind = \"probe-comp\"\n[surface]\nshape = \"mesh\"\nfile = \"plate.obj\"\n\
                [surface.form]\nalong = \"z\"\n[probe]\ntip_radius_mm = 0.0\nside = \"+z\"\n";
    let mut table = "touch,x_mm,y_mm,z_mm\n".to_owned();
    for (n, [x, y]) in TOUCHED.into_iter().enumerate() {
        let _ = writeln!(table, "P{n},{x},{y},{:.8}", deviation(x, y) + 0.01);
    }
    let files =
        [("case.toml", toml), ("touches.csv", &table), ("form.csv", &map()), ("plate.obj", mesh)];
    let solved = Case::new(&files).json("solve");
    for touch in solved["estimates"]["touches"].as_array().unwrap() {
        // Facets of 1.1 mm on bends of 2.2e-5 /mm: h² κ/8.
        let left = touch["deviation_mm"].as_f64().unwrap();
        assert!((left - 0.01).abs() < 4e-6, "{touch}");
    }
}

/// Message of a `solve` that is refused, with the paths cut off.
fn refused(case: &Case) -> String {
    case.message("solve", 2).replace(&format!("{}/", case.path().display()), "")
}

#[test]
fn what_makes_no_map_is_refused_with_its_place() {
    let case = clamped(FORM, "x_mm,y_mm,deviation_mm\n0,0,0\n1,0,abc\n");
    let said = refused(&case);
    assert!(said.contains("form.csv, line 3, column 3 (`deviation_mm`)"), "{said}");
    let twice = map() + "0,0,0.001\n";
    let said = refused(&clamped(FORM, &twice));
    assert!(said.contains("form.csv, line") && said.contains("no new place"), "{said}");
    let said = refused(&clamped(FORM, &scattered()));
    assert!(said.contains("give `[surface.form] spacing_mm`"), "{said}");
    let said = refused(&clamped("[surface.form]\nspacing_mm = 0.01\n", &scattered()));
    assert!(said.contains("widen it") || said.contains("six others"), "{said}");
    let said = refused(&clamped("[surface.form]\nalong = \"w\"\n", &map()));
    assert!(said.contains("case.toml, line 8, column 9"), "{said}");
    let missing = clamped(FORM, &map());
    std::fs::remove_file(missing.file("form.csv")).unwrap();
    let said = refused(&missing);
    assert!(said.contains("form.csv"), "{said}");
    // Half of the part was measured: a touch on the other half has nothing to be held against.
    let half: String = map()
        .lines()
        .filter(|line| !line.starts_with('-'))
        .map(|line| format!("{line}\n"))
        .collect();
    let said = refused(&clamped(FORM, &half));
    assert!(said.contains("outside"), "{said}");
    let sphere = Case::new(&[
        (
            "case.toml",
            "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
             [surface.form]\n[probe]\ntip_radius_mm = 3.0\n",
        ),
        ("touches.csv", "touch,x_mm,y_mm,z_mm\nA,0,0,28\n"),
        ("form.csv", &map()),
    ]);
    let said = refused(&sphere);
    assert!(said.contains("case.toml, line") && said.contains("asphere"), "{said}");
    let sampled = clamped(FORM, &map());
    let ended = truing(&["itlicp", sampled.path().to_str().unwrap()]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("`[surface.form]`"), "{}", ended.stderr);
}
