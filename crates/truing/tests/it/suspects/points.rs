//! Mistakes in tables of points and poses.

use std::fmt::Write as _;

use serde_json::Value;

use super::{SURVEY, change, first, fixture, scale, survey, swap};
use crate::command::Case;

#[test]
fn a_column_in_inches_is_named_and_the_loop_goes_on_without_it() {
    let case = survey();
    let sound = case.json("loop");
    scale(&case, "pairs.csv", &["to_x_mm"], 1.0 / 25.4);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "pairs.csv: to_x_mm");
    assert!(step["description"].as_str().unwrap().contains("inches"), "{step}");
    let rms = |of: &Value| of["train_rms"].as_f64().unwrap();
    assert!(rms(&answer["before"]) > 1e3 * rms(&answer["after"]));
    // Nine digits of an inch: a nanometre.
    assert!((rms(&answer["after"]) - rms(&sound["after"])).abs() < 1e-6);
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("as corrected"), "{warnings}");
}

#[test]
fn check_lists_it_and_solve_warns() {
    let case = survey();
    scale(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], 1e-3);
    let suspects = case.json("check")["suspects"].clone();
    assert_eq!(suspects[0]["effect"], "input:unit");
    assert!(suspects[0]["description"].as_str().unwrap().contains("metres"), "{suspects}");
    let warning = case.json("solve")["warnings"][0].clone();
    assert!(warning.as_str().unwrap().starts_with("the input looks wrong"), "{warning}");
}

#[test]
fn exchanged_and_mirrored_axes_that_fit_alike_are_all_listed() {
    let case = survey();
    swap(&case, "pairs.csv", ["to_x_mm", "to_y_mm"]);
    let (step, _) = first(&case);
    let said = format!("{} {}", step["description"], step["indistinguishable_from"]);
    assert!(said.contains("exchanged") && said.contains("opposite sign"), "{said}");
}

/// Heights of a low part: a shear and scales of the axes explain them as well.
#[test]
fn columns_exchanged_between_the_tables_are_no_shear() {
    let case = survey();
    swap(&case, "pairs.csv", ["from_z_mm", "to_z_mm"]);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    assert_eq!(step["subject"], "pairs.csv: from_z_mm, to_z_mm");
}

/// Points along a line, of which noise alone says how they are turned about it: heights that differ by a
/// constant leave other noise once exchanged, and nothing else.
#[test]
fn an_exchange_that_changes_noise_alone_is_no_mistake() {
    let noise = |i: u32| 4e-3 * (12.9 * (f64::from(i).powi(2) + 10.0)).sin();
    let (sin, cos) = 0.05_f64.sin_cos();
    let mut table = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n".to_owned();
    for point in 0..15 {
        let [x, y, z] = [57.4, 39.2, 7.0].map(|step| step * (f64::from(point) - 7.0));
        let there = [cos * x - sin * y + 250.0, sin * x + cos * y - 40.0, z - 5.0];
        let _ = write!(table, "N{point}");
        for (value, n) in [x, y, z].into_iter().chain(there).zip(6 * point..) {
            let _ = write!(table, ",{:.4}", value + noise(n));
        }
        table.push('\n');
    }
    let toml = "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.004\n";
    let case = Case::new(&[("case.toml", toml), ("pairs.csv", &table)]);
    let message = case.message("loop", 3);
    assert!(message.contains("about the centroid unknown"), "{message}");
    assert!(!message.contains("looks wrong"), "{message}");
}

#[test]
fn shifted_rows_and_exchanged_points_are_told_apart() {
    let to = ["to_x_mm", "to_y_mm", "to_z_mm"];
    let case = survey();
    change(&case, "pairs.csv", &to, |n, old| old[(n + old.len() - 1) % old.len()].clone());
    assert_eq!(first(&case).0["effect"], "input:row-shift");
    let case = survey();
    change(&case, "pairs.csv", &to, |n, old| {
        old[[5, 1, 2, 3, 4, 0].get(n).copied().unwrap_or(n)].clone()
    });
    assert_eq!(first(&case).0["effect"], "input:labels");
}

#[test]
fn sound_cases_and_physics_are_not_accused() {
    for name in ["nothing-white", "nothing-coloured", "bad-point", "shear", "scale", "sag"] {
        let case = fixture(&format!("frame-fit/{name}"), &["case.toml", "pairs.csv"]);
        assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()), "{name}");
        assert_ne!(case.json("loop")["verdict"], "input-wrong", "{name}");
    }
}

/// The user asks for a general map, and what it leaves is the noise: not only one of tables that have nothing
/// to do with each other.
#[test]
fn points_that_a_map_of_another_scale_takes_onto_each_other_belong_together() {
    let case = survey();
    case.write("case.toml", SURVEY.replace("rigid", "affine"));
    scale(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], 1.005);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    assert_eq!(case.json("loop")["verdict"], "nothing-missing");
    scale(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], 1.0 / 25.4);
    assert_eq!(first(&case).0["effect"], "input:unit");
    // In another order, every other row, they do not.
    let case = survey();
    case.write("case.toml", SURVEY.replace("rigid", "affine"));
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], |n, old| {
        old[(7 * n + 3) % old.len()].clone()
    });
    assert_eq!(first(&case).0["effect"], "input:unmatched");
}

/// A survey's noise in µm is the same mistake; one that is only ten times too large is none.
#[test]
fn noise_in_another_unit_is_told_from_careful_noise() {
    let case = survey();
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let declared = |value: &str| {
        let line = |line: &str| match line.strip_prefix("point_mm = ") {
            Some(_) => format!("point_mm = {value}\n"),
            None => format!("{line}\n"),
        };
        case.write("case.toml", text.lines().map(line).collect::<String>());
    };
    declared("5.0");
    assert_eq!(first(&case).0["subject"], "case.toml: [noise] point_mm");
    declared("0.05");
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
}

/// Two bad readings explain it as well, but need a number each.
#[test]
fn heights_of_two_points_are_each_others_and_not_two_bad_ones() {
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    change(&case, "points.csv", &["z_mm"], |n, old| {
        old[[9, 1, 2, 3, 4, 5, 6, 7, 8, 0].get(n).copied().unwrap_or(n)].clone()
    });
    assert_eq!(first(&case).0["effect"], "input:labels");
}

/// Readings of a tracker that goes round all reflectors at every stop, one row further down.
#[test]
fn a_whole_table_one_row_down_is_named() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "targets.csv"];
    let case = fixture("tracker-lm/targets-nothing", &files);
    let place = ["x_mm", "y_mm", "z_mm"];
    change(&case, "targets.csv", &place, |n, old| old[(n + old.len() - 1) % old.len()].clone());
    assert_eq!(first(&case).0["effect"], "input:row-shift");
}

/// A tracker that has lost its reflector goes on sending the last place.
#[test]
fn places_that_stand_still_are_named_though_nothing_can_be_fitted() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "targets.csv"];
    let case = fixture("tracker-lm/targets-nothing", &files);
    change(&case, "targets.csv", &["x_mm", "y_mm", "z_mm"], |n, old| {
        old[n.min(old.len() * 4 / 5)].clone()
    });
    let said = case.run("loop");
    let text = said.stdout + &said.stderr;
    assert!(text.contains("`x_mm`, `y_mm`, `z_mm` of targets.csv are stuck"), "{text}");
}

/// One column pasted over another is a map that loses a direction, which shear and scale would explain.
#[test]
fn a_column_that_is_a_copy_of_another_is_named() {
    let case = survey();
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm"], |n, old| {
        vec![old[n][0].clone(), old[n][0].clone()]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:copied");
    assert_eq!(step["subject"], "pairs.csv: to_x_mm, to_y_mm");
    // Where touches cannot be fitted, too.
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    change(&case, "points.csv", &["x_mm", "y_mm"], |n, old| {
        vec![old[n][0].clone(), old[n][0].clone()]
    });
    let said = case.run("loop");
    let said = format!("{}{}", said.stdout, said.stderr);
    assert!(said.contains("`x_mm`, `y_mm` of points.csv read the same"), "{said}");
}

#[test]
fn a_number_without_its_decimal_point_is_named_with_what_it_should_be() {
    let at = |n: usize, row: usize| if n == row { 10.0 } else { 1.0 };
    for (name, files, file, column) in [
        ("frame-fit/nothing-white", &["case.toml", "pairs.csv"][..], "pairs.csv", "from_x_mm"),
        ("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"], "points.csv", "z_mm"),
        ("probe-comp/nothing-white", &["case.toml", "touches.csv"], "touches.csv", "z_mm"),
    ] {
        let case = fixture(name, files);
        change(&case, file, &[column], |n, old| {
            vec![format!("{}", old[n][0].parse::<f64>().unwrap() * at(n, 4))]
        });
        let said = case.run("loop");
        let said = format!("{}{}", said.stdout, said.stderr);
        assert!(said.contains("has its decimal point in another place"), "{name}: {said}");
        assert!(said.contains(&format!("`{column}` in line 6 of {file}")), "{name}: {said}");
    }
}

/// Of rows that were sorted, a drift along their order takes most and leaves a third of all.
#[test]
fn a_table_that_was_sorted_does_not_belong_to_the_other() {
    let case = survey();
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], |n, old| {
        let mut sorted = old.to_vec();
        let x = |row: &Vec<String>| row[0].parse::<f64>().unwrap();
        sorted.sort_by(|a, b| x(a).total_cmp(&x(b)));
        sorted.swap_remove(n)
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unmatched");
}

/// Touches of a sphere of 25 mm, of which a fifth lie below zero.
#[test]
fn minus_signs_of_a_column_that_has_none_are_put_back() {
    let center = [12.0, -8.0, 5.0];
    let row = |i: i32| {
        let n = f64::from(i);
        let (z, turn): (f64, f64) = (1.0 - 1.5 * f64::from(i * 17 % 60) / 60.0, 2.4 * n);
        let across = (1.0 - z * z).sqrt();
        let noise = 1e-3 * (1e5 * (12.9898 * n).sin()).fract();
        let normal = [across * turn.cos(), across * turn.sin(), z];
        let at = [0, 1, 2].map(|k| center[k] + (26.0 + noise) * normal[k]);
        let [nx, ny, nz] = normal.map(|component| -component);
        let [x, y, z] = [at[0], at[1], at[2].abs()];
        format!("T{i},{x:.5},{y:.5},{z:.5},{nx:.7},{ny:.7},{nz:.7}\n")
    };
    let table: String = (0..60).map(row).collect();
    let settings = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
                    center_mm = [12.0, -8.0, 5.0]\nside = \"outside\"\n[probe]\ntip_radius_mm = 1.0\n\
                    [noise]\npoint_mm = 0.0006\n";
    let table = format!("touch,x_mm,y_mm,z_mm,nx,ny,nz\n{table}");
    let (step, answer) = first(&Case::new(&[("case.toml", settings), ("touches.csv", &table)]));
    assert_eq!(
        (&step["effect"], &step["subject"]),
        (&"input:sign".into(), &"touches.csv: z_mm".into())
    );
    assert!(step["description"].as_str().unwrap().contains("lost its minus"), "{step}");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// The operator changed the display after thirteen points.
#[test]
fn a_unit_that_changes_in_the_middle_is_named_with_its_lines() {
    let case = survey();
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], |n, old| {
        let inches = |cell: &String| format!("{}", cell.parse::<f64>().unwrap() / 25.4);
        if n < 13 { old[n].clone() } else { old[n].iter().map(inches).collect() }
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("inches instead of mm, from line 15 "), "{said}");
}

/// Declared uncertainties in metres from a row on leave the readings as they are, and χ² a million times too large there.
#[test]
fn uncertainties_of_some_rows_in_metres_are_named() {
    let case = survey();
    let text = std::fs::read_to_string(case.file("pairs.csv")).unwrap();
    let declared = |is_wrong: &dyn Fn(usize) -> bool| {
        let rows = text.lines().filter(|line| !line.starts_with('#')).enumerate();
        let with = rows.map(|(n, line)| match n {
            0 => format!("{line},sigma_mm\n"),
            _ if is_wrong(n) => format!("{line},0.0000080\n"),
            _ => format!("{line},0.0080\n"),
        });
        with.collect::<String>()
    };
    case.write("pairs.csv", declared(&|_| false));
    let sigma_mm = case.json("solve")["residual"]["chi2_per_dof"].as_f64().unwrap().sqrt() * 0.008;
    let in_metres = declared(&|n| n > 12).replace("0.0000080", &format!("{:.8}", 1e-3 * sigma_mm));
    case.write("pairs.csv", in_metres.replace("0.0080", &format!("{sigma_mm:.5}")));
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "pairs.csv: sigma_mm");
    assert!(step["description"].as_str().unwrap().contains("multiply these by 1000"), "{step}");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}
