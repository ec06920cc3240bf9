//! Do the stated uncertainties hold?

use nalgebra::Vector6;
use tracker_lm::{Formulation, Noise, Options, calibrate};

use crate::scene::{Plan, simulate};

/// Simulated surveys; four hundred of them give the table in `docs/tracker-lm.md`.
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
    /// Mean square deviation of each survey.
    squares: Vec<Vector6<f64>>,
    /// Mean normalised square of the six errors at the last angle.
    nees: f64,
}

fn study(formulation: Formulation, plan: &Plan) -> Study {
    let (mut inside, mut nees, mut n) = (Vector6::zeros(), 0.0, 0.0);
    let mut squares = Vec::new();
    for seed in 0..SEEDS {
        let scene = simulate(plan, 1000 + seed);
        let found = calibrate(&scene.survey, &options(formulation)).unwrap();
        let mut own = Vector6::zeros();
        for (found, truth) in found.axis_errors.iter().zip(&scene.errors).skip(1) {
            let left = found.error - truth;
            inside += left.zip_map(&found.sigmas(), |l, s| f64::from(u8::from(l.abs() <= Z * s)));
            own += left.component_mul(&left) / (scene.errors.len() - 1) as f64;
            n += 1.0;
        }
        squares.push(own);
        let last = found.axis_errors.last().unwrap();
        let left = last.error - scene.errors.last().unwrap();
        nees += left.dot(&last.covariance.cholesky().unwrap().solve(&left));
    }
    let rms = (squares.iter().sum::<Vector6<f64>>() / SEEDS as f64).map(f64::sqrt);
    Study { coverage: inside / n, rms, squares, nees: nees / SEEDS as f64 }
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
        println!("{name}: rms {:.3} nm and µrad", (found.rms * 1e6).transpose());
        println!("{name}: NEES {:.2}", found.nees);
        assert!(found.coverage.min() > 0.95 - slack, "{name}: {}", found.coverage);
        assert!((found.nees - 6.0).abs() < nees_slack, "{name}: {}", found.nees);
    }
    // The same surveys: what one is better shows in the difference, survey by survey.
    for c in 0..6 {
        let pairs = joint.squares.iter().zip(&two_step.squares);
        let worse: Vec<f64> = pairs.map(|(joint, two)| joint[c] - two[c]).collect();
        let mean = worse.iter().sum::<f64>() / SEEDS as f64;
        let variance = worse.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        let deviation = (variance / SEEDS as f64).sqrt();
        let whole = 2.0 * two_step.rms[c].powi(2);
        println!(
            "{c}: joint worse by {:.2} ± {:.2} %",
            1e2 * mean / whole,
            1e2 * deviation / whole
        );
        assert!(mean <= 3.0 * deviation, "component {c}: {mean:e} ± {deviation:e}");
    }
}
