//! Public behaviour of `geometry`.

mod aspheres;
mod closest_point;
mod coefficients;
mod curvature;
mod degenerate;
mod euler;
mod formed;
mod height_grid;
mod jacobian;
mod laws;
mod line_hits;
mod nurbs;
mod planar;
mod polynomial;
mod regimes;
mod scaling;
#[cfg(feature = "serde")]
mod serialised;
mod wrench;

use proptest::test_runner::{Config, RngSeed};

/// Property tests that try the same cases every time.
fn seeded(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..Config::default() }
}
