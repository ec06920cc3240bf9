//! Twists in every regime a law must hold in.

use std::f64::consts::PI;

use geometry::nalgebra::{Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Size of the translations, mm; a large machine.
pub(crate) const REACH_MM: f64 = 1000.0;

/// Round-off of a rotation after some ten products and sums, rad.
pub(crate) const ROTATION_TOL_RAD: f64 = 20.0 * f64::EPSILON;

/// Round-off of a translation of `REACH_MM` after as many: 1e3 mm · 2⁻⁵² · 20, mm.
pub(crate) const TRANSLATION_TOL_MM: f64 = REACH_MM * 20.0 * f64::EPSILON;

/// Angles: the identity, tiny, machine errors, both sides of each switch of formula, near π.
pub(crate) const ANGLES_RAD: [f64; 19] = [
    0.0,
    1e-15,
    1e-9,
    1e-8,
    1e-6,
    1e-3,
    0.1,
    0.999_999_999,
    1.0,
    1.000_000_001,
    1.999_999_999,
    2.0,
    2.000_000_001,
    3.0,
    PI - 1e-3,
    PI - 1e-6,
    PI - 1e-9,
    PI - 1e-12,
    PI - 1e-15,
];

pub(crate) fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub(crate) fn vector(rng: &mut ChaCha8Rng, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-size..size))
}

/// Rotation vectors: every angle of the list about several axes, then random ones.
pub(crate) fn rotations(seed: u64) -> Vec<Vector3<f64>> {
    let mut rng = rng(seed);
    let mut out = Vec::new();
    for angle in ANGLES_RAD {
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            out.push(axis * angle);
        }
        for _ in 0..5 {
            out.push(vector(&mut rng, 1.0).normalize() * angle);
        }
    }
    out.extend((0..200).map(|_| vector(&mut rng, 1.8)));
    out
}

/// Twists: the rotations above with translations of 0, 1e-8 mm and up to `REACH_MM`.
pub(crate) fn twists(seed: u64) -> Vec<Vector6<f64>> {
    let mut rng = rng(seed + 1000);
    let mut out = Vec::new();
    for rotation in rotations(seed) {
        for size in [0.0, 1e-8, REACH_MM] {
            let translation = vector(&mut rng, 1.0) * size;
            let mut twist = Vector6::zeros();
            twist.fixed_rows_mut::<3>(0).copy_from(&translation);
            twist.fixed_rows_mut::<3>(3).copy_from(&rotation);
            out.push(twist);
        }
    }
    out
}
