//! Mistakes that any table of readings may have.

use super::numbers::axis;
use super::{change, fixture, survey};
use crate::command::Case;

const PLACE: [&str; 3] = ["x_mm", "y_mm", "z_mm"];

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

/// What `truing loop` says of a case, and what it refuses to.
fn said(case: &Case) -> String {
    let ended = case.run("loop");
    ended.stdout + &ended.stderr
}

fn assert_says(case: &Case, words: &[&str]) {
    let said = said(case);
    assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
}

#[test]
fn a_column_sorted_by_row_numbers_as_text_is_put_back() {
    for (name, file, files) in [
        ("probe-comp/nothing-white", "touches.csv", &["case.toml", "touches.csv"][..]),
        ("pose-icp/nothing-white", "points.csv", &["case.toml", "points.csv", "edge.csv"][..]),
    ] {
        let case = fixture(name, files);
        change(&case, file, &["z_mm"], |n, old| {
            let mut rows: Vec<usize> = (0..old.len()).collect();
            rows.sort_by_key(|row| (row + 1).to_string());
            old[rows[n]].clone()
        });
        assert_says(&case, &["sorted as text (1, 10, 11, …)", "`z_mm`"]);
    }
}

#[test]
fn zeros_in_one_column_are_no_limit_of_the_range() {
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    change(&case, "points.csv", &["y_mm"], |n, old| {
        if n % 9 == 4 { vec!["0".to_owned()] } else { old[n].clone() }
    });
    assert_says(&case, &["read 0 in all of `y_mm`", "what was missing was written as zeros"]);
}

#[test]
fn a_number_of_a_path_with_its_point_elsewhere_is_put_back() {
    let case = fixture("force-impedance/path-nothing", &["case.toml", "path.csv"]);
    change(&case, "path.csv", &["force_n"], |n, old| {
        let factor = if n == 30 { 100.0 } else { 1.0 };
        vec![format!("{:.3}", factor * number(&old[n][0]))]
    });
    assert_says(&case, &["has its decimal point in another place", "line 32"]);
}

#[test]
fn columns_three_rows_further_down_are_shifted_back() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm"], |n, old| old[(n + 97) % 100].clone());
    assert_says(&case, &["input-wrong", "shifted 3 rows"]);
    let files = ["case.toml", "stations.csv", "mounts.csv", "targets.csv"];
    let case = fixture("tracker-lm/targets-nothing", &files);
    change(&case, "targets.csv", &PLACE[2..], |n, old| {
        old[(n + old.len() - 2) % old.len()].clone()
    });
    assert_says(&case, &["`z_mm` of targets.csv are shifted 2 rows down"]);
}

#[test]
fn angles_of_some_steps_in_gon_are_no_error_of_the_axis() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "targets.csv"];
    let case = fixture("tracker-lm/targets-nothing", &files);
    change(&case, "targets.csv", &["angle_deg"], |n, old| {
        let is_late = number(&old[n][0]) > 40.0;
        vec![format!("{}", number(&old[n][0]) / if is_late { 0.9 } else { 1.0 })]
    });
    assert_says(&case, &["input-wrong", "`angle_deg` of targets.csv", "gon"]);
}

/// A hole that is measured under the name of another stands beside the others of that name as a bad point would.
#[test]
fn a_reading_under_another_label_is_given_its_own() {
    let case = survey();
    // The hole of row 20 was measured once more in place of that of row 5.
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], |n, old| {
        let again = |cell: &String| format!("{:.5}", number(cell) + 0.004);
        if n == 5 { old[20].iter().map(again).collect() } else { old[n].clone() }
    });
    assert_says(&case, &["input-wrong", "read at the place", "stands under another label"]);
}

/// Targets of another programme are places of their own, at which any deviation would be a profile.
#[test]
fn targets_beside_those_that_were_read_are_no_profile() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm"], |n, old| {
        let by = if (25..60).contains(&n) { 10.0 } else { 0.0 };
        vec![format!("{}", number(&old[n][0]) + by)]
    });
    assert_says(&case, &["input-wrong", "35 readings of positions.csv are not at the targets"]);
}

/// Without declared noise, coma is as free to fit as the place that the side touches give.
#[test]
fn side_touches_are_not_blamed_where_no_noise_is_declared() {
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    let settings = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let is_of_noise = |line: &&str| !line.contains("point_mm") && !line.contains("[noise]");
    let plain: Vec<&str> = settings.lines().filter(is_of_noise).collect();
    case.write("case.toml", plain.join("\n") + "\n");
    change(&case, "edge.csv", &["x_mm", "y_mm"], |n, old| {
        let read = |k: usize| number(&old[n][k]) + [1.3, -0.6][k];
        [0, 1].map(|k| read(k).to_string()).to_vec()
    });
    let said = said(&case);
    assert!(!said.contains("input-wrong"), "{said}");
}

/// A column that the misfit does not go with makes it a small share of what was measured where it is made large.
#[test]
fn a_column_along_a_plane_is_not_blamed_for_another_ball() {
    let row = |i: u32| {
        let turns = f64::from(i);
        let (x, y) = (40.0 * (1.7 * turns).sin(), 30.0 * (2.3 * turns).cos());
        let noise = 0.002 * ((1e5 * (turns + 1.0)).sin() * 43.0).fract();
        // On a ramp along x, under a ball of 4 mm.
        let (sine, cosine) = (0.469_471_56, 0.882_947_59);
        let off = 4.0 + noise;
        format!(
            "T{i:02},{:.5},{y:.5},{:.5},{:.6},0,{:.6}\n",
            x * cosine + off * sine,
            off * cosine - x * sine,
            -sine,
            -cosine
        )
    };
    let table: String = (0..40).map(row).collect();
    let settings = "kind = \"probe-comp\"\n[surface]\nshape = \"plane\"\npoint_mm = [0.0, 0.0, 0.0]\n\
        normal = [0.46947156, 0.0, 0.88294759]\n[probe]\ntip_radius_mm = 4.5\n[model]\n\
        normal = \"approach\"\n[noise]\npoint_mm = 0.0015\n";
    let table = format!("touch,x_mm,y_mm,z_mm,nx,ny,nz\n{table}");
    let case = Case::new(&[("case.toml", settings), ("touches.csv", &table)]);
    let said = said(&case);
    assert!(!said.contains("metres instead of mm"), "{said}");
    assert!(said.contains("tip_radius_mm") || said.contains("tip-radius"), "{said}");
}

/// Signs that were lost here and there in the course of a scan keep a search from its end.
#[test]
fn signs_lost_in_the_course_of_a_scan_are_put_back() {
    let case = survey();
    change(&case, "pairs.csv", &["from_x_mm"], |n, old| {
        let along = |n: usize| 60.0 + 3.0 * f64::from(u32::try_from(n).unwrap());
        let sign = if [4, 8, 12, 16].contains(&n) { -1.0 } else { 1.0 };
        let _ = &old[n];
        vec![format!("{:.4}", sign * along(n))]
    });
    let shift = |n: usize| 60.0 + 3.0 * f64::from(u32::try_from(n).unwrap());
    change(&case, "pairs.csv", &["from_y_mm"], |n, _| {
        vec![format!("{:.4}", 40.0 * (1.9 * shift(n)).sin())]
    });
    change(&case, "pairs.csv", &["from_z_mm"], |n, _| {
        vec![format!("{:.4}", 25.0 * (0.7 * shift(n)).cos())]
    });
    let noise = |n: usize, k: f64| 0.0087 * ((1e5 * (shift(n) + k)).sin() * 43.0).fract();
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], |n, _| {
        let place = [shift(n), 40.0 * (1.9 * shift(n)).sin(), 25.0 * (0.7 * shift(n)).cos()];
        let to = [100.0 - place[1], 50.0 + place[0], 20.0 + place[2]];
        let read = |k: usize| to[k] + noise(n, [1.0, 2.0, 3.0][k]);
        (0..3).map(|k| format!("{:.5}", read(k))).collect()
    });
    assert_says(
        &case,
        &["input-wrong", "`from_x_mm` of pairs.csv is of the opposite sign in lines 6, 10, 14, 18"],
    );
}
