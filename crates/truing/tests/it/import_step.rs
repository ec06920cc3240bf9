//! `truing import step`: faces that Open CASCADE wrote, against its own points and normals of them.

use std::path::PathBuf;

use geometry::Surface;
use truing::geometry;
use truing::geometry::nalgebra::{Point3, Vector3};
use truing::{StepFace, StepSurface, read_step};

use crate::command::{Case, truing};

/// Coordinates in the files have 13 digits, and are of 50 mm.
const DIGITS_MM: f64 = 5e-11;
/// What that makes of a direction over a control point's distance of 5 mm.
const DIGITS_RAD: f64 = 1e-10;

fn part(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/it/step").join(name)
}

/// Number of the face, point, and normal out of the part, of every row of a table.
fn points(name: &str) -> Vec<(usize, Point3<f64>, Vector3<f64>)> {
    let table = std::fs::read_to_string(part(&format!("{name}.csv"))).unwrap();
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let face = line.split(',').next().unwrap().parse().unwrap();
        (face, Point3::new(v[1], v[2], v[3]), Vector3::new(v[4], v[5], v[6]))
    };
    table.lines().skip(1).map(row).collect()
}

/// Distance of a point from a face, and the face's normal there; `None` for one that no case takes.
fn foot(face: &StepFace, point: &Point3<f64>) -> Option<(f64, Vector3<f64>)> {
    let sign = if face.is_reversed { -1.0 } else { 1.0 };
    let (distance, normal) = match face.surface.as_ref().unwrap() {
        StepSurface::Net(net) => {
            let foot = net.nurbs().unwrap().closest_point(point).unwrap();
            ((foot.point_mm - point).norm(), foot.normal.into_inner())
        }
        StepSurface::Plane { point_mm, normal } => {
            ((point - point_mm).dot(normal).abs(), normal.into_inner())
        }
        StepSurface::Sphere { center_mm, radius_mm } => {
            let arm = point - center_mm;
            ((arm.norm() - radius_mm).abs(), arm.normalize())
        }
        _ => return None,
    };
    Some((distance, normal * sign))
}

#[test]
fn points_and_normals_are_those_of_open_cascade() {
    let expected = [
        ("block", 2),
        ("inch", 2),
        ("quarter-cylinder", 5),
        ("sphere", 3),
        ("analytic", 8),
        ("cavity", 2),
    ];
    for (name, n_faces) in expected {
        let step = read_step(&part(&format!("{name}.step"))).unwrap();
        let mut compared = Vec::new();
        for (number, point, normal) in points(name) {
            let face = &step.faces[number - 1];
            assert!(face.is_of_solid);
            let Some((distance, found)) = foot(face, &point) else { continue };
            assert!(distance < DIGITS_MM, "{name}, face {number}: {distance:e} mm off");
            assert!(
                (found - normal).norm() < DIGITS_RAD,
                "{name}, face {number}: {found} {normal}"
            );
            compared.push(number);
        }
        compared.dedup();
        assert_eq!(compared.len(), n_faces, "{name}");
    }
}

#[test]
fn units_are_honoured() {
    let units = ["block", "inch"].map(|name| {
        let step = read_step(&part(&format!("{name}.step"))).unwrap();
        step.faces.iter().map(|face| face.unit_mm).collect::<Vec<_>>()
    });
    assert_eq!(units, [vec![1.0; 6], vec![25.4; 6]]);
    let text = std::fs::read_to_string(part("block.step")).unwrap();
    let metre = Case::new(&[(
        "part.step",
        &text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"),
    )]);
    let unit_mm = read_step(&metre.file("part.step")).unwrap().faces[0].unit_mm;
    assert_eq!(unit_mm.to_string(), "1000");
}

fn imported(arguments: &[&str], name: &str) -> (Case, String) {
    let case = Case::new(&[]);
    let (file, out) = (part(name), case.file("part"));
    let fixed = ["import", "step", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let made = truing(&[&fixed[..], arguments].concat());
    assert_eq!(made.code, 0, "{}", made.stderr);
    (case, made.stdout)
}

/// Balls of 2 mm that touch the part 4 µm above each point of a face.
fn touched(name: &str, face: usize) -> String {
    let mut table = "touch,x_mm,y_mm,z_mm\n".to_owned();
    for (n, (_, point, normal)) in points(name).iter().filter(|row| row.0 == face).enumerate() {
        let center = point + normal * 2.004;
        table.push_str(&format!("T{n},{},{},{}\n", center.x, center.y, center.z));
    }
    table
}

/// The ball is outside of the part, whichever way the face's parameters run and however it lies.
#[test]
fn faces_of_every_kind_and_side_become_cases_that_solve() {
    let faces = [
        ("block.step", "block", 5),
        ("block.step", "block", 6),
        ("inch.step", "inch", 5),
        ("inch.step", "inch", 6),
        ("quarter-cylinder.step", "quarter-cylinder", 1),
        ("analytic.step", "analytic", 3),
        ("analytic.step", "analytic", 7),
    ];
    for (file, name, number) in faces {
        let face = number.to_string();
        let (case, _) = imported(&["--face", &face, "--tip-radius", "2"], file);
        let folder = case.file("part");
        std::fs::write(folder.join("touches.csv"), touched(name, number)).unwrap();
        let solved = truing(&["solve", folder.to_str().unwrap(), "--json"]);
        assert_eq!(solved.code, 0, "{name} {number}: {}", solved.stderr);
        let solved: serde_json::Value = serde_json::from_str(&solved.stdout).unwrap();
        let touches = solved["estimates"]["touches"].as_array().unwrap();
        assert_eq!(touches.len(), 25);
        for touch in touches {
            let deviation = touch["deviation_mm"].as_f64().unwrap();
            assert!((deviation - 0.004).abs() < DIGITS_MM, "{name} {number}: {touch}");
        }
    }
}

#[test]
fn control_points_are_added_to_a_case_that_is_there() {
    let case = Case::example("probe-comp");
    let before = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let (file, out) = (part("block.step"), case.path().to_str().unwrap());
    let made = truing(&["import", "step", file.to_str().unwrap(), "--face", "5", "--out", out]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    assert!(made.stdout.contains("shape = \"nurbs\""), "{}", made.stdout);
    assert_eq!(std::fs::read_to_string(case.file("case.toml")).unwrap(), before);
    assert!(case.file("control.csv").exists());
}

#[test]
fn without_a_folder_the_faces_are_listed() {
    let listed = |name: &str| {
        let ended = truing(&["import", "step", part(name).to_str().unwrap()]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        ended.stdout
    };
    let analytic = listed("analytic.step");
    for words in [
        "10 faces",
        "plane through (-30, -30, -20), facing (-1, 0, 0)",
        "plane through (-30, -30, 0), facing (0, 0, 1)",
        "sphere of radius 10 mm about (-10, -10, 4), from inside",
        "torus of radii 8 and 2 mm",
        "cylinder of radius 5 mm about the axis through (18, 18, -30) along (0, 0, 1), from inside; no shape",
    ] {
        assert!(analytic.contains(words), "{words}\n{analytic}");
    }
    assert!(listed("block.step").contains("B-spline of degree 3 × 3, 8 × 7 control points over x"));
    assert!(listed("quarter-cylinder.step").contains("rational B-spline of degree 2 × 1"));
    assert!(listed("assembly.step").contains("in the coordinates of its own part"));
}

fn message(file: &std::path::Path, arguments: &[&str]) -> String {
    let case = Case::new(&[]);
    let out = case.file("part");
    let fixed = ["import", "step", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let ended = truing(&[&fixed[..], arguments].concat());
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
    assert!(!out.exists());
    ended.one_message()
}

#[test]
fn a_face_that_is_not_chosen_or_not_there_is_said() {
    let asked = |face: &str| message(&part("analytic.step"), &["--face", face]);
    assert!(message(&part("analytic.step"), &[]).contains("has 10 faces; say which by --face N"));
    assert!(asked("11").contains("there is no face 11; the file has 10"));
    assert!(asked("0").contains("there is no face 0"));
    assert!(asked("9").contains("line 266: face 9 is a cylinder of radius 5 mm"), "{}", asked("9"));
}

/// What is put into a file, in place of what, and what is then said of face 5.
const BROKEN: [(&str, &str, &str); 13] = [
    ("ISO-10303-21;", "solid part", "expected a STEP file"),
    ("END-ISO-10303-21;", "", "the file ends in or behind"),
    ("#10 = ADVANCED", "#9 = ADVANCED", "line 22: #9 is already on line 21"),
    ("#15 = MANIFOLD", "#99999 = MANIFOLD", "line 22: #10 refers to #15, which is not in the file"),
    (
        "#203 = ADVANCED_FACE('',(#204),#210,.T.)",
        "#203 = ADVANCED_FACE('',(#204),#211",
        "`,` or `)`",
    ),
    (
        "(#204),#210,.T.)",
        "(#204),#210,.U.)",
        "#203: attribute 4 of `ADVANCED_FACE` has to be .T. or .F.",
    ),
    ("(#204),#210,", "(#204),#999999,", "#203 refers to #999999, which is not in the file"),
    (
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(",
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,9000000000,(",
        "a whole number",
    ),
    (
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(",
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,2,(",
        "need 10 knots along v",
    ),
    (
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(",
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,3,((),",
        "lists of one length",
    ),
    ("LENGTH_UNIT()", "MASS_UNIT()", "says no unit of length"),
    (".MILLI.,.METRE.", ".MILLI.,.PARSEC.", "says no unit of length"),
    (
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,3,(",
        "#210 = B_SPLINE_SURFACE_WITH_KNOTS('',3,3,((((((((((((((((((((((((",
        "nested deeper",
    ),
];

#[test]
fn what_is_broken_is_said_with_line_and_entity() {
    let text = std::fs::read_to_string(part("block.step")).unwrap();
    for (from, to, expected) in BROKEN {
        assert!(text.contains(from), "{from}");
        let case = Case::new(&[("part.step", &text.replacen(from, to, 1))]);
        let said = message(&case.file("part.step"), &["--face", "5"]);
        assert!(said.contains(expected), "{from} → {to}\n{said}");
    }
}

/// Cut anywhere, a file is an error and no panic.
#[test]
fn a_file_cut_anywhere_is_refused() {
    let bytes = std::fs::read(part("cavity.step")).unwrap();
    for end in 0..bytes.len() - 2 {
        let case = Case::new(&[]);
        case.write("part.step", &bytes[..end]);
        let error = read_step(&case.file("part.step")).unwrap_err();
        assert_eq!(error.exit_code(), 2);
    }
}
