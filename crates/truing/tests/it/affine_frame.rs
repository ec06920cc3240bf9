//! The general map of presses beside their rigid frame.

use serde_json::Value;

use crate::command::truing;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Least squares by hand: what the map leaves is as printed, no more than what the rigid frame leaves,
/// and orthogonal to the places, as seat and records weigh all presses alike here.
#[test]
fn the_general_map_leaves_what_it_says() {
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/ft-center/nothing-coloured");
    let ended = truing(&["solve", case, "--json"]);
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    let (estimates, affine) = (&answer["estimates"], &answer["estimates"]["affine"]);
    let row = |i: usize| [0, 1, 2].map(|j| number(&affine["matrix"][i][j]));
    let centers = estimates["centers"].as_array().unwrap();
    let frame: Vec<&Value> = centers.iter().filter(|c| c["use"] == "frame").collect();
    let (mut squares, mut rigid, mut along, mut n) = (0.0, 0.0, [[0.0; 3]; 2], 0.0_f64);
    for center in &frame {
        let of = |key: &str| number(&center[key]);
        let machine = [
            of("machine_x_mm") - of("offset_x_mm") - of("correction_x_mm"),
            of("machine_y_mm") - of("offset_y_mm") - of("correction_y_mm"),
            1.0,
        ];
        for (i, found) in [of("x_mm"), of("y_mm")].into_iter().enumerate() {
            let left = found - (0..3).map(|j| row(i)[j] * machine[j]).sum::<f64>();
            squares += left * left;
            (0..3).for_each(|j| along[i][j] += left * machine[j]);
        }
        n += 1.0;
        rigid += of("offset_x_mm").powi(2) + of("offset_y_mm").powi(2);
    }
    let rms = (squares / n).sqrt();
    assert!((rms - number(&affine["residual_rms_mm"])).abs() < 1e-6 * rms, "{rms}");
    assert!(squares <= rigid, "{squares} {rigid}");
    // Records differ a little in noise, and so in weight: a hundredth of what chance would leave.
    for (i, sums) in along.iter().enumerate() {
        assert!(sums[2].abs() < 0.05 * rms * n.sqrt(), "{i}: {sums:?}");
    }
    let dof = 2 * frame.len() - 6;
    assert_eq!(affine["degrees_of_freedom"], dof);
    // A sound machine: scales within five standard uncertainties of one.
    let std = number(&affine["std_ratios"][0][0]);
    assert!((number(&affine["scale_ratios"][0]) - 1.0).abs() < 5.0 * std);
}
