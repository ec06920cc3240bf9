//! Touches of a part.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;

use super::{json, message, noise_mm, plan};
use crate::command::{Case, truing};

const SPHERE: &str = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
                      [probe]\ntip_radius_mm = 3.0\n[noise]\npoint_mm = 0.001\n";

/// Touches from far beside the normal tell in a few touches.
const STEEP: &str = "[plan]\noblique_deg = 45\n";

/// By how much the ball is larger than declared.
const LARGER_MM: f64 = 0.008;

/// Touches along the normals of a sphere, with a ball that is larger.
fn larger_ball() -> Case {
    let mut table = String::from("touch,x_mm,y_mm,z_mm\n");
    for i in 0..24_u32 {
        let z = (f64::from(i) + 0.5) / 24.0;
        let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
        let side = (1.0 - z * z).sqrt();
        let reach = 28.0 + LARGER_MM + noise_mm(i as usize);
        let [x, y, z] = [side * cos, side * sin, z].map(|v| v * reach);
        let _ = writeln!(table, "T{},{x:.6},{y:.6},{z:.6}", i + 1);
    }
    Case::new(&[("case.toml", &format!("{SPHERE}{STEEP}")), ("touches.csv", &table)])
}

#[test]
fn rivals_are_told_apart_by_touches_from_beside_the_normal() {
    let case = larger_ball();
    let found = case.json("loop");
    assert_eq!(found["steps"][0]["indistinguishable_from"], serde_json::json!(["pretravel"]));
    let answer = json(&case, &[]);
    assert_eq!((answer["aim"].as_str(), answer["reached"].as_bool()), (Some("rivals"), Some(true)));
    for figure in answer["figures"].as_array().unwrap() {
        assert_eq!(figure["measure"], "probability");
        assert!(figure["before"].as_f64().unwrap() < 0.05, "{figure}");
        assert!(figure["after"].as_f64().unwrap() > 0.9, "{figure}");
    }
    let touches = answer["plan"].as_array().unwrap();
    assert!((1..=24).contains(&touches.len()), "{}", touches.len());
    assert_eq!(answer["planned"].as_u64(), Some(touches.len() as u64));
    // Along the normal they would tell nothing.
    let beside = |touch: &Value| {
        let of = |list: &Value, k: usize| list[k].as_f64().unwrap();
        let (n, a) = (&touch["touch"]["normal"], &touch["touch"]["approach"]);
        (0..3).map(|k| of(n, k) * of(a, k)).sum::<f64>() > -0.9
    };
    assert!(touches.iter().all(beside));
}

/// Of a case that leaves a ball, a radius, a conic constant and a scale along z open: every pair both ways,
/// and of the axes that a scale may be of the one that the touches do not tell from the ball.
#[test]
fn every_pair_of_names_is_asked_for() {
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pose-icp/near-sphere");
    let ended = truing(&["plan", case, "--for", "rivals", "--budget", "12", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    let figures = answer["figures"].as_array().unwrap().iter();
    let asked: Vec<&str> = figures.map(|figure| figure["of"].as_str().unwrap()).collect();
    for pair in
        ["vertex-radius, not conic", "conic, not vertex-radius", "conic, not axis-scale [z]"]
    {
        assert!(asked.contains(&pair), "{asked:?}");
    }
    assert!(!asked.iter().any(|pair| pair.contains("axis-scale [x]")), "{asked:?}");
    // Nothing on the part itself tells its radius from the ball's.
    assert_eq!(answer["reached"].as_bool(), Some(false));
}

/// A bowl, touched along its normals by a stylus that gives way: 20 µm at right angles to it.
fn bowl() -> Case {
    const RADIUS_MM: f64 = 120.0;
    let mut table = String::from("touch,x_mm,y_mm,z_mm\n");
    for k in 0..64_u8 {
        let place = f64::from(u32::from(k) * 13 % 64);
        let rho_mm = 46.0 * ((place + 0.5) / 64.0).sqrt();
        let (sin, cos) = (2.399_963 * place).sin_cos();
        let slope = rho_mm / RADIUS_MM;
        let normal = [-slope * cos, -slope * sin, 1.0].map(|v| v / slope.hypot(1.0));
        let contact_mm = [rho_mm * cos, rho_mm * sin, 0.5 * rho_mm * slope];
        let reach = 3.0 + noise_mm(k.into());
        let give = [0.02, 0.02, 0.0];
        let [x, y, z] = std::array::from_fn(|i| contact_mm[i] + (reach - give[i]) * normal[i]);
        let _ = writeln!(table, "T{},{x:.6},{y:.6},{z:.6}", k + 1);
    }
    let case = "kind = \"probe-comp\"\n[surface]\nshape = \"asphere\"\nradius_mm = 120.0\nconic = -1.0\n\
                diameter_mm = 100.0\n[probe]\ntip_radius_mm = 3.0\n[noise]\npoint_mm = 0.001\n";
    Case::new(&[("case.toml", case), ("touches.csv", &table)])
}

/// Over all that could be touched, the part's focus is its place and the ball's size, and no effect of its own: what it
/// cannot be told from is looked for instead, and not what no touch shows.
#[test]
fn a_name_that_is_none_over_the_whole_part_is_told_from_its_rivals_by_these() {
    let case = bowl();
    let found = case.json("loop");
    assert_eq!(found["steps"][0]["effect"], "focus", "{}", found["steps"]);
    assert_eq!(found["steps"][0]["indistinguishable_from"], serde_json::json!(["bending"]));
    let answer = json(&case, &[]);
    assert_eq!((answer["aim"].as_str(), answer["reached"].as_bool()), (Some("rivals"), Some(true)));
    assert_eq!(answer["figures"][0]["of"], "bending: sideways");
}

#[test]
fn a_plan_filled_in_names_the_ball_alone() {
    let case = larger_ball();
    let folder = case.file("next");
    let ended = plan(&case, &["--out", folder.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stdout.contains("tip-radius, not pretravel"), "{}", ended.stdout);
    let program = fs::read_to_string(folder.join("plan.ngc")).unwrap();
    assert!(program.contains("(PROBEOPEN plan.txt)") && program.ends_with("M2\n"));
    let table = fs::read_to_string(folder.join("touches.csv")).unwrap();
    let planned = table.lines().filter(|line| line.starts_with('N')).count();
    assert_eq!(program.matches("G38.3").count(), planned);
    assert_eq!(table.lines().next(), Some("touch,x_mm,y_mm,z_mm,nx,ny,nz"));

    // What the machine reads, in place of the empty cells: the larger ball, wherever it comes from.
    let answer = json(&case, &[]);
    let mut filled = String::new();
    for line in table.lines() {
        let Some(n) = line.strip_prefix('N').and_then(|l| l.split_once(",,,,")) else {
            filled += &format!("{line}\n");
            continue;
        };
        let index = n.0.parse::<usize>().unwrap() - 1;
        let touch = &answer["plan"][index];
        assert_eq!(touch["name"], format!("N{}", n.0));
        let normal: Vec<f64> =
            (0..3).map(|k| touch["touch"]["normal"][k].as_f64().unwrap()).collect();
        let reach = 28.0 + LARGER_MM + noise_mm(24 + index);
        let at: Vec<String> = normal.iter().map(|v| format!("{:.6}", v * reach)).collect();
        filled += &format!("N{},{},{}\n", n.0, at.join(","), n.1);
    }
    fs::write(folder.join("touches.csv"), filled).unwrap();
    let ended = truing(&["loop", folder.to_str().unwrap(), "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let closed: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(closed["steps"].as_array().unwrap().len(), 1, "{}", closed["steps"]);
    assert_eq!(closed["steps"][0]["effect"], "tip-radius");
    assert_eq!(closed["steps"][0]["indistinguishable_from"], serde_json::json!([]));

    // Nothing that is there is replaced.
    let again = plan(&case, &["--out", folder.to_str().unwrap()]);
    assert_eq!(again.code, 2);
    assert!(again.one_message().contains("exists already"), "{}", again.stderr);
}

#[test]
fn an_answer_saves_the_loop_and_has_to_be_of_these_data() {
    let case = larger_ball();
    let found = case.file("answer.json");
    fs::write(&found, case.json("loop").to_string()).unwrap();
    let by_answer = json(&case, &["--answer", found.to_str().unwrap()]);
    assert_eq!(by_answer["plan"], json(&case, &[])["plan"]);
    case.replace("touches.csv", "T1,", "T0,");
    let told = message(&case, &["--answer", found.to_str().unwrap()]);
    assert_eq!(
        told,
        "answer.json: the answer is of other data: `touches.csv` is not the file that it was made from"
    );
}

#[test]
fn a_quantity_is_known_twice_as_well_or_as_the_budget_lets_it() {
    let case = Case::example("pose-icp");
    let halved = json(&case, &["--for", "z"]);
    let figure = &halved["figures"][0];
    assert_eq!(
        (figure["of"].as_str(), figure["measure"].as_str()),
        (Some("z"), Some("uncertainty"))
    );
    let of = |figure: &Value, key: &str| figure[key].as_f64().unwrap();
    let spent = json(&case, &["--for", "z", "--budget", "3"]);
    assert_eq!((spent["planned"].as_u64(), spent["reached"].as_bool()), (Some(3), Some(true)));
    assert!(of(&spent["figures"][0], "after") < of(&spent["figures"][0], "before"));
    if halved["reached"] == true {
        assert!(of(figure, "after") <= 0.51 * of(figure, "before"), "{figure}");
    } else {
        assert!(halved["would"].is_string());
    }
}

#[test]
fn what_cannot_be_planned_is_said() {
    let case = larger_ball();
    let told = message(&case, &["--for", "tip-radus"]);
    assert!(
        told.contains("--for `tip-radus`: no such effect or quantity; there are rivals"),
        "{told}"
    );
    let told = message(&case, &["--budget", "5min"]);
    assert!(told.contains("needs `[plan] minutes_per_measurement`"), "{told}");
    let path = "run,time_s,path_mm,force_n,reference_n\n".to_owned()
        + &(0..40).map(|i| format!("A,{i},{i},20.{i},20\n")).collect::<String>();
    let along = [("case.toml", "kind = \"force-impedance\"\n"), ("path.csv", path.as_str())];
    let told = message(&Case::new(&along), &["--for", "all"]);
    assert!(told.contains("no plan can be made for this case of kind force-impedance"), "{told}");
    for (plan, said) in [
        ("spacing = 3", "unknown key `spacing`"),
        ("x_mm = [3, 3]", "expected a number and a larger one, [low, high], found [3, 3]"),
        ("oblique_deg = 80", "expected a number from 0 to 70"),
        ("keep_out = [[0, 0, 0]]", "expected a number above 0 for the radius"),
        ("spacing_mm = 0.001", "[plan] makes more than 20000 places; widen `spacing_mm`"),
        ("keep_out = [[0, 0, 99]]", "`[plan]` leaves no place to measure at"),
    ] {
        let case = larger_ball();
        case.write("case.toml", format!("{SPHERE}[plan]\n{plan}\n"));
        let told = message(&case, &[]);
        assert!(told.contains(said), "{plan}: {told}");
    }
}
