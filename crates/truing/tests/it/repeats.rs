//! Places that were measured more than once.

use serde_json::{Value, json};

use crate::command::Case;

/// Six places, each measured three times; repeats of one place share an error of their own.
fn three_times(same_names: bool) -> Value {
    let mut table = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n".to_owned();
    let places = [(0.0, 0.0), (100.0, 0.0), (100.0, 80.0), (0.0, 80.0), (50.0, 20.0), (30.0, 60.0)];
    // Up to 0.02 mm by place, 0.001 mm by repeat.
    let of_place = [0.012, -0.017, 0.02, -0.009, 0.004, -0.011];
    let of_repeat = [0.001, -0.0007, -0.0003];
    for (repeat, shake) in of_repeat.iter().enumerate() {
        for (i, (x, y)) in places.iter().enumerate() {
            let name = if same_names { format!("P{i}") } else { format!("P{i}-{repeat}") };
            let off = of_place[i] + shake;
            table += &format!("{name},{x},{y},{:.4},{:.4}\n", x + off, y - 0.5 * off);
        }
    }
    let case = Case::new(&[]);
    case.write("case.toml", "kind = \"frame-fit\"\n");
    case.write("pairs.csv", table);
    let answer = case.json("loop");
    assert_eq!(answer["estimates"]["points"].as_array().unwrap().len(), 18);
    assert_eq!(
        answer["estimates"]["points"][6]["point"],
        json!(if same_names { "P0" } else { "P0-1" })
    );
    answer
}

#[test]
fn repeats_of_a_place_are_left_out_together() {
    let error = |answer: Value| answer["before"]["held_out_rms"].as_f64().unwrap();
    let (together, alone) = (error(three_times(true)), error(three_times(false)));
    // A place whose repeats stay in the fit is predicted by its own error.
    assert!(together > 1.15 * alone, "{together} against {alone}");
}

#[test]
fn coordinates_about_the_centre_of_the_earth() {
    let mut table = "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm\n".to_owned();
    let places = [[0.0; 3], [5e6, 0.0, 0.0], [0.0, 4e6, 0.0], [0.0, 0.0, 3e6], [2e6, 1e6, 7e5]];
    for (i, [x, y, z]) in places.iter().enumerate() {
        let (gx, gy, gz) = (4_157_870_237.0 + x, 664_818_678.0 + y, 4_775_000_000.0 + z);
        table += &format!("S{i},{x},{y},{z},{gx},{gy},{gz}\n");
    }
    let case = Case::new(&[]);
    case.write("case.toml", "kind = \"frame-fit\"\n[noise]\npoint_mm = 1.0\n");
    case.write("pairs.csv", table);
    let answer = case.json("solve");
    let x_mm = answer["estimates"]["translation_mm"][0].as_f64().unwrap();
    // Some units of the last place of 4e9 mm.
    assert!((x_mm - 4_157_870_237.0).abs() < 1e-4, "{x_mm}");
    assert!(answer["residual"]["rms"].as_f64().unwrap() < 1e-4);
}

/// Four rounds of eight targets, there and back: an error of each target, and a reversal of a quarter of it. They are
/// few to know their scatter by, but each shows both by itself.
#[test]
fn four_rounds_show_a_profile_and_a_reversal() {
    let of_target = [14.0, 4.0, -39.0, 25.0, -27.0, -5.0, 63.0, -36.0];
    let mut table = "target_mm,actual_mm,direction,cycle\n".to_owned();
    for pass in 0..8_u8 {
        for n in 0..8_usize {
            let target = if pass % 2 == 0 { n } else { 7 - n };
            let side = if pass % 2 == 0 { -13.0 } else { 13.0 };
            // Digits of a sine far behind the point: no wave along the order.
            let noise = (1e5 * (12.9898 * f64::from(pass) + of_target[n]).sin()).fract();
            let at_mm = [0.0, 11.0, 23.0, 31.0, 44.0, 52.0, 60.0, 73.0][target];
            let actual_mm = at_mm + 1e-3 * (of_target[target] + side + 3.0 * noise);
            let way = if pass % 2 == 0 { "+" } else { "-" };
            table += &format!("{at_mm},{actual_mm:.5},{way},c{}\n", pass / 2);
        }
    }
    let case = Case::new(&[]);
    case.write("case.toml", "kind = \"positioning\"\n[loop]\ngroup = \"cycle\"\n");
    case.write("positions.csv", table);
    let answer = case.json("loop");
    let steps = answer["steps"].as_array().unwrap();
    let mut names: Vec<_> = steps.iter().map(|step| step["effect"].as_str().unwrap()).collect();
    names.sort_unstable();
    assert_eq!(names, ["profile", "reversal"], "{}", answer["steps"]);
    assert_eq!(answer["verdict"], "explained");
}
