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
