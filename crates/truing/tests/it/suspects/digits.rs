//! Numbers with too few digits, or with two of them exchanged.

use super::numbers::axis;
use super::{change, first, fixture};
use crate::command::Case;

const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
const RANGES: &str = "ranges.csv";

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

/// Effect, subject and description of the first mistake.
fn named(case: &Case) -> [String; 3] {
    let (step, _) = first(case);
    ["effect", "subject", "description"].map(|key| step[key].as_str().unwrap().to_owned())
}

#[test]
fn coordinates_rounded_to_a_tenth_are_no_noise() {
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    change(&case, "points.csv", &XYZ, |n, old| {
        old[n].iter().map(|cell| format!("{:.1}", number(cell))).collect()
    });
    let [effect, subject, said] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:rounded", "points.csv: x_mm, y_mm, z_mm"));
    assert!(said.contains("one decimal"), "{said}");
}

#[test]
fn displacements_of_which_the_digits_were_cut_off_are_told_from_rounded_ones() {
    let files = ["case.toml", "stations.csv", "mounts.csv", RANGES];
    let case = fixture("tracker-lm/nothing", &files);
    change(&case, RANGES, &["displacement_mm"], |n, old| {
        vec![format!("{:.2}", (number(&old[n][0]) * 100.0).trunc() / 100.0)]
    });
    let [effect, subject, said] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:rounded", "ranges.csv: displacement_mm"));
    assert!(said.contains("2 decimals"), "{said}");
}

#[test]
fn one_cycle_read_from_a_coarser_display_is_named_with_its_lines() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm", "actual_mm", "cycle"], |n, old| {
        // Targets that are no whole tenths: then a display of tenths misses them all.
        let by = 0.037 * (number(&old[n][0]) / 47.0).round();
        let actual = number(&old[n][1]) + by;
        let actual =
            if &*old[n][2] == "2" { format!("{actual:.1}") } else { format!("{actual:.7}") };
        vec![format!("{:.3}", number(&old[n][0]) + by), actual, old[n][2].clone()]
    });
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:rounded");
    assert!(said.contains("42–61"), "{said}");
}

/// Places that were planned to a tenth, and touches that miss them by as much as a tenth rounded: nothing was rounded.
#[test]
fn places_that_were_planned_are_not_accused_of_noise_as_large_as_their_steps() {
    let row = |i: u32| {
        let at = |k: u32| f64::from(i * k % 10) * 7.5;
        let noise = |k: u32| 0.05 * ((1e5 * f64::from(i + 17 * k)).sin() * 43.0).fract();
        let [x, y, z] = [at(1), at(3), at(7)];
        let [u, v, w] = [x + 30.0 + noise(1), y - 20.0 + noise(2), z + 5.0 + noise(3)];
        format!("P{i},{x:.1},{y:.1},{z:.1},{u:.5},{v:.5},{w:.5}\n")
    };
    let table: String = (0..40).map(row).collect();
    let header = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n";
    let case =
        Case::new(&[("case.toml", super::SURVEY), ("pairs.csv", &(header.to_owned() + &table))]);
    let answer = case.json("loop");
    assert_ne!(answer["verdict"], "input-wrong", "{}", answer["steps"]);
}

#[test]
fn thousands_read_as_decimals_are_multiplied_back() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm", "actual_mm"], |n, old| {
        let [target, actual] = [0, 1].map(|i| number(&old[n][i]) * 4.0);
        let cut = if actual >= 1000.0 { actual / 1000.0 } else { actual };
        vec![format!("{target}"), format!("{cut:.7}")]
    });
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:decimal-point");
    assert!(said.contains("separator of thousands"), "{said}");
}

#[test]
fn two_digits_of_a_radius_that_were_exchanged_are_put_back() {
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text.replacen("radius_mm = 120.0", "radius_mm = 210.0", 1));
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:digits");
    assert!(said.contains("120 instead of 210"), "{said}");
}

#[test]
fn a_part_that_was_clamped_a_quarter_turn_round_is_named() {
    let case = fixture("pose-icp/measured-mirror-1", &["case.toml", "points.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text.replacen("gamma_deg = 0.0", "gamma_deg = 90.0", 1));
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:rotation");
    assert!(said.contains("0 instead of 90"), "{said}");
}

#[test]
fn another_conic_constant_than_drawn_is_named_with_the_one_that_fits() {
    let case = fixture("probe-comp/nothing-white", &["case.toml", "touches.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text.replacen("conic = -1.0", "conic = 0.0", 1));
    let [effect, subject, said] = named(&case);
    assert_eq!((&*effect, &*subject), ("input:setting", "case.toml: [surface] conic"));
    let to = said.split("uncertainty): ").nth(1).unwrap().split(' ').next().unwrap();
    // Its uncertainty is told: some thousandths.
    assert!((number(to) + 1.0).abs() < 0.02, "{said}");
}

#[test]
fn two_radii_of_a_head_that_were_exchanged_are_put_back() {
    let case = fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let text = text.replacen("head_radius_mm", "HEAD", 1).replacen(
        "bracket_radius_mm",
        "head_radius_mm",
        1,
    );
    case.write("case.toml", text.replacen("HEAD", "bracket_radius_mm", 1));
    let [effect, _, said] = named(&case);
    assert_eq!(effect, "input:exchanged");
    assert!(said.contains("head_radius_mm") && said.contains("bracket_radius_mm"), "{said}");
}

#[test]
fn the_top_of_a_ball_given_for_its_centre_is_named() {
    let case = fixture("probe-comp/axis-scale", &["case.toml", "touches.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let top = text.replacen("center_mm = [0.0, 0.0, 0.0]", "center_mm = [0.0, 0.0, 25.0]", 1);
    assert_ne!(top, text);
    case.write("case.toml", top);
    let said = case.run("loop");
    let said = format!("{}{}", said.stdout, said.stderr);
    assert!(said.contains("a pole (the top)"), "{said}");
}
