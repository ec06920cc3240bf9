//! Labels and set-ups that are not what the tables say.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use crate::command::Case;

fn normal(rng: &mut ChaCha8Rng, sigma: f64) -> f64 {
    let value: f64 = StandardNormal.sample(rng);
    sigma * value
}

fn steps(answer: &Value) -> Vec<String> {
    let steps = answer["steps"].as_array().unwrap();
    steps.iter().map(|s| format!("{}: {}", s["effect"], s["description"])).collect()
}

/// Thirty poses at each of two cups 50 mm apart; the tip is at (1, −2, 33) mm.
fn cups(seed: u64, seat_mm: f64) -> Vec<(usize, [f64; 7])> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut poses = Vec::new();
    for cup in 0..2 {
        for _ in 0..30 {
            let axis: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.4..0.4));
            let rotation =
                nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(axis));
            let place = [600.0, if cup == 0 { -25.0 } else { 25.0 }, 15.0];
            let held = rotation * nalgebra::Vector3::new(1.0, -2.0, 33.0);
            let at: [f64; 3] =
                std::array::from_fn(|k| place[k] - held[k] + normal(&mut rng, seat_mm));
            let q = rotation.quaternion();
            poses.push((cup, [at[0], at[1], at[2], q.w, q.i, q.j, q.k]));
        }
    }
    poses
}

fn pose_case(poses: &[(usize, [f64; 7])], label: impl Fn(usize, usize) -> usize) -> Case {
    let mut table = "place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n".to_owned();
    for (row, (cup, numbers)) in poses.iter().enumerate() {
        let cells: Vec<String> = numbers.iter().map(|v| format!("{v:.9}")).collect();
        table += &format!("cup {},{}\n", label(row, *cup), cells.join(","));
    }
    Case::new(&[("case.toml", "kind = \"frame-fit\"\n"), ("poses.csv", &table)])
}

#[test]
fn rows_under_the_name_of_another_place_are_named_by_their_lines() {
    let poses = cups(51, 0.4);
    // The recorder was not switched in time: the first seven rows of the second cup.
    let case = pose_case(&poses, |row, cup| if (23..30).contains(&row) { 1 } else { cup });
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "input-wrong");
    assert_eq!(answer["steps"][0]["effect"], "input:labels");
    let text = answer["steps"][0]["description"].as_str().unwrap();
    assert!(text.contains("7 rows") && text.contains("lines 25–31"), "{text}");
    assert!(text.contains("label `cup 1`") && text.contains("at `cup 0`"), "{text}");
    // As good as with the right names.
    let sound = pose_case(&poses, |_, cup| cup).json("solve");
    let rms = |answer: &Value| answer["residual"]["rms"].as_f64().unwrap();
    assert!((rms(&answer) / rms(&sound) - 1.0).abs() < 1e-6, "{}", rms(&answer));
    assert!(!sound["warnings"].to_string().contains("input"), "{}", sound["warnings"]);
}

#[test]
fn poses_that_seat_badly_carry_the_right_names() {
    // Seats of 3 mm in cups 50 mm apart, six of them 12 mm off.
    let mut poses = cups(52, 3.0);
    for (_, numbers) in &mut poses[10..16] {
        numbers[1] += 12.0;
    }
    let answer = pose_case(&poses, |_, cup| cup).json("loop");
    assert!(steps(&answer).iter().all(|s| !s.contains("input:")), "{:?}", steps(&answer));
}

/// Six set-ups of two points on a grid, seen with 0.6 mm; `off` moves some set-ups by holes.
fn grid(seed: u64, label: bool, off: &[(usize, [f64; 2])]) -> Case {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut table =
        format!("point,{}from_x_mm,from_y_mm,to_x_mm,to_y_mm\n", if label { "setup," } else { "" });
    for setup in 0..6_u8 {
        let hole = [150.0 * f64::from(setup % 2), 175.0 * (f64::from(setup / 2) - 1.0)];
        let shift = off.iter().find(|(s, _)| *s == usize::from(setup)).map_or([0.0; 2], |o| o.1);
        for cup in 0..2_u8 {
            let from = [hole[0], hole[1] + 50.0 * f64::from(cup)];
            let (x, y) = (from[0] + shift[0], from[1] + shift[1]);
            let to = [470.0 + x + normal(&mut rng, 0.6), y - 26.0 + normal(&mut rng, 0.6)];
            let named = if label { format!("plate {setup},") } else { String::new() };
            table += &format!(
                "p{setup}{cup},{named}{},{},{:.3},{:.3}\n",
                from[0], from[1], to[0], to[1]
            );
        }
    }
    Case::new(&[("case.toml", "kind = \"frame-fit\"\n"), ("pairs.csv", &table)])
}

#[test]
fn a_set_up_that_stood_one_hole_off_is_named_with_its_shift() {
    let answer = grid(53, true, &[(3, [0.0, -25.0])]).json("loop");
    assert_eq!(answer["verdict"], "input-wrong");
    let step = &answer["steps"][0];
    assert_eq!(step["effect"], "input:misplaced");
    assert_eq!(step["subject"], "pairs.csv: setup plate 3");
    let text = step["description"].as_str().unwrap();
    // (x, y): the mean of two points of 0.6 mm against the others, four standard uncertainties.
    let numbers: Vec<f64> =
        text.split(['(', ')']).nth(1).unwrap().split(", ").map(|v| v.parse().unwrap()).collect();
    assert!(numbers[0].abs() < 2.0 && (numbers[1] + 25.0).abs() < 2.0, "{text}");
    let sound = grid(53, true, &[]).json("loop");
    assert_eq!(sound["verdict"], "nothing-missing", "{:?}", steps(&sound));
}

#[test]
fn two_points_that_hide_each_other_are_found_together() {
    let answer = grid(54, false, &[(3, [0.0, -25.0])]).json("loop");
    let subjects: Vec<&str> = (answer["steps"].as_array().unwrap().iter())
        .map(|s| s["subject"].as_str().unwrap_or_default())
        .collect();
    assert_eq!(subjects, ["p30", "p31"], "{:?}", steps(&answer));
    let [before, after] = ["before", "after"].map(|k| answer[k]["held_out_rms"].as_f64().unwrap());
    assert!(after < 0.2 * before, "{before} {after}");
}
