//! Deviations and their uncertainties over many noisy measurements.

use probe_comp::{BallTouch, NormalSource, compensate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene::{TIP_MM, freeform, noise, normal_of, point_of, polynomials};

const SEEDS: u64 = 320;
const TOUCHES: usize = 40;
const SIGMA_MM: f64 = 1e-3;

/// Form error of the part above its nominal surface, along the normal, with its slopes: 6 µm over
/// waves of 25 and 30 mm, so slopes up to 1.5 mrad, of which r δ²/2 makes 3 nm.
fn form_mm(x: f64, y: f64) -> f64 {
    6e-3 * (x / 4.0).sin() * (y / 4.8).cos()
}

/// The ball touches the real part along the real normal, found from differences of the real
/// surface in place of any formula.
fn real_touch(x: f64, y: f64) -> (nalgebra::Point3<f64>, f64) {
    const STEP_MM: f64 = 1e-4;
    let real =
        |x: f64, y: f64| point_of(freeform, x, y) + normal_of(freeform, x, y) * form_mm(x, y);
    let along_x = real(x + STEP_MM, y) - real(x - STEP_MM, y);
    let along_y = real(x, y + STEP_MM) - real(x, y - STEP_MM);
    (real(x, y) + along_x.cross(&along_y).normalize() * TIP_MM, form_mm(x, y))
}

#[test]
fn deviations_of_a_freeform_part_are_as_good_as_the_noise() {
    let nominal = polynomials()[2].1.clone();
    let (mut square, mut covered) = (0.0, 0_u32);
    let mut rng = ChaCha8Rng::seed_from_u64(88);
    for _ in 0..SEEDS {
        let (touches, truth): (Vec<BallTouch>, Vec<f64>) = (0..TOUCHES)
            .map(|_| {
                let (x, y) = (rng.random_range(-20.0..20.0), rng.random_range(-20.0..20.0));
                let (center, form) = real_touch(x, y);
                (BallTouch::new(center + noise(SIGMA_MM, &mut rng), SIGMA_MM), form)
            })
            .unzip();
        let contacts = compensate(&nominal, TIP_MM, &touches, NormalSource::Nominal).unwrap();
        for (contact, truth) in contacts.iter().zip(&truth) {
            let error = contact.deviation_mm - truth;
            square += error * error;
            covered += u32::from(error.abs() < 1.96 * contact.sigma_deviation_mm());
        }
    }
    let n = f64::from(u32::try_from(SEEDS).unwrap() * u32::try_from(TOUCHES).unwrap());
    // 12800 deviations: their root mean square is known to 0.6 %, the coverage to 0.2 %.
    let rms = (square / n).sqrt();
    assert!(rms <= 1.05 * SIGMA_MM && rms > 0.95 * SIGMA_MM, "{rms}");
    let coverage = f64::from(covered) / n;
    assert!((0.93..=0.97).contains(&coverage), "{coverage}");
}
