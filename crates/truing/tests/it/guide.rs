//! `truing guide`: where a ball is sent, and where it will touch.

use std::fs;

use serde_json::Value;

use crate::command::{Case, Ended, truing};

/// A bowl of 120 mm vertex radius, and where it may be touched.
const BOWL: &str = "kind = \"probe-comp\"\n[surface]\nshape = \"asphere\"\nradius_mm = 120.0\n\
    conic = -1.0\ndiameter_mm = 100.0\n[probe]\ntip_radius_mm = 3.0\n[plan]\nx_mm = [-30, 30]\n\
    y_mm = [-20, 20]\nspacing_mm = 20\n";
const TOUCHES: &str = "touch,x_mm,y_mm,z_mm\nA,0,0,3.001\nB,20,-10,5.13\nC,-25,15,6.68\n";

fn case() -> Case {
    Case::new(&[("case.toml", BOWL), ("touches.csv", TOUCHES)])
}

fn guide(case: &Case, more: &[&str]) -> Ended {
    truing(&[&["guide", case.path().to_str().unwrap()], more].concat())
}

fn json(case: &Case, more: &[&str]) -> Value {
    let ended = guide(case, &[more, &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

fn triple(guide: &Value, of: &str) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| guide[format!("{of}_{axis}_mm")].as_f64().unwrap())
}

/// What every guide point of the bowl has to hold, to the round-off of 100 mm.
fn assert_sound(guide: &Value) {
    let ([gx, gy, gz], center, contact) =
        (triple(guide, "guide"), triple(guide, "center"), triple(guide, "contact"));
    assert!((gz - (gx * gx + gy * gy) / 240.0).abs() < 1e-9, "{guide}");
    assert!((center[0] - gx).abs() < 1e-9 && (center[1] - gy).abs() < 1e-9, "{guide}");
    let [x, y, z] = contact;
    assert!((z - (x * x + y * y) / 240.0).abs() < 1e-9, "{guide}");
    let length = (1.0 + (x * x + y * y) / 120.0_f64.powi(2)).sqrt();
    let normal = [-x / 120.0 / length, -y / 120.0 / length, 1.0 / length];
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        assert!((guide[format!("normal_{axis}")].as_f64().unwrap() - normal[k]).abs() < 1e-9);
        assert!((center[k] - contact[k] - 3.0 * normal[k]).abs() < 1e-9, "{guide}");
        let angle = guide[format!("angle_{axis}_deg")].as_f64().unwrap().to_radians();
        assert!((angle.cos() - normal[k]).abs() < 1e-9, "{guide}");
    }
}

#[test]
fn a_lattice_over_the_part_becomes_touches_that_lie_on_it() {
    let case = case();
    let answer = json(&case, &[]);
    let guides = answer["guides"].as_array().unwrap();
    assert!(guides.len() >= 6, "{answer}");
    guides.iter().for_each(assert_sound);
    let (all, touches) = (case.file("guides.csv"), case.file("rows.csv"));
    let ended =
        guide(&case, &["--out", all.to_str().unwrap(), "--touches", touches.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stdout.contains("guide points for a ball of radius 3 mm"), "{}", ended.stdout);
    let table = fs::read_to_string(&all).unwrap();
    assert_eq!(table.lines().count(), 1 + guides.len());
    let rows = fs::read_to_string(&touches).unwrap();
    assert!(rows.starts_with("touch,guide_x_mm,guide_y_mm,x_mm,y_mm,z_mm\n"), "{rows}");
    // Filled in with what an ideal part gives, nothing is left of the errors.
    let mut filled = String::from("touch,guide_x_mm,guide_y_mm,x_mm,y_mm,z_mm\n");
    for (row, guide) in rows.lines().skip(1).zip(guides) {
        let [x, y, z] = triple(guide, "center");
        filled += &format!("{},{x:.6},{y:.6},{z:.6}\n", row.trim_end_matches(",,,"));
    }
    let measured = Case::new(&[("case.toml", BOWL), ("touches.csv", &filled)]);
    let solved = measured.json("solve");
    for touch in solved["estimates"]["touches"].as_array().unwrap() {
        // Six decimals of guide points and centres.
        let error = touch["planned"]["normal_error_mm"].as_f64().unwrap();
        assert!(error.abs() < 2e-6, "{touch}");
    }
}

#[test]
fn guide_points_above_touches_and_of_a_plan() {
    let case = case();
    let above = json(&case, &["--touched"]);
    let guides = above["guides"].as_array().unwrap();
    assert_eq!(guides.len(), 3);
    guides.iter().for_each(assert_sound);
    assert_eq!(guides[1]["touch"], "B");
    assert_eq!(guides[1]["guide_x_mm"], 20.0);
    let planned = truing(&[
        "plan",
        case.path().to_str().unwrap(),
        "--for",
        "tip-radius",
        "--budget",
        "4",
        "--json",
    ]);
    assert_eq!(planned.code, 0, "{}", planned.stderr);
    case.write("plan.json", &planned.stdout);
    let plan: Value = serde_json::from_str(&planned.stdout).unwrap();
    let file = case.file("plan.json");
    let of_plan = json(&case, &["--plan", file.to_str().unwrap()]);
    let (guides, plan) = (of_plan["guides"].as_array().unwrap(), plan["plan"].as_array().unwrap());
    assert_eq!(guides.len(), plan.len());
    for (guide, planned) in guides.iter().zip(plan) {
        assert_sound(guide);
        assert_eq!(guide["touch"], planned["name"]);
        let ball: Vec<f64> =
            (0..3).map(|k| planned["touch"]["ball_mm"][k].as_f64().unwrap()).collect();
        assert!((guide["guide_x_mm"].as_f64().unwrap() - ball[0]).abs() < 1e-9);
        // The plan's ball lies on the part, along its normal.
        assert!(
            (guide["center_z_mm"].as_f64().unwrap() - ball[2]).abs() < 1e-6,
            "{guide} {ball:?}"
        );
    }
}

#[test]
fn a_ball_from_above_touches_no_underside() {
    let ball = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n[probe]\n\
                tip_radius_mm = 3.0\n[plan]\nspacing_mm = 10\nx_mm = [-25, 25]\ny_mm = [-25, 25]\n\
                z_mm = [-25, 25]\n";
    let touches = "touch,x_mm,y_mm,z_mm\nA,0,0,28\nB,28,0,0\nC,0,-28,0\n";
    let case = Case::new(&[("case.toml", ball), ("touches.csv", touches)]);
    let answer = json(&case, &[]);
    let guides = answer["guides"].as_array().unwrap();
    assert!(guides.len() > 3 && answer["beside_the_part"].as_u64().unwrap() > 3, "{answer}");
    assert!(guides.iter().all(|guide| guide["normal_z"].as_f64().unwrap() > 0.0), "{answer}");
}

#[test]
fn what_has_no_guide_points_is_said() {
    let case = case();
    case.write("plan.json", "{\"kind\":\"pose-icp\",\"plan\":[]}");
    let file = case.file("plan.json");
    let ended = guide(&case, &["--plan", file.to_str().unwrap()]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("it is of a case of kind `pose-icp`"), "{}", ended.stderr);
    let ended = guide(&Case::example("pose-icp"), &[]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("kind `pose-icp` has no place"), "{}", ended.stderr);
    case.replace("touches.csv", "C,-25,15,6.68", "C,-250,15,6.68");
    let ended = guide(&case, &["--touched"]);
    assert_eq!(ended.code, 2);
    assert!(ended.stderr.contains("touches.csv, line 4"), "{}", ended.stderr);
    let own = case.file("touches.csv");
    let ended = guide(&case, &["--out", own.to_str().unwrap()]);
    assert_eq!(ended.code, 2, "{}", ended.stdout);
}

/// A row of touches over a cylinder that no drawing shows: its own slopes give the contacts.
#[test]
fn a_profile_is_compensated_by_its_own_slope() {
    let toml = "kind = \"probe-comp\"\n[surface]\nshape = \"plane\"\n[probe]\n\
                tip_radius_mm = 3.0\n[model]\nnormal = \"profile\"\n[noise]\npoint_mm = 0.001\n";
    let mut table = "touch,x_mm,y_mm,z_mm\n".to_owned();
    for k in -20..=20 {
        let x = 0.5 * f64::from(k);
        let z = (203.0_f64.powi(2) - x * x).sqrt() - 200.0;
        table += &format!("P{},{x},4.0,{z:.9}\n", k + 21);
    }
    let case = Case::new(&[("case.toml", toml), ("touches.csv", &table)]);
    let solved = case.json("solve");
    for touch in solved["estimates"]["touches"].as_array().unwrap() {
        let [x, z] = ["x_mm", "z_mm"].map(|key| touch[key].as_f64().unwrap());
        // On the cylinder of 200 mm; the outermost slopes are of third order, 0.5 mm apart.
        assert!((x.hypot(z + 200.0) - 200.0).abs() < 1e-6, "{touch}");
        assert_eq!(touch["y_mm"], 4.0);
    }
    case.replace("touches.csv", "P7,-7,4.0", "P7,-7,5.0");
    let message = case.message("solve", 2);
    assert!(
        message.contains("touches.csv, line 8") && message.contains("beside the row"),
        "{message}"
    );
}
