//! The errors of a rotary axis, as smooth functions of its angle.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Size of the errors.
const ERROR_MM: f64 = 4e-3;
const ERROR_RAD: f64 = 15e-6;

/// Smooth errors of the axis: amplitude and phase of the first three harmonics, six times.
pub(crate) struct Curves([[(f64, f64); 3]; 6]);

impl Curves {
    pub(crate) fn random(rng: &mut ChaCha8Rng) -> Self {
        let mut harmonic = |size: f64| {
            (size * rng.random_range(0.2..1.0), rng.random_range(0.0..std::f64::consts::TAU))
        };
        Self(std::array::from_fn(|c| {
            let size = if c < 3 { ERROR_MM } else { ERROR_RAD };
            std::array::from_fn(|_| harmonic(size))
        }))
    }

    pub(crate) fn at(&self, angle_deg: f64) -> ([f64; 3], [f64; 3]) {
        let angle = angle_deg.to_radians();
        let value = |c: usize| -> f64 {
            let harmonics = self.0[c].iter().zip(1..);
            harmonics.map(|((a, phase), n)| a * (f64::from(n) * angle + phase).cos()).sum()
        };
        (std::array::from_fn(value), std::array::from_fn(|c| value(3 + c)))
    }
}
