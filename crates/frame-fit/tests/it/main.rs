//! Public behaviour of frame-fit.
#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]
#![expect(clippy::cast_precision_loss, reason = "counts are small")]

mod closing;
mod consistency;
mod degenerate;
mod golden;
mod handed_back;
mod hostile;
mod laws;
mod mislabelled;
mod model;
mod nested;
mod optics_and_bodies;
mod proposed;
mod reflection;
mod reliability;
mod robust;
mod scene;
#[cfg(feature = "serde")]
mod serialised;
mod snooping;
mod tip;

use proptest::test_runner::{Config, RngSeed};

/// Properties are tried on the same cases every time.
fn seeded(cases: u32) -> Config {
    Config {
        rng_seed: RngSeed::Fixed(0x7275_6e67),
        failure_persistence: None,
        ..Config::with_cases(cases)
    }
}
