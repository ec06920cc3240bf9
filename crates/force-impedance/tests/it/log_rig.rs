//! Logs of a head that follows a wavy surface, from the statics of `equilibrium`, with faults.

use std::f64::consts::TAU;

use force_impedance::{HeadGeometry, LogSample};
use nalgebra::{Point3, Unit, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::equilibrium::{equilibrium, rubbing, tilted};
use crate::usual_head::GEOMETRY;

/// What is wrong with the head, its sensors or the reference.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Faults {
    pub(crate) cell_zero_n: [f64; 4],
    pub(crate) length_zero_mm: [f64; 4],
    pub(crate) cell_gain: [f64; 4],
    pub(crate) weight_n: f64,
    pub(crate) spline_n: f64,
    pub(crate) drift_n: f64,
    pub(crate) delay_s: f64,
    pub(crate) mu: f64,
}

pub(crate) struct Run {
    pub(crate) faults: Faults,
    pub(crate) noise_n: f64,
    /// Correlation of neighbouring samples.
    pub(crate) colour: f64,
    pub(crate) n_samples: usize,
    pub(crate) interval_s: f64,
    pub(crate) with_reference: bool,
    pub(crate) seed: u64,
}

impl Default for Run {
    fn default() -> Self {
        Self {
            faults: Faults::default(),
            noise_n: 0.1,
            colour: 0.0,
            n_samples: 2000,
            interval_s: 0.01,
            with_reference: true,
            seed: 1,
        }
    }
}

/// True normal force at a time: two tones.
fn press(t: f64) -> f64 {
    40.0 + 12.0 * (TAU * 0.31 * t).sin() + 6.0 * (TAU * 0.83 * t + 1.0).sin()
}

/// Head against surface at a time: tip, normal, direction of sliding.
fn place(t: f64) -> (Point3<f64>, Vector3<f64>, f64) {
    let tip_mm = Point3::new(
        3.0 * (TAU * 0.11 * t).sin(),
        -300.0 + 1.5 * (TAU * 0.23 * t).sin(),
        3.0 * (TAU * 0.13 * t).cos(),
    );
    let lean = 0.25 + 0.15 * (TAU * 0.07 * t).sin();
    (tip_mm, tilted(&Vector3::y(), lean, TAU * 0.05 * t), TAU * 0.17 * t)
}

pub(crate) fn record(run: &Run) -> Vec<LogSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(run.seed);
    let f = run.faults;
    let heavy = HeadGeometry { weight_n: GEOMETRY.weight_n + f.weight_n, ..GEOMETRY };
    let mut states = [0.0; 5];
    for state in &mut states {
        *state = StandardNormal.sample(&mut rng);
    }
    let length_s = run.interval_s * run.n_samples as f64;
    (0..run.n_samples)
        .map(|i| {
            let t = run.interval_s * i as f64;
            let (tip_mm, normal, way) = place(t);
            let force_n = rubbing(&normal, press(t), 0.15 + f.mu, way);
            let held = equilibrium(tip_mm, normal, force_n, 300.0, &heavy);
            let later = place(t + 1e-5).0.coords.norm() - tip_mm.coords.norm();
            for state in &mut states {
                let fresh: f64 = StandardNormal.sample(&mut rng);
                *state = run.colour * *state + (1.0 - run.colour * run.colour).sqrt() * fresh;
            }
            let mut cells_n: [f64; 4] = std::array::from_fn(|k| {
                held.cells_n[k] * (1.0 + f.cell_gain[k])
                    + f.cell_zero_n[k]
                    + run.noise_n * states[k]
            });
            // What the spline holds back as the head slides out, the axial cell must push more.
            cells_n[3] += f.spline_n * later.signum();
            let share = t / length_s;
            let reference_n = press(t - f.delay_s) - f.drift_n * share + run.noise_n * states[4];
            LogSample {
                time_s: t,
                lengths_mm: std::array::from_fn(|k| held.lengths_mm[k] + f.length_zero_mm[k]),
                cells_n,
                normal: Unit::new_normalize(normal),
                reference_n: run.with_reference.then_some(reference_n),
                segment: 0,
            }
        })
        .collect()
}
