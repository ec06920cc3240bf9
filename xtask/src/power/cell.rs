//! A situation whose statistics are measured.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::power::scene::Scene;

/// What is asked of the answers of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Question {
    /// How often anything is added although nothing is wrong.
    FalseAddition,
    /// How often this effect is named, alone or in its class, and nothing else is added.
    Named(&'static str),
    /// How often both effects are named, each alone or in its class, and nothing else is added.
    BothNamed([&'static str; 2]),
    /// How often an effect of the catalogue is added, with no covariate among its rivals, and the
    /// matter called explained.
    ConfidentWrongName,
    /// How often the answer is right or honest: every name that is added is one of these (or starts
    /// with it), or a column without a cause, and what is left unexplained is said to be.
    Honest(&'static [&'static str]),
    /// The same of an effect that the design hardly sees: how often it is not in a class.
    OtherName(&'static str),
}

/// One situation.
pub(crate) struct Cell {
    /// Crate.
    pub(crate) krate: &'static str,
    /// In words.
    pub(crate) situation: &'static str,
    pub(crate) question: Question,
    pub(crate) make: fn(u64) -> Scene,
}

impl Cell {
    /// The scene of one seed.
    pub(crate) fn scene(&self, seed: u64) -> Scene {
        (self.make)(seed)
    }
}

/// A direction in space, uniform on the sphere, apart from the seed's other random numbers.
pub(crate) fn direction(seed: u64) -> [f64; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5bd1_e995);
    let z: f64 = rng.random_range(-1.0..1.0);
    let angle = rng.random_range(0.0..std::f64::consts::TAU);
    let radius = (1.0 - z * z).sqrt();
    [radius * angle.cos(), radius * angle.sin(), z]
}

pub(crate) fn sign(d: [f64; 3]) -> f64 {
    d[2].signum()
}
