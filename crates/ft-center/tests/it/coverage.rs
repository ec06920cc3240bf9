//! Intervals cover the truth as often as they say.

use ft_center::{OrbitOptions, solve_orbit};
use nalgebra::Point2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::simulator::{CONTACT, Colour, Head, record};

fn orbit_coverage(colour: &Colour, samples: usize, rate_hz: f64, seed: u64, trials: usize) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let truth = Point2::new(12.0, -7.0);
    let mut inside = 0;
    let mut z = 0;
    let (mut dof, mut ratio) = (0.0, [0.0, 0.0]);
    let mut spins = 0;
    for _ in 0..trials {
        let record = record(truth, &Head::default(), colour, samples, rate_hz, &mut rng);
        let orbit = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap();
        spins += usize::from(
            orbit
                .wobble
                .is_some_and(|w| (w.spin_hz + 1.7).abs() < 0.05 || (w.spin_hz - 1.7).abs() < 0.05),
        );
        let factor = StudentsT::new(0.0, 1.0, orbit.degrees_of_freedom).unwrap().inverse_cdf(0.975);
        for axis in 0..2 {
            let error = orbit.center_mm[axis] - truth[axis];
            let std = orbit.covariance_mm2[(axis, axis)].sqrt();
            inside += usize::from(error.abs() <= factor * std);
            z += usize::from(error.abs() <= 1.96 * std);
            ratio[0] += error * error;
            ratio[1] += std * std;
        }
        dof += orbit.degrees_of_freedom;
    }
    println!(
        "n {samples} spins {spins} dof {} var ratio {} z-coverage {} eff",
        dof / trials as f64,
        ratio[0] / ratio[1],
        z as f64 / (2.0 * trials as f64)
    );
    inside as f64 / (2 * trials) as f64
}

#[test]
fn explore() {
    for (n, rate) in [(200, 20.0), (600, 40.0), (3000, 100.0), (3000, 1000.0)] {
        for colour in
            [Colour::WHITE, Colour::COLOURED, Colour { memory_s: 1.0, ..Colour::COLOURED }]
        {
            println!(
                "{n} {rate} {:?} -> {}",
                colour.memory_s,
                orbit_coverage(&colour, n, rate, 1, 400)
            );
        }
    }
}
