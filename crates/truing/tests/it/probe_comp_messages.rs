//! What can be wrong with the touches of a probe, and what is said of them.

use std::fmt::Write as _;
use std::fs;

use crate::command::{Case, truing};

const SPHERE: &str = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
                      [probe]\ntip_radius_mm = 3.0\n[noise]\npoint_mm = 0.001\n";

/// Directions over the upper half of a sphere.
fn directions(n: u32) -> Vec<[f64; 3]> {
    (0..n)
        .map(|i| {
            let z = (f64::from(i) + 0.5) / f64::from(n);
            let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
            let side = (1.0 - z * z).sqrt();
            [side * cos, side * sin, z]
        })
        .collect()
}

/// Touches of the sphere with a pattern for noise, `late_mm` behind the contact.
fn sphere(header: &str, row: impl Fn(usize, [f64; 3]) -> String) -> Case {
    let mut table = format!("touch,x_mm,y_mm,z_mm{header}\n");
    for (i, u) in directions(24).into_iter().enumerate() {
        let noise = [3.0, -5.0, 1.0, 4.0, -2.0, 0.0, -4.0, 5.0, 2.0, -1.0, -3.0][i % 11] * 1e-4;
        let [x, y, z] = u.map(|v| v * (28.0 + noise));
        let _ = writeln!(table, "T{},{x:.6},{y:.6},{z:.6}{}", i + 1, row(i, u));
    }
    Case::new(&[("case.toml", SPHERE), ("touches.csv", &table)])
}

fn plain() -> Case {
    sphere("", |_, _| String::new())
}

fn message(case: &Case, code: i32) -> String {
    case.message("solve", code).replace(&format!("{}/", case.path().display()), "")
}

fn edited(file: &str, from: &str, to: &str) -> Case {
    let case = plain();
    case.replace(file, from, to);
    case
}

/// The plain case with another text in one cell.
fn with_cell(line: usize, column: usize, to: &str) -> Case {
    let case = plain();
    let text = fs::read_to_string(case.file("touches.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut cells: Vec<&str> = lines[line].split(',').collect();
    cells[column] = to;
    lines[line] = cells.join(",");
    case.write("touches.csv", lines.join("\n") + "\n");
    case
}

#[test]
fn surfaces_and_probes_that_cannot_be() {
    let toml = |from: &str, to: &str| message(&edited("case.toml", from, to), 2);
    let unknown = toml("\"sphere\"", "\"spheer\"");
    assert!(unknown.starts_with("case.toml, line 3, column 9: expected one of"), "{unknown}");
    assert!(unknown.contains("did you mean `sphere`"), "{unknown}");
    let absent = toml("radius_mm = 25.0\n", "");
    assert!(absent.contains("`[surface] radius_mm` is missing"), "{absent}");
    let negative = toml("tip_radius_mm = 3.0", "tip_radius_mm = -3.0");
    assert!(negative.starts_with("case.toml, line 6, column 17: `tip_radius_mm`"), "{negative}");
    let no_tip = toml("tip_radius_mm = 3.0\n", "");
    assert!(no_tip.contains("`tip_radius_mm` is missing"), "{no_tip}");
    let key = toml("tip_radius_mm = 3.0", "tip_radius_um = 3000.0");
    assert!(key.contains("name the key `tip_radius_mm`"), "{key}");
    let no_radius = toml("radius_mm = 25.0", "radius_mm = 0.0");
    assert!(no_radius.contains("[surface]: radius 0 mm"), "{no_radius}");
    let no_stylus = toml("tip_radius_mm = 3.0", "tip_radius_mm = 3.0\nstylus = [0, 0, 0]");
    assert!(no_stylus.contains("found the zero vector"), "{no_stylus}");
    let seat = edited("case.toml", "radius_mm = 25.0", "radius_mm = 2.0\nside = \"inside\"");
    let seat = message(&seat, 2);
    assert!(
        seat.starts_with("touches.csv, line 2: ") && seat.contains("use a smaller ball"),
        "{seat}"
    );
}

#[test]
fn touches_that_cannot_be() {
    let far = message(&with_cell(2, 1, "90.0"), 2);
    assert!(far.starts_with("touches.csv, line 3: touch 2: the ball's surface is"), "{far}");
    let twice = message(&edited("touches.csv", "T2,", "T1,"), 2);
    assert!(twice.starts_with("touches.csv, line 3, column 1"), "{twice}");
    let nan = message(&with_cell(7, 1, "NaN"), 2);
    assert!(nan.starts_with("touches.csv, line 8, column 2 (`x_mm`)"), "{nan}");
    let empty = plain();
    empty.write("touches.csv", "touch,x_mm,y_mm,z_mm\n");
    assert!(message(&empty, 2).contains("a header but no rows"));
    let absent = edited("touches.csv", "z_mm", "zz");
    assert!(message(&absent, 2).contains("column `z_mm` is missing"));

    let long = sphere(",nx,ny,nz", |_, u| {
        let [x, y, z] = u.map(|v| -1.1 * v);
        format!(",{x},{y},{z}")
    });
    let long = message(&long, 2);
    assert!(
        long.starts_with("touches.csv, line 2, column 5 (`nx`): (nx, ny, nz) has length 1.1"),
        "{long}"
    );
    let away = sphere(",nx,ny,nz", |_, [x, y, z]| format!(",{x},{y},{z}"));
    assert!(message(&away, 2).contains("touch 1: the approach points away from the part"));
    let two = sphere(",nx,ny", |_, [x, y, _]| format!(",{x},{y}"));
    assert!(message(&two, 2).contains("column `nz` is missing"));
    let none = edited("case.toml", "[noise]", "[model]\nnormal = \"approach\"\n[noise]");
    assert!(message(&none, 2).contains("compensates along these columns"));
}

#[test]
fn micro_planes_are_checked_and_reported() {
    let micro = |rows: &str| {
        let case = plain();
        case.write("micro.csv", format!("touch,k,x_mm,y_mm,z_mm\n{rows}"));
        case
    };
    let unknown = message(&micro("T99,1,0,0,28\n"), 2);
    assert!(unknown.starts_with("micro.csv, line 2, column 1"), "{unknown}");
    let twice = message(&micro("T1,1,0,0,28\nT1,1,0,0,28\n"), 2);
    assert!(twice.starts_with("micro.csv, line 3, column 2"), "{twice}");
    let few = message(&micro("T1,1,0,0,28\nT1,2,1,0,28\n"), 2);
    assert!(few.contains("touch `T1` has 2 further touches"), "{few}");
    let word = message(&micro("T1,first,0,0,28\n"), 2);
    assert!(word.starts_with("micro.csv, line 2, column 2"), "{word}");
    let line = message(&micro("T24,1,0.1,0,28\nT24,2,0.2,0,28\nT24,3,0.3,0,28\n"), 3);
    assert!(line.contains("touch 1 lie on a line") || line.contains("touch 24"), "{line}");

    // Around the pole of the sphere, 0.5 mm away: the height there is 28 cos.
    let z = (28.0_f64 * 28.0 - 0.25).sqrt();
    let (x, y) = (0.5 * 0.75_f64.sqrt(), 0.25);
    let pole = format!("P,1,0.5,0,{z}\nP,2,-0.25,{x},{z}\nP,3,{},{},{z}\n", -y, -x);
    let case = micro(&pole);
    let table = fs::read_to_string(case.file("touches.csv")).unwrap() + "P,0,0,28.002\n";
    case.write("touches.csv", table);
    let solved = case.json("solve");
    let touches = solved["estimates"]["touches"].as_array().unwrap();
    let pole = touches.last().unwrap();
    assert!(pole["measured"]["tilt_deg"].as_f64().unwrap() < 1e-6, "{pole}");
    assert!((pole["deviation_mm"].as_f64().unwrap() - 2e-3).abs() < 1e-9);
    assert!((pole["z_mm"].as_f64().unwrap() - 25.002).abs() < 1e-9);
    assert!(touches[0].get("measured").is_none());
}

#[test]
fn the_side_of_the_ball_is_taken_from_the_touches() {
    let below =
        "kind = \"probe-comp\"\n[surface]\nshape = \"plane\"\n[probe]\ntip_radius_mm = 3.0\n";
    let rows: String = (0..9)
        .map(|i| format!("T{i},{},{},{}\n", i % 3, i / 3, -3.0 - 1e-3 * f64::from(i % 2)))
        .collect();
    let table = format!("touch,x_mm,y_mm,z_mm\n{rows}");
    let case = Case::new(&[("case.toml", below), ("touches.csv", &table)]);
    let solved = case.json("solve");
    assert!(solved["warnings"].to_string().contains("side = \\\"-z\\\""), "{}", solved["warnings"]);
    let touch = &solved["estimates"]["touches"][1];
    assert!((touch["deviation_mm"].as_f64().unwrap() - 1e-3).abs() < 1e-12, "{touch}");
    assert!((touch["nz"].as_f64().unwrap() + 1.0).abs() < 1e-12, "{touch}");
}

#[test]
fn a_grid_of_heights_is_a_surface() {
    let toml = "kind = \"probe-comp\"\n[surface]\nshape = \"grid\"\n[probe]\ntip_radius_mm = 0\n";
    let height = |x: f64, y: f64| 0.01 * x * x - 0.02 * x * y + 0.3 * y;
    let grid = |skip: usize, shift: f64| {
        let mut text = "x_mm,y_mm,z_mm\n".to_owned();
        for k in (0..30).filter(|k| *k != skip) {
            let (x, y) = (
                2.0 * f64::from(u32::try_from(k % 6).unwrap()),
                0.1 * f64::from(u32::try_from(k / 6).unwrap()),
            );
            let x = if k == 8 { x + shift } else { x };
            let _ = writeln!(text, "{x},{y},{}", height(x, y));
        }
        text
    };
    let touches = format!("touch,x_mm,y_mm,z_mm\nT1,3.3,0.17,{}\n", height(3.3, 0.17) + 0.005);
    let with = |heights: &str| {
        Case::new(&[("case.toml", toml), ("touches.csv", &touches), ("heights.csv", heights)])
    };
    let touch = &with(&grid(99, 0.0)).json("solve")["estimates"]["touches"][0];
    let up = touch["nz"].as_f64().unwrap();
    assert!((touch["deviation_mm"].as_f64().unwrap() - 0.005 * up).abs() < 1e-6, "{touch}");
    let gap = message(&with(&grid(8, 0.0)), 2);
    assert!(gap.contains("6 places along x and 5 along y are 30"), "{gap}");
    let uneven = message(&with(&grid(99, 0.3)), 2);
    assert!(
        uneven.starts_with("heights.csv, line 2: ") || uneven.contains("even grid"),
        "{uneven}"
    );
    let absent = Case::new(&[("case.toml", toml), ("touches.csv", &touches)]);
    assert!(message(&absent, 2).contains("heights.csv: the file is missing"));
}

#[test]
fn guide_points_give_the_planned_contact() {
    let case = sphere(",guide_x_mm,guide_y_mm", |_, [x, y, _]| {
        format!(",{:.6},{:.6}", 28.0 * x, 28.0 * y)
    });
    let touch = &case.json("solve")["estimates"]["touches"][23];
    let planned = &touch["planned"];
    // The last touch is at z = 23.5/24 of the radius, and the pattern moves nothing by 1 µm there.
    let height = |key: &str| planned[key].as_f64().unwrap();
    assert!((height("center_z_mm") - 28.0 * 23.5 / 24.0).abs() < 1e-3, "{planned}");
    assert!((height("z_mm") - 25.0 * 23.5 / 24.0).abs() < 1e-3, "{planned}");
    assert!((height("normal_error_mm") - touch["deviation_mm"].as_f64().unwrap()).abs() < 2e-5);
}

#[test]
fn the_report_is_written() {
    let case = plain();
    let page = case.file("report.html");
    let path = case.path().to_str().unwrap();
    for command in ["solve", "loop"] {
        let ended = truing(&[command, path, "--report", page.to_str().unwrap()]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let text = fs::read_to_string(&page).unwrap();
        assert!(text.contains("sphere of radius 25 mm"), "{command}");
    }
}
