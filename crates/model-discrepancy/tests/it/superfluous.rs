//! Effects that others, found later, make superfluous.

use model_discrepancy::{Options, Outcome, close_loop};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{effect, normal, push, scalars};

const READINGS: usize = 60;
/// Standard deviation of a reading.
const NOISE: f64 = 0.05;
/// From which reading on all are off, and by how much: while that is not known, it hides what
/// `wide` has beyond `narrow`.
const JUMP: (usize, f64) = (25, 2.5);
/// Of the three columns of `wide`, of which the first is `narrow`.
const AMPLITUDES: [f64; 3] = [2.5, 0.2, -0.2];

#[test]
fn an_effect_gets_back_what_a_superfluous_one_held() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let columns: Vec<Vec<f64>> =
        (0..3).map(|_| (0..READINGS).map(|_| normal(&mut rng)).collect()).collect();
    let jump: Vec<f64> = (0..READINGS).map(|i| f64::from(u8::from(i >= JUMP.0))).collect();
    let wide = |i: usize| -> f64 { columns.iter().zip(AMPLITUDES).map(|(c, a)| a * c[i]).sum() };
    let data: Vec<f64> =
        (0..READINGS).map(|i| wide(i) + JUMP.1 * jump[i] + NOISE * normal(&mut rng)).collect();
    let mut model = scalars(&data, &[("narrow", columns[0].clone()), ("jump", jump)]);
    push(
        &mut model,
        effect("wide", 3),
        DMatrix::from_fn(READINGS, 3, |i, column| columns[column][i]),
    );

    let options = Options { nested: false, ..Options::default() };
    let closure = close_loop(&model, &[], &options).unwrap();
    let narrow = closure.passes.iter().flat_map(|pass| &pass.scores).find(|s| s.label == "narrow");
    assert_eq!(narrow.unwrap().outcome, Outcome::Added, "the test shows nothing otherwise");
    let found: Vec<_> = closure.steps.iter().map(|step| step.effect.as_str()).collect();
    assert_eq!(found, ["jump", "wide"]);
    // Five standard uncertainties of the mean of 60 readings.
    let tolerance = 5.0 * NOISE / 60_f64.sqrt();
    for (amplitude, truth) in closure.state.amplitudes[2].iter().zip(AMPLITUDES) {
        assert!((amplitude - truth).abs() < tolerance, "{amplitude}");
    }
}
