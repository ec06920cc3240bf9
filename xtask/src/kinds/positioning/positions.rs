//! A linear axis that is sent to the same targets again and again, both ways, and what a laser reads.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::gaussian;

/// A run to simulate.
#[derive(Clone, Debug)]
pub(crate) struct Positions {
    pub n_targets: usize,
    pub n_cycles: usize,
    /// Standard deviation of one reading, mm.
    pub noise_mm: f64,
    /// Standard deviation of the axis' own error from target to target, the same in every cycle, mm.
    pub profile_mm: f64,
    /// How far apart the axis stops when it comes from either side, mm.
    pub reversal_mm: f64,
    /// Whether cycles or targets are left out together.
    pub group: &'static str,
    pub seed: u64,
}

impl Positions {
    /// Nine targets, five cycles, 3 µm; a sound axis.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_targets: 9,
            n_cycles: 5,
            noise_mm: 3e-3,
            profile_mm: 0.0,
            reversal_mm: 0.0,
            group: "cycle",
            seed,
        }
    }
}

/// Distance of targets, mm.
const PITCH_MM: f64 = 5.0;

/// The files of the case.
pub(crate) fn tables(run: &Positions) -> Vec<(&'static str, String)> {
    let mut rng = ChaCha8Rng::seed_from_u64(run.seed);
    let profile_mm: Vec<f64> =
        (0..run.n_targets).map(|_| run.profile_mm * gaussian(&mut rng)).collect();
    let mut text = "point,commanded_mm,solved_mm,direction,cycle,target\n".to_owned();
    for cycle in 0..run.n_cycles {
        let there = (0..run.n_targets).map(|target| (target, 1.0));
        let back = (0..run.n_targets).rev().map(|target| (target, -1.0));
        for (target, way) in there.chain(back) {
            let at_mm = PITCH_MM * f64::from(u32::try_from(target).expect("a few targets"));
            let read_mm = at_mm
                + profile_mm[target]
                + 0.5 * way * run.reversal_mm
                + run.noise_mm * gaussian(&mut rng);
            let name = if way > 0.0 { "up" } else { "down" };
            let _ = writeln!(
                text,
                "c{cycle}t{target}{name},{at_mm:.1},{read_mm:.5},{way},cycle{cycle},place{target}"
            );
        }
    }
    let case = format!("kind = \"ft-center\"\n\n[loop]\ngroup = \"{}\"\n", run.group);
    vec![("case.toml", case), ("displacements.csv", text)]
}

/// The same axis as a case by ISO 230-2.
pub(crate) fn iso_tables(run: &Positions) -> Vec<(&'static str, String)> {
    let noise = format!("deviation_mm = {}", run.noise_mm);
    by_iso(run, ["target_mm", "actual_mm"], (OTHER_PITCHES_MM, run.noise_mm), &noise, |at, _| at)
}

/// The same of an axis with errors that compensations are for, its deviations taken off the targets.
pub(crate) fn deviation_tables(run: &Positions) -> Vec<(&'static str, String)> {
    const SLOPE: f64 = 3e-4;
    const WAVE_MM: f64 = 0.004;
    const REVERSAL_MM: f64 = 0.006;
    let noise = format!("deviation_mm = {}", run.noise_mm);
    let names = ["target_mm", "deviation_mm"];
    by_iso(run, names, (OTHER_PITCHES_MM, run.noise_mm), &noise, |at_mm, way| {
        SLOPE * at_mm + WAVE_MM * (0.02 * at_mm).sin() + 0.5 * way * REVERSAL_MM
    })
}

/// A rotary axis as a case by ISO 230-2.
pub(crate) fn rotary_tables(run: &Positions) -> Vec<(&'static str, String)> {
    let noise = format!("deviation_arcsec = {NOISE_ARCSEC}");
    let noise_deg = NOISE_ARCSEC / 3600.0;
    by_iso(run, ["target_deg", "actual_deg"], (OTHER_PITCHES_DEG, noise_deg), &noise, |at, _| at)
}

/// Seeds of one day.
const SEEDS_A_DAY: u64 = 500_000;
/// Distances of targets, by the day.
const OTHER_PITCHES_MM: [f64; 4] = [40.0, 25.0, 60.0, 50.0];
const OTHER_PITCHES_DEG: [f64; 4] = [40.0, 30.0, 15.0, 20.0];
/// Standard deviation of a reading of a rotary axis.
const NOISE_ARCSEC: f64 = 1.0;

fn by_iso(
    run: &Positions,
    [target, read]: [&str; 2],
    (pitches, noise): ([f64; 4], f64),
    declared: &str,
    of: impl Fn(f64, f64) -> f64,
) -> Vec<(&'static str, String)> {
    let mut rng = ChaCha8Rng::seed_from_u64(run.seed);
    // Another day has other targets.
    let pitch =
        pitches[usize::try_from(run.seed / SEEDS_A_DAY).unwrap_or_default() % pitches.len()];
    let count = |n: usize| f64::from(u32::try_from(n).expect("a few targets"));
    // Not at whole turns of the screw, as the standard asks.
    let targets: Vec<f64> = (0..run.n_targets)
        .map(|n| {
            ((pitch * count(n) + 0.15 * pitch * rng.random_range(0.0..1.0)) * 1e3).round() / 1e3
        })
        .collect();
    let mut text = format!("{target},{read},direction,cycle\n");
    for cycle in 1..=run.n_cycles {
        for (targets, way) in
            [(targets.clone(), 1.0), (targets.iter().rev().copied().collect(), -1.0)]
        {
            for at in targets {
                // A string takes every character.
                let read = of(at, way) + noise * gaussian(&mut rng);
                let _ = writeln!(text, "{at:.3},{read:.6},{way:+},{cycle}");
            }
        }
    }
    let case = format!("kind = \"positioning\"\n\n[noise]\n{declared}\n");
    vec![("case.toml", case), ("positions.csv", text)]
}
