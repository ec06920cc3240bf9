//! `truing plan`: what to measure next, and the loop with it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command::{Case, Ended, truing};

const SPHERE: &str = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
                      [probe]\ntip_radius_mm = 3.0\n[noise]\npoint_mm = 0.001\n";
/// Touches from far beside the normal tell in a few touches.
const STEEP: &str = "[plan]\noblique_deg = 45\n";
/// By how much the ball is larger than declared.
const LARGER_MM: f64 = 0.008;

/// A pattern in place of noise: 1 µm, without memory.
fn noise_mm(i: usize) -> f64 {
    [3.0, -5.0, 1.0, 4.0, -2.0, 0.0, -4.0, 5.0, 2.0, -1.0, -3.0][i * 7 % 11] * 3e-4
}

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

fn plan(case: &Case, further: &[&str]) -> Ended {
    truing(&[&["plan", case.path().to_str().unwrap()], further].concat())
}

fn json(case: &Case, further: &[&str]) -> Value {
    let ended = plan(case, &[further, &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

fn message(case: &Case, further: &[&str]) -> String {
    let ended = plan(case, further);
    assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{}", ended.stderr);
    ended.one_message().replace(&format!("{}/", case.path().display()), "")
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
fn what_a_plane_hides_is_seen_from_points_outside_of_it() {
    let mut table = String::from("point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n");
    for i in 0..16_u32 {
        let [x, y] = [f64::from(i % 4) * 50.0, f64::from(i / 4) * 40.0];
        let [a, b, c] = [0, 3, 6].map(|k| noise_mm(3 * i as usize + k));
        let _ = writeln!(table, "P{i},{x},{y},0,{:.5},{:.5},{:.5}", x + a, y + b, c);
    }
    let toml = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.001\n";
    let case = Case::new(&[("case.toml", toml), ("pairs.csv", &table)]);
    let flat = json(&case, &["--for", "anisotropic-scale"]);
    assert_eq!(flat["reached"], false);
    assert!(flat["would"].as_str().unwrap().contains("no point"), "{}", flat["would"]);
    case.write("case.toml", format!("{toml}[plan]\nz_mm = [-50, 50]\n"));
    let deep = json(&case, &["--for", "anisotropic-scale"]);
    assert_eq!(deep["reached"], true, "{}", deep["would"]);
    let z = |figure: &&Value| figure["of"].as_str().is_some_and(|of| of.ends_with(": z"));
    let figure = deep["figures"].as_array().unwrap().iter().find(z).unwrap();
    assert!(figure["before"].is_null() && figure["after"].is_number(), "{figure}");
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

#[test]
fn a_late_reference_is_seen_where_the_load_changes() {
    let case = Case::example("force-impedance");
    let plan = "\n[noise]\n";
    case.replace(
        "case.toml",
        plan,
        &format!("\n[plan]\nloads_n = [20, 60]\nseconds = 0.5\n{plan}"),
    );
    let folder = case.file("next");
    let written = ["--for", "delay", "--budget", "6", "--out", folder.to_str().unwrap()];
    let answer = json(&case, &written);
    let planned = answer["plan"].as_array().unwrap();
    assert!((1..=6).contains(&planned.len()), "{planned:?}");
    // Under a load that stands still nobody sees when it was read.
    let changes = |run: &&Value| run["cells"]["load_from_n"] != run["cells"]["load_to_n"];
    assert!(2 * planned.iter().filter(changes).count() > planned.len(), "{planned:?}");
    let of = |key: &str| answer["predicted"][key].as_f64().unwrap();
    assert!(of("after") < of("before"), "{}", answer["predicted"]);
    // A controller writes the log: what it is to do is one row a run, and nothing to be filled in.
    let rows = answer["measurements"].as_array().unwrap();
    assert_eq!(rows.len(), planned.len());
    assert_eq!(rows[0]["segment"], "N1");
    let log = |folder: &Path| fs::read_to_string(folder.join("log.csv")).unwrap();
    assert_eq!(log(&folder), log(case.path()));
    let runs = fs::read_to_string(folder.join("plan.csv")).unwrap();
    assert_eq!(runs.lines().count(), 1 + planned.len());
    assert!(runs.starts_with("segment,nx,ny,nz,lean_deg,lean_towards_deg,load_from_n,load_to_n,"));
}

#[test]
fn what_a_head_cannot_do_is_said() {
    for (plan, said) in [
        ("loads_n = [-3]", "expected a force from 0 on, found -3"),
        ("leans_deg = [200]", "expected an angle from upright, from 0 to 180, found 200"),
        ("leans_deg = [170]", "`[plan]` leaves no place to measure at"),
    ] {
        let case = Case::example("force-impedance");
        case.replace("case.toml", "\n[noise]\n", &format!("\n[plan]\n{plan}\n\n[noise]\n"));
        let told = message(&case, &["--for", "delay"]);
        assert!(told.contains(said), "{plan}: {told}");
    }
}

/// An axis that stops 8 µm apart from either side, sent to its targets from below.
fn one_sided() -> Case {
    let mut table = String::from("target_mm,actual_mm,direction\n");
    for i in 0..18_u32 {
        let target = f64::from(i % 9) * 40.0;
        let _ = writeln!(table, "{target},{:.5},+1", target + noise_mm(i as usize));
    }
    let toml = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\n[plan]\ncycles = 2\n";
    Case::new(&[("case.toml", toml), ("positions.csv", &table)])
}

#[test]
fn an_axis_sent_from_one_side_is_sent_from_the_other() {
    let case = one_sided();
    let answer = json(&case, &["--for", "reversal"]);
    let planned = answer["plan"].as_array().unwrap();
    let falling = planned.iter().filter(|one| one["cells"]["direction"] == -1.0).count();
    assert!(falling >= 2, "{planned:?}");
    let of = |key: &str| answer["predicted"][key].as_f64().unwrap();
    // From one side half of the reversal shows, as an offset of the declared noise; from both all of it:
    // with as many readings again the scatter of its size is 1/√2.
    assert!(of("after") < 0.71 * of("before"), "{}", answer["predicted"]);
    // The rows of the table: where to go, and nothing read.
    let rows = answer["measurements"].as_array().unwrap();
    assert_eq!(rows.len(), planned.len());
    for row in rows {
        assert_eq!(row["actual_mm"], "", "{row}");
        assert!(row["target_mm"].as_str().unwrap().parse::<f64>().is_ok(), "{row}");
    }
    assert!(answer["program"].is_null());
    case.replace("case.toml", "cycles = 2", "directions = \"rising\"");
    let rising = json(&case, &["--for", "reversal"]);
    assert_eq!(rising["reached"], false);
    assert!(rising["would"].as_str().unwrap().contains("no reading that the machine"), "{rising}");
}

#[test]
fn a_head_is_pressed_with_the_loads_that_tell() {
    let case = Case::example("ft-center");
    let toml = fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", format!("{toml}[plan]\nloads_n = [20, 60]\nleans_deg = [8]\n"));
    let folder = case.file("next");
    let answer =
        json(&case, &["--for", "load-shift", "--budget", "6", "--out", folder.to_str().unwrap()]);
    let loads: Vec<f64> = (answer["plan"].as_array().unwrap().iter())
        .map(|one| one["cells"]["load_n"].as_f64().unwrap())
        .collect();
    assert!(loads.contains(&20.0) && loads.contains(&60.0), "{loads:?}");
    let figure = |key: &str| answer["figures"][0][key].as_f64();
    assert!(figure("after").unwrap() < figure("before").unwrap_or(f64::INFINITY), "{answer}");
    // Presses to be made, and no record of any.
    let presses = fs::read_to_string(folder.join("presses.csv")).unwrap();
    assert_eq!(presses.lines().filter(|line| line.starts_with('N')).count(), loads.len());
    let wrench = fs::read_to_string(folder.join("wrench.csv")).unwrap();
    assert!(wrench.lines().all(|line| !line.starts_with('N')));
    let ended = truing(&["solve", folder.to_str().unwrap()]);
    assert!(ended.one_message().contains("press `N1` has no rows in wrench.csv; measure it"));
}

#[test]
fn a_tracer_is_given_angles_and_a_station() {
    let case = Case::example("tracker-lm");
    let toml = fs::read_to_string(case.file("case.toml")).unwrap();
    let region = "x_mm = [-700, 700]\ny_mm = [-400, 400]\nz_mm = [-900, 900]\nspacing_mm = 900\n";
    case.write("case.toml", format!("{toml}[plan]\n{region}"));
    let folder = case.file("next");
    let answer = json(&case, &["--for", "all", "--budget", "3", "--out", folder.to_str().unwrap()]);
    assert_eq!((answer["planned"].as_u64(), &answer["noun"]), (Some(3), &Value::from("run")));
    let stations = |text: &str| text.lines().filter(|line| line.starts_with('N')).count();
    let written = fs::read_to_string(folder.join("stations.csv")).unwrap_or_default();
    let new = (answer["plan"].as_array().unwrap().iter())
        .filter(|one| one["cells"]["x_mm"].is_number())
        .count();
    assert_eq!(stations(&written), new);
    // Every reading of a run is a row of the table to be filled in.
    let rows = answer["measurements"].as_array().unwrap();
    assert!(rows.len() > 3 * 3 && rows.iter().all(|row| row["displacement_mm"] == ""), "{rows:?}");
}

/// Points of reflectors on an axis that was only turned upwards.
fn points_upwards() -> Case {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/tracker-lm/targets-nothing");
    let text = |name: &str| fs::read_to_string(Path::new(folder).join(name)).unwrap();
    let same = ["case.toml", "stations.csv", "mounts.csv"].map(|name| (name, text(name)));
    let case = Case::new(&same.each_ref().map(|(name, text)| (*name, text.as_str())));
    let text = text("targets.csv");
    let mut lines = text.lines();
    let mut table = format!("{},direction\n", lines.next().unwrap());
    for line in lines {
        let _ = writeln!(table, "{line},1");
    }
    case.write("targets.csv", table);
    case
}

#[test]
fn a_tracker_of_points_is_told_to_turn_the_axis_the_other_way() {
    let case = points_upwards();
    let folder = case.file("next");
    let answer = json(&case, &["--for", "backlash", "--out", folder.to_str().unwrap()]);
    let plan = answer["plan"].as_array().unwrap();
    // All from the other side, but for the ends from the first one again, which show another session.
    let (again, other): (Vec<_>, Vec<_>) =
        plan.iter().partition(|run| run["cells"]["direction"].as_f64() == Some(1.0));
    assert!(!other.is_empty());
    let mut ends: Vec<f64> =
        again.iter().map(|run| run["cells"]["angle_deg"].as_f64().unwrap()).collect();
    ends.sort_by(f64::total_cmp);
    assert_eq!(ends, [-90.0, 90.0]);
    for run in other {
        assert_eq!(run["cells"]["direction"].as_f64(), Some(-1.0), "{run}");
    }
    // Every reflector that a station saw, at every step, with its point to be measured.
    let rows = answer["measurements"].as_array().unwrap();
    assert_eq!(rows.len() % plan.len(), 0);
    for row in rows {
        assert!(["x_mm", "y_mm", "z_mm"].iter().all(|column| row[*column] == ""), "{row}");
        assert!(row["station"].as_str().is_some_and(|s| s.starts_with('S')), "{row}");
    }
    assert_eq!(answer["measured"].as_u64(), Some(13), "steps, not readings");
}

#[test]
fn a_further_tracker_and_a_further_reflector_of_points_have_rows_of_their_own() {
    let case = points_upwards();
    let toml = fs::read_to_string(case.file("case.toml")).unwrap();
    let plan = "[plan]\nangles_deg = []\nx_mm = [-2000, 2000]\ny_mm = [1900, 2000]\nz_mm = [0, 100]\n\
                spacing_mm = 2000\nmounts_mm = [[400, 0, 100]]\n";
    case.write("case.toml", format!("{toml}\n{plan}"));
    let folder = case.file("next");
    let answer =
        json(&case, &["--for", "all", "--budget", "20", "--out", folder.to_str().unwrap()]);
    let new = |table: &str| {
        let text = fs::read_to_string(folder.join(table)).unwrap();
        text.lines().filter(|line| line.starts_with('N')).count()
    };
    let (stations, mounts) = (new("stations.csv"), new("mounts.csv"));
    // All that is offered is within the budget.
    assert!(stations > 1 && mounts == 1, "{stations} {mounts}");
    assert_eq!(answer["planned"].as_u64(), Some((stations + mounts) as u64));
}

#[test]
fn a_free_tool_is_tilted_to_where_its_weight_tells() {
    let mut table = String::from("pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n");
    // Turned about x by steps: 25 N at (1, 2, 60) mm, zero (0.5, −0.3, 1).
    for i in 0..12_u32 {
        let half = 0.15 * f64::from(i);
        let (sin, cos) = half.sin_cos();
        let (weight, at) = (25.0, [1.0, 2.0, 60.0]);
        // Down in the sensor: Rx(−2·half) of −z.
        let down = [0.0, -(2.0 * half).sin(), -(2.0 * half).cos()];
        let f = down.map(|d| weight * d);
        let m =
            [at[1] * f[2] - at[2] * f[1], at[2] * f[0] - at[0] * f[2], at[0] * f[1] - at[1] * f[0]];
        let e = |k: usize| 20.0 * noise_mm(6 * i as usize + k);
        let _ = writeln!(
            table,
            "P{i},{cos:.9},{sin:.9},0,0,{:.5},{:.5},{:.5},{:.4},{:.4},{:.4}",
            f[0] + 0.5 + e(0),
            f[1] - 0.3 + e(1),
            f[2] + 1.0 + e(2),
            m[0] + 40.0 * e(3),
            m[1] + 40.0 * e(4),
            m[2] + 40.0 * e(5)
        );
    }
    let toml = "kind = \"ft-center\"\n[noise]\nforce_n = 0.02\nmoment_nmm = 0.8\n";
    let case = Case::new(&[("case.toml", toml), ("gravity.csv", &table)]);
    let answer = json(&case, &["--for", "all", "--budget", "4"]);
    assert_eq!((answer["planned"].as_u64(), &answer["noun"]), (Some(4), &Value::from("pose")));
    for figure in answer["figures"].as_array().unwrap() {
        let of = |key: &str| figure[key].as_f64().unwrap();
        assert!(of("after") <= of("before") * (1.0 + 1e-9), "{figure}");
    }
    // Turned about x alone, what goes with x is known least.
    let sideways = answer["plan"].as_array().unwrap().iter().any(|one| {
        let q = |name: &str| one["cells"][name].as_f64().unwrap();
        q("qy").abs() > 1e-3 || q("qz").abs() > 1e-3
    });
    assert!(sideways, "{}", answer["plan"]);
}

/// A plan for a committed case, which is not written to.
fn of_committed(case: &str, aim: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(case);
    let ended = truing(&["plan", folder.to_str().unwrap(), "--for", aim, "--json"]);
    assert_eq!(ended.code, 0, "{case}: {}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn of_two_loads_a_third_between_them_is_on_offer() {
    let answer = of_committed("ft-center/moment-bias-two-loads", "rivals");
    assert_eq!(answer["reached"], true, "{}", answer["would"]);
    let loads: Vec<f64> = (answer["plan"].as_array().unwrap().iter())
        .map(|one| one["cells"]["load_n"].as_f64().unwrap())
        .collect();
    // It was pressed with 20 and 60 N.
    assert!(loads.iter().any(|load| (30.0..50.0).contains(load)), "{loads:?}");
}

#[test]
fn what_no_measurement_answers_is_not_asked_of_anybody() {
    for (case, aim, said) in [
        // Both add to the force of the axial unit.
        ("force-impedance/axial-zero", "rivals", "by `leans_deg`, `loads_n`, `axial_mm_per_s`"),
        ("ft-center/force-gain", "rivals", "measure the machine's travel"),
        (
            "ft-center/bias-drift",
            "unobservable",
            "datum-offset does what frame translation x and frame translation y do, and is in these",
        ),
        ("probe-comp/bending", "unobservable", "`measured_feed_mm_per_min`"),
    ] {
        let answer = of_committed(case, aim);
        assert_eq!((&answer["planned"], &answer["reached"]), (&0.into(), &false.into()), "{case}");
        let would = answer["would"].as_str().unwrap();
        assert!(would.contains(said), "{case}: {would}");
        assert!(!would.contains("every test of the plan is met"), "{case}: {would}");
    }
}

#[test]
fn rivals_that_a_first_plan_never_told_are_told_by_more() {
    let answer = of_committed("tracker-lm/station-drift", "rivals");
    assert_eq!(answer["reached"], true, "{}", answer["would"]);
    assert!(answer["planned"].as_u64().unwrap() > 2, "{answer}");
}
