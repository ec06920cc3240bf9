//! Poses of a robot's flange whose tip touches a few places at known distances. Millimetres.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::gaussian;
use crate::generators::vector::{add, norm, rotate, scale};

/// Where the tip is, from the flange, mm.
const TIP_MM: [f64; 3] = [12.0, -20.0, 150.0];
/// Poses at a place, and places.
const AT_PLACE: usize = 12;
const PLACES: usize = 3;
/// Standard deviation of a coordinate, and that of a known distance, mm.
const NOISE_MM: f64 = 0.02;
const KNOWN_MM: f64 = 0.005;
/// Half of the table on which the places lie, mm.
const REACH_MM: f64 = 250.0;
/// Farthest that the flange leans, rad.
const LEANS_RAD: f64 = 0.6;

/// Files of a case.
pub(crate) fn files(seed: u64) -> Vec<(&'static str, String)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut near = |middle: f64| middle + rng.random_range(-REACH_MM..REACH_MM);
    let places: [[f64; 3]; PLACES] =
        std::array::from_fn(|_| [near(700.0), near(100.0), 0.2 * near(400.0)]);
    let mut text = "place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n".to_owned();
    for (name, place) in (1..).zip(&places) {
        for _ in 0..AT_PLACE {
            let spun = rng.random_range(-3.0..3.0_f64);
            let leans = rng.random_range(0.1..LEANS_RAD);
            let towards = rng.random_range(-3.0..3.0_f64);
            // Turned about its own axis first, then leaned.
            let half = [[0.0, 0.0, 1.0], [towards.cos(), towards.sin(), 0.0]];
            let q = product(turn(half[1], leans), turn(half[0], spun));
            let tip = rotated(q, TIP_MM);
            let off: [f64; 3] = std::array::from_fn(|_| NOISE_MM * gaussian(&mut rng));
            let at = add(add(*place, scale(-1.0, tip)), off);
            // A string takes every character.
            let _ = writeln!(
                text,
                "cup {name},{:.4},{:.4},{:.4},{:.9},{:.9},{:.9},{:.9}",
                at[0], at[1], at[2], q[0], q[1], q[2], q[3]
            );
        }
    }
    let mut known = "from,to,distance_mm,std_mm\n".to_owned();
    for (one, other) in [(0, 1), (1, 2), (0, 2)] {
        let apart = norm(&add(places[one], scale(-1.0, places[other])));
        let read = apart + KNOWN_MM * gaussian(&mut rng);
        let _ = writeln!(known, "cup {},cup {},{read:.4},{KNOWN_MM}", one + 1, other + 1);
    }
    let case = format!("kind = \"frame-fit\"\n\n[noise]\npoint_mm = {NOISE_MM}\n");
    vec![("case.toml", case), ("poses.csv", text), ("distances.csv", known)]
}

/// Quaternion, scalar first, of a rotation about a unit axis.
fn turn(axis: [f64; 3], angle: f64) -> [f64; 4] {
    let [x, y, z] = scale((0.5 * angle).sin(), axis);
    [(0.5 * angle).cos(), x, y, z]
}

fn product([a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]) -> [f64; 4] {
    [
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    ]
}

/// A vector turned by a unit quaternion.
fn rotated(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let axis = [q[1], q[2], q[3]];
    let length = norm(&axis);
    if length == 0.0 { v } else { rotate(scale(1.0 / length, axis), 2.0 * length.atan2(q[0]), v) }
}
