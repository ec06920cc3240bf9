//! Mistakes in tables of points, poses and touches.

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

/// A touch that lies far off is refused, and the refusal looks for the one that it was mistaken for.
#[test]
fn a_touch_with_the_height_of_another_is_refused_with_both_lines() {
    let case = fixture("probe-comp/lobing", &["case.toml", "touches.csv"]);
    let text = std::fs::read_to_string(case.file("touches.csv")).unwrap();
    let heights: Vec<f64> = text
        .lines()
        .filter(|line| line.starts_with('T'))
        .map(|line| line.split(',').nth(3).unwrap().parse().unwrap())
        .collect();
    let at = |best: fn(f64, f64) -> bool| {
        (0..heights.len()).reduce(|a, b| if best(heights[b], heights[a]) { b } else { a }).unwrap()
    };
    let (low, high) = (at(|b, a| b < a), at(|b, a| b > a));
    change(&case, "touches.csv", &["z_mm"], |n, old| {
        let from = if n == low {
            high
        } else if n == high {
            low
        } else {
            n
        };
        old[from].clone()
    });
    let message = case.message("loop", 2);
    let lines = format!("in lines {} and {}", low.min(high) + 2, low.max(high) + 2);
    assert!(message.contains("are exchanged") && message.contains(&lines), "{message}");
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

#[test]
fn touches_of_another_part_are_named_by_their_label() {
    let case = fixture("probe-comp/nothing-white", &["case.toml", "touches.csv"]);
    let part = |row: usize| ["A", "B", "C"][row / 3 % 3];
    let text = std::fs::read_to_string(case.file("touches.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = format!("{},part\n", lines.next().unwrap());
    let rows = lines.enumerate().map(|(row, line)| format!("{line},{}\n", part(row)));
    case.write("touches.csv", header + &rows.collect::<String>());
    change(&case, "touches.csv", &["z_mm"], |n, old| {
        let z_mm = old[n][0].parse::<f64>().unwrap();
        vec![format!("{}", if part(n) == "B" { 1.2 * z_mm - 0.5 } else { z_mm })]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:misplaced");
    assert_eq!(step["subject"], "touches.csv: part B");
}

/// The axis by the side touches 1.4 mm from that of the surface: coma beside nothing else explains as much,
/// and cannot be told from it; 7 mm from it, touches lie beside the part.
#[test]
fn side_touches_of_another_session_are_named_or_stand_beside_coma() {
    let moved = |by_mm: [f64; 2]| {
        let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
        change(&case, "edge.csv", &["x_mm", "y_mm"], |n, old| {
            let read = |k: usize| old[n][k].parse::<f64>().unwrap() + by_mm[k];
            [0, 1].map(|k| read(k).to_string()).to_vec()
        });
        case
    };
    let step = &moved([1.3, -0.6]).json("loop")["steps"][0];
    assert_eq!(step["effect"], "coma", "{step}");
    let rivals = step["indistinguishable_from"].as_array().unwrap();
    assert!(
        rivals.iter().any(|rival| rival == "input:misplaced [edge.csv: x_mm, y_mm, z_mm]"),
        "{step}"
    );
    assert!(step["separate_by"].as_str().unwrap().contains("touch the side again"), "{step}");
    let message = moved([6.3, -3.2]).message("loop", 2);
    assert!(message.contains("side touches of edge.csv do not fit the surface"), "{message}");
}

/// Touches of a part of revolution along its normals, said to have come from there.
fn along_the_normals() -> Case {
    let case = fixture("probe-comp/nothing-white", &["case.toml", "touches.csv"]);
    let text = std::fs::read_to_string(case.file("touches.csv")).unwrap();
    let mut table = String::new();
    for (n, line) in text.lines().filter(|line| !line.starts_with('#')).enumerate() {
        let number = |column: usize| line.split(',').nth(column).unwrap().parse::<f64>().unwrap();
        if n == 0 {
            table += &format!("{line},nx,ny,nz\n");
            continue;
        }
        // A paraboloid of 120 mm, seen from the centre of a ball of 3 mm.
        let [x, y] = [1, 2].map(|column| number(column) / 123.0);
        let length = (x * x + y * y + 1.0).sqrt();
        table += &format!("{line},{:.6},{:.6},{:.6}\n", x / length, y / length, -1.0 / length);
    }
    case.write("touches.csv", table);
    case
}

/// The part looks the same, and what is handed back lies elsewhere.
#[test]
fn coordinates_that_came_from_beside_the_normals_are_told_though_they_fit() {
    let sound = along_the_normals();
    assert_eq!(sound.json("loop")["verdict"], "nothing-missing");
    let case = along_the_normals();
    swap(&case, "touches.csv", ["x_mm", "y_mm"]);
    let (step, _) = first(&case);
    assert_eq!(
        (&step["effect"], &step["subject"]),
        (&"input:exchanged".into(), &"touches.csv: x_mm, y_mm".into())
    );
    assert!(step["description"].as_str().unwrap().contains("beside the normals"), "{step}");
    let case = along_the_normals();
    scale(&case, "touches.csv", &["y_mm"], -1.0);
    let (step, _) = first(&case);
    assert_eq!(
        (&step["effect"], &step["subject"]),
        (&"input:sign".into(), &"touches.csv: y_mm".into())
    );
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

/// As exchanged terms of the surface fit as well, but not the normals.
#[test]
fn exchanged_columns_are_told_from_exchanged_terms_by_the_normals() {
    let settings = "kind = \"probe-comp\"\n[surface]\nshape = \"polynomial\"\nunit_mm = 60.0\n\
        terms = [[0, 1, 4.0], [2, 0, 9.0], [0, 2, 13.0], [2, 1, -4.0]]\n[probe]\ntip_radius_mm = 2.0\n\
        [noise]\npoint_mm = 0.001\n";
    let row = |i: u32| {
        let [x, y] = [f64::from(i % 7) * 15.0 - 44.0, f64::from(i / 7) * 13.0 - 40.0];
        let [u, v] = [x / 60.0, y / 60.0];
        let z = 4.0 * v + 9.0 * u * u + 13.0 * v * v - 4.0 * u * u * v;
        let slope_x = (18.0 * u - 8.0 * u * v) / 60.0;
        let slope_y = (4.0 + 26.0 * v - 4.0 * u * u) / 60.0;
        let length = (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt();
        let n = [-slope_x / length, -slope_y / length, 1.0 / length];
        let noise = 0.001 * (1e5 * (f64::from(i) + 0.3).sin()).fract();
        let [a, b, c] =
            [x, y, z].iter().zip(n).map(|(p, n)| p + (2.0 + noise) * n).collect::<Vec<_>>()[..]
        else {
            unreachable!()
        };
        format!("T{i},{b:.6},{a:.6},{c:.6},{:.6},{:.6},{:.6}\n", -n[0], -n[1], -n[2])
    };
    let table: String = (0..49).map(row).collect();
    let table = format!("touch,x_mm,y_mm,z_mm,nx,ny,nz\n{table}");
    let (step, answer) = first(&Case::new(&[("case.toml", settings), ("touches.csv", &table)]));
    assert_eq!(
        (&step["effect"], &step["subject"]),
        (&"input:exchanged".into(), &"touches.csv: x_mm, y_mm".into())
    );
    let steps = answer["steps"].as_array().unwrap();
    let is_input = |step: &&Value| step["effect"].as_str().unwrap().starts_with("input:");
    assert_eq!(steps.iter().filter(is_input).count(), 1, "{}", answer["steps"]);
}

#[test]
fn an_eccentricity_for_a_conic_constant_is_named() {
    let case = fixture("pose-icp/near-sphere", &["case.toml", "points.csv", "edge.csv"]);
    let settings = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", settings.replace("conic = -0.02", "conic = 0.141421356"));
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:eccentricity");
    assert!(step["description"].as_str().unwrap().contains("-0.0199999"), "{step}");
}

/// It lies so far off that nothing can be fitted.
#[test]
fn one_touch_far_off_is_named_with_its_line() {
    let case = fixture("probe-comp/nothing-white", &["case.toml", "touches.csv"]);
    change(&case, "touches.csv", &["z_mm"], |n, old| {
        let z: f64 = old[n][0].parse().unwrap();
        vec![format!("{:.6}", if n == 20 { z + 17.3 } else { z })]
    });
    let ended = case.run("loop");
    assert_ne!(ended.code, 0, "{}", ended.stdout);
    let said = "the input looks wrong: a row of touches.csv in line 22 does not fit the others";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
}

/// The pose to begin with was taken from touches that were counted downwards.
#[test]
fn heights_of_the_opposite_sign_are_told_where_the_start_has_it_too() {
    let case = fixture("pose-icp/published-d-table-4", &["case.toml", "points.csv"]);
    scale(&case, "points.csv", &["z_mm"], -1.0);
    case.replace("case.toml", "z_mm = -284.87", "z_mm = 284.87");
    let ended = case.run("loop");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("`z_mm` of points.csv has the opposite sign"), "{said}");
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

/// Touches of small planes under the names of other touches: nearly the same normals, and the wrong ones.
#[test]
fn further_touches_about_another_touch_than_they_name_are_named() {
    const AROUND_MM: f64 = 0.5;
    const BALL_MM: f64 = 2.0;
    let toml = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 60.0\n\
                center_mm = [0.0, 0.0, -60.0]\nside = \"outside\"\n[probe]\ntip_radius_mm = 2.0\n\
                [model]\nnormal = \"micro-plane\"\n[noise]\npoint_mm = 0.001\n";
    let ball = |x: f64, y: f64| {
        let reach = 60.0 + BALL_MM;
        (reach * reach - x * x - y * y).sqrt() - 60.0
    };
    let noise = |n: u32| 5e-4 * (1e4 * (12.9 * f64::from(n)).sin()).sin();
    let mut touches = "touch,x_mm,y_mm,z_mm\n".to_owned();
    let mut micro = "touch,k,x_mm,y_mm,z_mm\n".to_owned();
    // The last is next to the one before.
    let place = |t: u32| match t {
        30 => (20.0 + 2.0 * AROUND_MM, 18.0),
        _ => (8.0 * f64::from(t % 6) - 20.0, 9.0 * f64::from(t / 6) - 18.0),
    };
    for t in 0..31_u32 {
        let (x, y) = place(t);
        touches += &format!("T{t},{x:.4},{y:.4},{:.5}\n", ball(x, y) + noise(t));
        for (k, (i, j)) in
            (0..).zip([(AROUND_MM, 0.0), (0.0, AROUND_MM), (-AROUND_MM, 0.0), (0.0, -AROUND_MM)])
        {
            let z = ball(x + i, y + j) + noise(100 + 4 * t + k);
            micro += &format!("T{t},{},{:.4},{:.4},{z:.5}\n", k + 1, x + i, y + j);
        }
    }
    let case = Case::new(&[("case.toml", toml), ("touches.csv", &touches), ("micro.csv", &micro)]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    change(&case, "micro.csv", &["touch"], |n, old| {
        let touch = n / 4;
        let named = if touch < 20 { touch } else { 20 + (touch - 20 + 1) % 11 };
        old[4 * named].clone()
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:labels");
    assert_eq!(step["subject"], "micro.csv: touch");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}
