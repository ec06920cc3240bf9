//! Mistakes in the touches of a surface.

use serde_json::Value;

use super::{change, first, fixture, scale, swap};
use crate::command::Case;

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
