//! Coefficients against 50-digit values, see `tests/data/coefficients.py`.

use geometry::coefficients::{
    cosc, cosc_remainder, half_cot, inverse_remainder, quintic_remainder, sinc, sinc_remainder,
};

/// Demanded of every coefficient at every angle of the table, relative.
const MAX_RELATIVE_ERROR: f64 = 4.0 * f64::EPSILON;

/// The table holds 100 angles from 1e-12 rad to 6 rad at least.
const MIN_ANGLES: usize = 100;

type Coefficient = fn(f64) -> f64;

/// In the order of the table's columns.
const FUNCTIONS: [(&str, Coefficient); 7] = [
    ("sinc", sinc),
    ("cosc", cosc),
    ("sinc_remainder", sinc_remainder),
    ("cosc_remainder", cosc_remainder),
    ("quintic_remainder", quintic_remainder),
    ("half_cot", half_cot),
    ("inverse_remainder", inverse_remainder),
];

#[test]
fn agree_with_fifty_digits_from_tiny_angles_past_pi() {
    let table = include_str!("../data/coefficients.csv");
    let mut rows = table.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<_> = rows.next().unwrap().split(',').collect();
    assert_eq!(header[0], "angle_rad");
    let mut n_angles = 0;
    let mut worst = [0.0_f64; 7];
    for row in rows {
        let cells: Vec<_> = row.split(',').collect();
        let angle: f64 = cells[0].parse().unwrap();
        n_angles += 1;
        for (i, (name, function)) in FUNCTIONS.iter().enumerate() {
            assert_eq!(header[i + 1], *name);
            let expected = cells[i + 1].parse::<f64>().unwrap();
            for signed in [angle, -angle] {
                let error = ((function(signed) - expected) / expected).abs();
                worst[i] = worst[i].max(error / f64::EPSILON);
                assert!(
                    error <= MAX_RELATIVE_ERROR,
                    "{name}({signed}) is off by {} epsilon",
                    error / f64::EPSILON
                );
            }
        }
    }
    assert!(n_angles >= MIN_ANGLES);
    println!("worst in epsilon: {worst:?}");
}

#[test]
fn take_their_limits_at_zero() {
    let limits = [1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0, 1.0 / 12.0];
    for ((name, function), limit) in FUNCTIONS.iter().zip(limits) {
        for angle in [0.0, -0.0, 1e-200, f64::MIN_POSITIVE] {
            let error = (function(angle) - limit).abs() / limit;
            assert!(error <= MAX_RELATIVE_ERROR, "{name}({angle})");
        }
    }
}

#[test]
fn give_nan_for_what_is_no_angle() {
    for (name, function) in FUNCTIONS {
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(function(angle).is_nan(), "{name}({angle})");
        }
    }
}
