//! Do the stated uncertainties hold?

use nalgebra::Vector6;
use tracker_lm::{Formulation, Noise, Options, calibrate};

use crate::scene::{Plan, simulate};

/// Simulated surveys; `cargo xtask` judges the same bars on more.
const SEEDS: u64 = 60;
/// Half-width of a 95 % interval in standard uncertainties.
const Z: f64 = 1.96;

fn options(formulation: Formulation) -> Options {
    let noise = Noise { displacement_mm: Some(5e-4), rigid_mm: Some(5e-4), station_mm: Some(4e-3) };
    Options { formulation, noise, ..Options::default() }
}

struct Study {
    /// Share of errors within their interval, component by component.
    coverage: Vector6<f64>,
    /// Root-mean-square deviation from the truth.
    rms: Vector6<f64>,
    /// Mean normalised square of the six errors at the last angle.
    nees: f64,
}

fn study(formulation: Formulation, plan: &Plan) -> Study {
    let (mut inside, mut squares, mut nees, mut n) = (Vector6::zeros(), Vector6::zeros(), 0.0, 0.0);
    for seed in 0..SEEDS {
        let scene = simulate(plan, 1000 + seed);
        let found = calibrate(&scene.survey, &options(formulation)).unwrap();
        for (found, truth) in found.axis_errors.iter().zip(&scene.errors).skip(1) {
            let left = found.error - truth;
            inside += left.zip_map(&found.sigmas(), |l, s| f64::from(u8::from(l.abs() <= Z * s)));
            squares += left.component_mul(&left);
            n += 1.0;
        }
        let last = found.axis_errors.last().unwrap();
        let left = last.error - scene.errors.last().unwrap();
        nees += left.dot(&last.covariance.cholesky().unwrap().solve(&left));
    }
    Study { coverage: inside / n, rms: (squares / n).map(f64::sqrt), nees: nees / SEEDS as f64 }
}

/// Angles share the frame's error, so that a survey counts as one trial for the coverage, and
/// its binomial deviation is 2.8 %; three of them.
#[test]
fn intervals_cover_and_the_joint_bundle_is_no_worse() {
    let plan = Plan::default();
    let joint = study(Formulation::Joint, &plan);
    let two_step = study(Formulation::FreePoints, &plan);
    let slack = 3.0 * (0.95_f64 * 0.05 / SEEDS as f64).sqrt();
    // χ² of six per survey: its mean has a standard deviation of √(12/n).
    let nees_slack = 3.0 * (12.0 / SEEDS as f64).sqrt();
    for (name, found) in [("joint", &joint), ("two steps", &two_step)] {
        println!("{name}: coverage {:.3}", found.coverage.transpose());
        println!("{name}: rms {:.3} nm, nrad", (found.rms * 1e6).transpose());
        println!("{name}: NEES {:.2}", found.nees);
        assert!(found.coverage.min() > 0.95 - slack, "{name}: {}", found.coverage);
        assert!((found.nees - 6.0).abs() < nees_slack, "{name}: {}", found.nees);
    }
    // Both carry the frame's error, of which the data know nothing: equal to within 3 %.
    assert!((0..6).all(|c| joint.rms[c] <= 1.03 * two_step.rms[c]));
}
