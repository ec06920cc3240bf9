//! Noise with memory, declared or not, and what goes on for longer than any noise remembers.

use std::f64::consts::TAU;

use model_discrepancy::{Closure, Options, Verdict, close_loop};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{noise, normal, scalars};

/// Readings that go with the one before and scatter as they were declared to: the noise has memory. Declared half as
/// large, something is left that goes on from reading to reading.
#[test]
fn memory_within_the_declared_noise_is_no_structure() {
    const KEPT: f64 = 0.7;
    const STD_MM: f64 = 0.004;
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut noise = STD_MM * normal(&mut rng);
    let data: Vec<f64> = std::iter::repeat_with(|| {
        noise = KEPT * noise + (1.0 - KEPT * KEPT).sqrt() * STD_MM * normal(&mut rng);
        noise
    })
    .take(120)
    .collect();
    let of = |declared_mm: f64| {
        let mut model = scalars(&data, &[]);
        model.declared.layout.sigma_declared = true;
        model.declared.layout.rows.iter_mut().for_each(|row| row.sigma = declared_mm);
        close_loop(&model, &[], &Options::default()).expect("closes")
    };
    let sound = of(STD_MM);
    assert_eq!(sound.verdict, Verdict::NothingMissing, "{:?}", sound.remaining);
    assert!(
        sound.warnings.iter().any(|w| w.contains("the noise has memory")),
        "{:?}",
        sound.warnings
    );
    let small = of(0.5 * STD_MM);
    assert_eq!(small.verdict, Verdict::StructureRemains);
    assert!(small.remaining.iter().any(|r| r.shape == "autocorrelated"), "{:?}", small.remaining);
}

/// Readings of a series whose noise nobody declared.
const N: usize = 110;
const SETS: u64 = 30;

/// Series of which nothing is said to be left.
fn said_to_be_noise(series: impl Fn(&mut ChaCha8Rng) -> Vec<f64>) -> usize {
    let close = |seed: u64| -> Closure {
        let data = series(&mut ChaCha8Rng::seed_from_u64(seed));
        close_loop(&scalars(&data, &[]), &[], &Options::default()).expect("closes")
    };
    (0..SETS).filter(|seed| close(*seed).verdict == Verdict::NothingMissing).count()
}

/// Of noise with memory one series in six is doubted (22 of 30 is two standard deviations below); of a wave that makes
/// half of the variance one in thirty is not, whatever its period from seven readings on.
#[test]
fn undeclared_noise_may_remember_the_reading_before_and_no_more() {
    for memory in [0.3, 0.55] {
        let series =
            |rng: &mut ChaCha8Rng| noise(N, 0.002, memory, rng).iter().map(|v| v.x).collect();
        let sound = said_to_be_noise(series);
        assert!(sound >= 21, "{sound} of {SETS} with a memory of {memory}");
    }
    for period in [14.0, 27.0, 55.0, 220.0] {
        let series = |rng: &mut ChaCha8Rng| {
            let start: f64 = rng.random_range(0.0..TAU);
            let wave = |i: usize| 0.003 * (start + TAU * i as f64 / period).sin();
            (0..N).map(|i| wave(i) + 0.0021 * normal(rng)).collect()
        };
        let missed = said_to_be_noise(series);
        assert!(missed <= 3, "{missed} of {SETS} with a period of {period}");
    }
}
