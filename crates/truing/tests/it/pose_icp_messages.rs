//! What can be wrong with a surface, a probe, touches and side touches.

use crate::command::Case;

fn message(case: &Case, code: i32) -> String {
    let message = case.message("solve", code);
    message.replace(&format!("{}/", case.path().display()), "")
}

/// The example with text of one of its files replaced.
fn edited(file: &str, from: &str, to: &str) -> Case {
    let case = Case::example("pose-icp");
    case.replace(file, from, to);
    case
}

fn says(file: &str, from: &str, to: &str, expected: &str) {
    let message = message(&edited(file, from, to), 2);
    assert!(message.contains(expected), "{message}");
}

#[test]
fn surfaces() {
    let says = |from: &str, to: &str, expected: &str| says("case.toml", from, to, expected);
    says("\"asphere\"", "\"asfere\"", "found `asfere`; did you mean `asphere`?");
    says("radius_mm = 480.0\n", "", "`[surface] radius_mm` is missing: the vertex radius");
    says("diameter_mm = 100.0", "", "`[surface] diameter_mm` is missing: the part's diameter");
    says("radius_mm = 480.0", "radius_mm = 0.0", "[surface]: radius 0 mm does not make a surface");
    says("diameter_mm = 100.0", "diameter_mm = -5.0", "`diameter_mm` (in mm): expected a number");
    says("conic = -1.0", "conic = 400.0", "aperture reaches 50 mm from the axis, but the conic");
    says("\"asphere\"", "\"polynomial\"", "`[surface] unit_mm` is missing: the length by which");
    says(
        "\"asphere\"",
        "\"polynomial\"\nunit_mm = 100.0\nterms = []",
        "`[surface] terms` is missing: the terms, `[[i, j, a], …]`, a in mm",
    );
    says("\"asphere\"", "\"mesh\"", "`[surface] file` is missing: the mesh, a .stl, .ply or .obj");
    says("\"asphere\"", "\"mesh\"\nfile = \"no.stl\"", "no.stl: cannot be read");
    let case = edited("case.toml", "\"asphere\"", "\"mesh\"\nfile = \"part.stl\"");
    case.write("part.stl", "");
    assert_eq!(message(&case, 2), "part.stl: the file is empty (0 bytes)");
}

#[test]
fn probe_noise_and_pose() {
    let says = |from: &str, to: &str, expected: &str| says("case.toml", from, to, expected);
    let tip = "tip_radius_mm = 3.0";
    says(tip, "tip_radius_mm = -3.0", "tip radius must be zero or positive, got -3");
    says(
        tip,
        "tip_radius_mm = 600.0",
        "points.csv, line 7: a tip of radius 600 mm cannot touch the surface at touch 1, where its \
         radius of curvature is 480.000 mm; use a smaller ball",
    );
    says(tip, "tip_radius_mm = 3.0\nside = \"up\"", "expected one of `+z`, `-z`, found `up`");
    says("point_mm = 0.001", "point_mm = 0.0", "`point_mm` (in mm): expected a number between");
    says("point_mm = 0.001", "edge_mm = 0.005", "`[noise] point_mm` is missing: the uncertainty");
    says("gamma_deg = 0.0", "gamma_deg = nan", "`gamma_deg` (in degrees): expected a number");
    says("# held = [\"x\", \"y\"]", "held = [\"w\"]", "expected one of `x`, `y`, `z`, `alpha`");
    says(
        "# initial = { x_mm = -499.0",
        "initial = { x_mm = -300.0",
        "has no closest point where the search starts",
    );
}

#[test]
fn touches() {
    let says = |from: &str, to: &str, expected: &str| says("points.csv", from, to, expected);
    let line = "P7,-470.5383";
    says(line, "P7,nan", "line 13, column 2 (`x_mm`): expected a number in mm");
    says(line, "P6,-470.5383", "duplicate point `P6`, first used in line 12");
    // A touch is counted as the table has it, check points included.
    says(line, "P7,-470538300", "line 13: touch 7: coordinate -470538300 mm is not a finite");
    says(line, "P7,-390.5383", "line 13: touch 7 lies outside the aperture: it meets the surface");
    says("z_mm", "z_cm", "column `z_cm` is not in the unit expected: give it in mm");
}

#[test]
fn side_touches() {
    let edge = "back,-499.2951,-421.5476,-292.6995\n";
    says("edge.csv", edge, "", "edge.csv: expected 5 rows, four side touches");
    let says = |from: &str, to: &str, expected: &str| says("edge.csv", from, to, expected);
    says(
        "front,-499.2944,-527.5486",
        "front,-499.2944,-421.5476",
        "edge.csv: the side touches do not surround the part: touches 1 and 3 are 0.000 mm apart \
         along y",
    );
}

/// `n` touches of the example's mirror, level at the origin, without side touches.
fn without_sides(touches: &[[f64; 2]]) -> Case {
    let case = Case::example("pose-icp");
    std::fs::remove_file(case.file("edge.csv")).unwrap();
    let mut text = "point,x_mm,y_mm,z_mm\n".to_owned();
    for (i, [x, y]) in touches.iter().enumerate() {
        let z = (x * x + y * y) / 960.0;
        text += &format!("P{i},{x},{y},{z}\n");
    }
    case.write("points.csv", text);
    case.replace("case.toml", "tip_radius_mm = 3.0", "tip_radius_mm = 0.0");
    case
}

/// A part of 4 × 4 squares, 10 mm wide, its faces as `faces` makes them.
fn mesh_part(faces: impl Fn(&mut Vec<[u32; 3]>)) -> String {
    let mut corners = Vec::new();
    for k in (0..20).filter(|k| k % 5 < 4) {
        corners.extend([[k, k + 1, k + 6], [k, k + 6, k + 5]]);
    }
    faces(&mut corners);
    let mut text = String::new();
    for k in 0..25 {
        let (x, y) = (10 * (k % 5), 10 * (k / 5));
        text += &format!("v {x} {y} {}\n", f64::from(x * x - x * y) / 100.0);
    }
    for [a, b, c] in corners {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text
}

#[test]
fn meshes_that_are_no_surface() {
    let settings = "kind = \"pose-icp\"\n[surface]\nshape = \"mesh\"\nfile = \"part.obj\"\n";
    let points = "point,x_mm,y_mm,z_mm\nP1,1,1,0\n";
    let says = |part: String, code: i32, expected: &str| {
        let files = [("case.toml", settings), ("points.csv", points), ("part.obj", &part[..])];
        let message = message(&Case::new(&files), code);
        assert!(message.contains(expected), "{message}");
    };
    says(mesh_part(|faces| drop(faces.drain(10..12))), 2, "part.obj: the target mesh has 1 holes");
    says(
        mesh_part(|faces| faces.push([6, 6, 7])),
        2,
        "part.obj: 1 faces of the target have no area, the first is face 32, from 0",
    );
    says(mesh_part(Vec::clear), 2, "part.obj: the file holds no faces");
    // The whole mesh is one, and asks for more touches.
    says(mesh_part(|_| ()), 3, "5 unknowns of the pose need at least as many touches, got 1");
}

/// What the touches leave free is exit code 3, and named.
#[test]
fn touches_that_do_not_determine_the_pose() {
    let case = without_sides(&[[0.0, 0.0], [40.0, 0.0], [0.0, 40.0]]);
    assert_eq!(
        message(&case, 3),
        "points.csv: 5 unknowns of the pose need at least as many touches, got 3; touch more \
         points, or hold what is known"
    );
    let ring: Vec<_> = (0..12)
        .map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
            [40.0 * cos, 40.0 * sin]
        })
        .collect();
    let message = message(&without_sides(&ring), 3);
    assert!(message.contains("points.csv: the touches do not determine"), "{message}");
    assert!(message.contains("the position along") && message.contains("tilt about"), "{message}");
}
