//! Strokes of a force-controlled tool along one programmed path, read by an instrument under the
//! workpiece. Millimetres, newtons, seconds.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise};

/// What is wrong in every stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Repeats {
    /// Nothing.
    Nothing,
    /// Around one place of the path the tool loses this share of its force.
    Loss(f64),
    /// A step in the surface pushes by this much and decays, N.
    Kick(f64),
    /// The instrument reads this much under no load, N.
    Zero(f64),
    /// The instrument reads too large, relative.
    Gain(f64),
    /// The instrument drifts in proportion to what it has read so far, N from first to last.
    Drift(f64),
}

/// Strokes to simulate.
#[derive(Clone, Debug)]
pub(crate) struct Strokes {
    pub n_runs: usize,
    /// Readings of one stroke.
    pub n_samples: usize,
    /// Forces asked for, taken in turn, N.
    pub loads_n: Vec<f64>,
    /// Standard deviation of the control's own error, N.
    pub noise_n: f64,
    /// Dependence of successive readings of a stroke.
    pub colour: Colour,
    pub repeats: Repeats,
    pub seed: u64,
}

impl Strokes {
    /// Six strokes of 160 readings at 15, 35 and 55 N.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_runs: 6,
            n_samples: 160,
            loads_n: vec![15.0, 35.0, 55.0],
            noise_n: 0.8,
            colour: Colour::Ar1(0.6),
            repeats: Repeats::Nothing,
            seed,
        }
    }
}

/// Length of the path, mm, and speed, mm/s.
const PATH_MM: f64 = 400.0;
const FEED_MM_PER_S: f64 = 50.0;
/// Where the tool loses force, over which length, and where it is kicked and how far that lasts, mm.
const LOSS_AT_MM: f64 = 260.0;
const LOSS_WIDTH_MM: f64 = 14.0;
const KICK_AT_MM: f64 = 120.0;
const KICK_DECAY_MM: f64 = 25.0;

/// Text of `path.csv`.
pub(crate) fn path_csv(strokes: &Strokes) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(strokes.seed);
    let mut text = "run,time_s,path_mm,force_n,reference_n\n".to_owned();
    for stroke in 0..strokes.n_runs {
        let load_n = strokes.loads_n[stroke % strokes.loads_n.len()];
        let mut noise = Noise::new(strokes.colour, &mut rng);
        let late_mm: f64 = rng.random_range(0.0..1.0);
        for index in 0..strokes.n_samples {
            let path_mm = late_mm + PATH_MM * as_f64(index) / as_f64(strokes.n_samples);
            let own_n = strokes.noise_n * noise.next(&mut rng);
            let done = (as_f64(stroke) + as_f64(index) / as_f64(strokes.n_samples))
                / as_f64(strokes.n_runs);
            let force_n = load_n + repeated_n(strokes.repeats, path_mm, load_n, done) + own_n;
            let time_s = path_mm / FEED_MM_PER_S;
            // A string takes every character.
            let _ = writeln!(
                text,
                "stroke {},{time_s:.4},{path_mm:.3},{force_n:.3},{load_n:.1}",
                stroke + 1
            );
        }
    }
    text
}

/// What is wrong at a place of the path and a share of all readings, N.
fn repeated_n(repeats: Repeats, path_mm: f64, load_n: f64, done: f64) -> f64 {
    match repeats {
        Repeats::Nothing => 0.0,
        Repeats::Loss(share) => {
            let off = (path_mm - LOSS_AT_MM) / LOSS_WIDTH_MM;
            -share * load_n * (-0.5 * off * off).exp()
        }
        Repeats::Kick(n) => {
            let past_mm = path_mm - KICK_AT_MM;
            if past_mm < 0.0 { 0.0 } else { n * (-past_mm / KICK_DECAY_MM).exp() }
        }
        Repeats::Zero(n) => n,
        Repeats::Gain(ratio) => ratio * load_n,
        Repeats::Drift(n) => n * done,
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
