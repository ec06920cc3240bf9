//! A probe that is qualified on an artefact within its case.

use std::fmt::Write as _;

use crate::command::Case;

/// Late by this along the approach.
const PRETRAVEL_MM: f64 = 0.008;
/// Three lobes about z, cos and sin, at right angles to the stylus.
const LOBES_MM: [f64; 2] = [0.006, -0.003];
const BENDING_MM: f64 = 0.004;
/// Where the artefact stands.
const PLACE_MM: [f64; 3] = [50.0, -30.0, 20.0];
const SPHERE_MM: f64 = 12.5;
/// Nine decimals in the tables, and the approaches of nine decimals times the errors.
const TABLE_TOL_MM: f64 = 5e-9;

const TOML: &str = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
                    [probe]\ntip_radius_mm = 3.0\n[noise]\npoint_mm = 0.001\n\
                    [qualification]\nshape = \"sphere\"\nradius_mm = 12.5\n";

fn directions(n: u32) -> impl Iterator<Item = (u32, [f64; 3])> {
    (0..n).map(move |k| {
        let up = 0.05 + 0.94 * (f64::from(k) + 0.5) / f64::from(n);
        let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
        let side = (1.0 - up * up).sqrt();
        (k, [side * cos, side * sin, up])
    })
}

/// What the probe reads from a sphere that is approached along its normal.
fn read(center: [f64; 3], radius_mm: f64, up: [f64; 3]) -> [f64; 3] {
    let side = up[0].hypot(up[1]);
    // The approach is the normal reversed: half a turn further about the stylus.
    let turn = 3.0 * (-up[1]).atan2(-up[0]);
    let late = PRETRAVEL_MM + side * (LOBES_MM[0] * turn.cos() + LOBES_MM[1] * turn.sin());
    let reach = radius_mm + 3.0 - late;
    [0, 1, 2].map(|k| {
        let bent = if k < 2 { -BENDING_MM * up[k] } else { 0.0 };
        center[k] + reach * up[k] + bent
    })
}

fn table(center: [f64; 3], radius_mm: f64, n: u32) -> String {
    let mut text = "touch,x_mm,y_mm,z_mm,nx,ny,nz\n".to_owned();
    for (k, up) in directions(n) {
        let [x, y, z] = read(center, radius_mm, up);
        let [nx, ny, nz] = up.map(|v| -v);
        let _ = writeln!(text, "T{k},{x:.9},{y:.9},{z:.9},{nx:.9},{ny:.9},{nz:.9}");
    }
    text
}

fn case() -> Case {
    Case::new(&[
        ("case.toml", TOML),
        ("qualification.csv", &table(PLACE_MM, SPHERE_MM, 40)),
        ("touches.csv", &table([0.0; 3], 25.0, 30)),
    ])
}

fn worst_mm(case: &Case) -> f64 {
    let solved = case.json("solve");
    let touches = solved["estimates"]["touches"].as_array().unwrap().clone();
    touches.iter().map(|t| t["deviation_mm"].as_f64().unwrap().abs()).fold(0.0, f64::max)
}

#[test]
fn what_the_artefact_says_is_taken_off() {
    let case = case();
    assert!(worst_mm(&case) < TABLE_TOL_MM, "{}", worst_mm(&case));
    let solved = case.json("solve");
    let found = &solved["estimates"]["qualification"];
    let near = |value: &serde_json::Value, truth: f64| {
        assert!((value.as_f64().unwrap() - truth).abs() < TABLE_TOL_MM, "{found}");
    };
    near(&found["effective_radius_mm"], 3.0 - PRETRAVEL_MM);
    near(&found["pretravel_mm"], PRETRAVEL_MM);
    near(&found["lobes"][0]["cos_mm"], LOBES_MM[0]);
    near(&found["lobes"][0]["sin_mm"], LOBES_MM[1]);
    near(&found["bending_mm"], BENDING_MM);
    // The touches are exact: that they scatter less than declared is all there is to say.
    let warnings = solved["warnings"].as_array().unwrap();
    assert!(
        warnings.iter().all(|w| {
            let w = w.as_str().unwrap();
            w.starts_with("the data scatter only") || w.starts_with("the uncertainty of the qual")
        }),
        "{warnings:?}"
    );
    let people = case.run("solve");
    assert!(people.stdout.contains("effective radius"), "{}", people.stdout);
    // The loop sees a sound probe.
    let closed = case.json("loop");
    assert_eq!(closed["steps"], serde_json::json!([]), "{closed}");

    case.replace("case.toml", "[qualification]\nshape = \"sphere\"\nradius_mm = 12.5\n", "");
    assert!(worst_mm(&case) > PRETRAVEL_MM, "{}", worst_mm(&case));
    assert!(case.json("solve")["warnings"].to_string().contains("qualification.csv"));
}

#[test]
fn artefacts_that_cannot_be() {
    let message = |case: &Case, code: i32| {
        case.message("solve", code).replace(&format!("{}/", case.path().display()), "")
    };
    let edited = |file: &str, from: &str, to: &str, code: i32| {
        let case = case();
        case.replace(file, from, to);
        message(&case, code)
    };
    let ring = edited(
        "case.toml",
        "shape = \"sphere\"\nradius_mm = 12.5",
        "shape = \"cube\"\nradius_mm = 12.5",
        2,
    );
    assert!(ring.contains("expected one of `sphere`, `ring`"), "{ring}");
    let radius = edited("case.toml", "radius_mm = 12.5", "radius_mm = -1.0", 2);
    assert!(radius.contains("radius_mm"), "{radius}");
    let first = edited("case.toml", "radius_mm = 12.5", "radius_mm = 12.5\nlobes = [1]", 2);
    assert!(first.starts_with("case.toml: "), "{first}");
    assert!(first.contains("the first harmonic is the artefact's place"), "{first}");
    let unknown = edited("case.toml", "radius_mm = 12.5", "radius_mm = 12.5\nlobe = [3]", 2);
    assert!(unknown.contains("`lobe`"), "{unknown}");
    let axis = edited(
        "case.toml",
        "shape = \"sphere\"\nradius_mm = 12.5",
        "shape = \"ring\"\nradius_mm = 12.5\naxis = [0, 0, 0]",
        2,
    );
    assert!(axis.contains("found the zero vector"), "{axis}");
    let slip = edited("qualification.csv", "T3,", "T2,", 2);
    assert!(slip.starts_with("qualification.csv, line 5"), "{slip}");
    let few = case();
    few.write("qualification.csv", table(PLACE_MM, SPHERE_MM, 3));
    let said = message(&few, 3);
    assert!(said.starts_with("qualification.csv: "), "{said}");
    assert_eq!(said.matches("effective radius").count(), 1, "{said}");
    let absent = Case::new(&[("case.toml", TOML), ("touches.csv", &table([0.0; 3], 25.0, 9))]);
    assert!(message(&absent, 2).contains("qualification.csv: the file is missing"));
}

/// Three lobes that no place and no radius imitate: as many touches on either side of it.
const FORM_MM: f64 = 0.002;
/// What the squares of the lobes over the radius leave.
const SECOND_ORDER_MM: f64 = 1e-6;

#[test]
fn a_check_of_the_ball_has_the_quantities_of_the_standard() {
    let mut text = "touch,x_mm,y_mm,z_mm\n".to_owned();
    for up in [0.1_f64, 0.5, 0.9] {
        for k in 0..12_u32 {
            let azimuth = std::f64::consts::TAU * f64::from(k) / 12.0;
            let side = (1.0 - up * up).sqrt();
            let normal = [side * azimuth.cos(), side * azimuth.sin(), up];
            let reach = SPHERE_MM + 3.0 - PRETRAVEL_MM + FORM_MM * (3.0 * azimuth).cos();
            let [x, y, z] = [0, 1, 2].map(|c| PLACE_MM[c] + reach * normal[c]);
            let _ = writeln!(text, "U{up}-{k},{x:.9},{y:.9},{z:.9}");
        }
    }
    let case = case();
    case.write("qualification.csv", &text);
    let solved = case.json("solve");
    let check = &solved["estimates"]["qualification"]["probing_check"];
    let near = |value: &serde_json::Value, truth: f64| {
        assert!((value.as_f64().unwrap() - truth).abs() < SECOND_ORDER_MM, "{check}");
    };
    assert_eq!(check["touches"], 36);
    near(&check["form_mm"], 2.0 * FORM_MM);
    near(&check["size_mm"], -2.0 * PRETRAVEL_MM);
    assert!(check["std_size_mm"].as_f64().unwrap() > 0.0, "{check}");

    // The form has no uncertainty, so that nothing is decided of it.
    let toml = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let limits = "[conformity]\nlimits = { \"P_Size.Sph\" = 50.0, \"P_Form.Sph\" = 50.0 }\n";
    case.write("case.toml", format!("{toml}{limits}"));
    let decided = case.json("solve")["conformity"].clone();
    assert_eq!(
        (&decided[0]["parameter"], &decided[0]["decision"]),
        (&"P_Form.Sph".into(), &"undecided".into())
    );
    assert_eq!(
        (&decided[1]["parameter"], &decided[1]["decision"]),
        (&"P_Size.Sph".into(), &"pass".into())
    );
}
