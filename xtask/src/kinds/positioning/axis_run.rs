//! A linear axis sent to targets from either side, and what a laser reads. Millimetres.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::gaussian;

/// What is wrong with the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// It stops this far apart when it comes from either side.
    Reversal(f64),
    /// It goes to and fro by this much once a turn of the screw.
    Cyclic(f64),
    /// It reads long, ratio: it stops short of where it says it is.
    Long(f64),
}

/// A run to simulate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisRun {
    pub fault: Fault,
    pub seed: u64,
}

/// Travel of one turn of the screw.
const LEAD_MM: f64 = 10.0;
/// Standard deviation of one reading.
const NOISE_MM: f64 = 1e-3;
/// Rounds of the targets that a run has.
const ROUNDS: u8 = 2;
/// Distance of targets, a whole number of turns, and how many there are.
const PITCH_MM: f64 = 40.0;
const N_TARGETS: u8 = 9;

impl AxisRun {
    /// What is read at a target, by a generator of noise.
    fn read_mm(&self, target_mm: f64, rising: bool, rng: &mut ChaCha8Rng) -> f64 {
        let off_mm = match self.fault {
            Fault::Reversal(mm) => 0.5 * mm * if rising { 1.0 } else { -1.0 },
            Fault::Long(ratio) => target_mm / (1.0 + ratio) - target_mm,
            Fault::Cyclic(mm) => mm * (TAU * target_mm / LEAD_MM + 0.7).sin(),
        };
        target_mm + off_mm + NOISE_MM * gaussian(rng)
    }

    /// Targets of the run, in order; every one from below.
    fn targets_mm() -> Vec<f64> {
        let round = || (0..N_TARGETS).map(|n| PITCH_MM * f64::from(n));
        (0..ROUNDS).flat_map(|_| round()).collect()
    }

    /// Twice as many readings as there are rows are not needed for these: at the targets and from
    /// the side of the run.
    pub(crate) fn even(count: usize) -> Vec<(f64, bool)> {
        Self::targets_mm().iter().cycle().take(count).map(|target| (*target, true)).collect()
    }

    /// Files of the case with further readings.
    pub(crate) fn files(&self, further: &[(f64, bool)], seed: u64) -> Vec<(&'static str, String)> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut text = String::from("target_mm,actual_mm,direction\n");
        let mut row = |target: f64, rising: bool, rng: &mut ChaCha8Rng| {
            let read_mm = self.read_mm(target, rising, rng);
            let way = if rising { "+1" } else { "-1" };
            let _ = writeln!(text, "{target:.3},{read_mm:.5},{way}");
        };
        for target in Self::targets_mm() {
            row(target, true, &mut rng);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (target, rising) in further {
            row(*target, *rising, &mut rng);
        }
        let targets: Vec<String> =
            (0..=160).map(|n| format!("{:.1}", 2.0 * f64::from(n))).collect();
        let case = format!(
            "kind = \"positioning\"\n\n[axis]\nlead_mm = {LEAD_MM:.1}\n\n[noise]\ndeviation_mm = \
             {NOISE_MM}\n\n[plan]\ntargets = [{}]\ncycles = 1\n",
            targets.join(", ")
        );
        vec![("case.toml", case), ("positions.csv", text)]
    }
}
