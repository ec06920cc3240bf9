//! Angles, stations and reflectors of a tracer or tracker.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

use super::json;
use crate::command::Case;

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

/// A stand that gives way, and its readings that drift by themselves: what tells them apart is time, so the
/// plan goes on for as long as it takes, and takes the stand to go on as it did.
#[test]
fn a_stand_that_gives_way_is_watched_for_longer() {
    const STEPS: usize = 11;
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/tracker-lm/station-drift");
    let text = |name: &str| fs::read_to_string(Path::new(folder).join(name)).unwrap();
    let case = Case::new(&[
        ("case.toml", &format!("{}\n[plan]\ncycles = 3\n", text("case.toml"))),
        ("stations.csv", &text("stations.csv")),
        ("mounts.csv", &text("mounts.csv")),
    ]);
    let is_early = |line: &&str| {
        line.split(',')
            .nth(2)
            .and_then(|step| step.parse::<usize>().ok())
            .is_none_or(|s| s <= STEPS)
    };
    let ranges = text("ranges.csv");
    let early: Vec<&str> = ranges.lines().filter(is_early).collect();
    case.write("ranges.csv", early.join("\n") + "\n");
    let answer = json(&case, &["--budget", "100"]);
    assert_eq!(answer["reached"], Value::Bool(true), "{}", answer["would"]);
    let figures = answer["figures"].as_array().unwrap();
    assert_eq!(figures.len(), 2);
    for figure in figures {
        assert!(figure["before"].as_f64().unwrap() < 0.1, "{figure}");
        assert!(figure["after"].as_f64().unwrap() > 0.99, "{figure}");
    }
    // Angles are turned to again.
    assert!(answer["planned"].as_u64().unwrap() > 2 * STEPS as u64, "{}", answer["planned"]);
}
