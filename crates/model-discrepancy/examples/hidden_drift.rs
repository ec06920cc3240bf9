//! Finds a drift that nobody declared: a gauge block measured twenty times while the room warms.
//!
//! Whether it is time or temperature that does it, these data cannot say; the loop says so.

use model_discrepancy::nalgebra::DVector;
use model_discrepancy::{
    Covariate, Declared, Differenced, Effect, Layout, LoopError, Options, Parameter, Quantity,
    State, close_loop,
};

/// Deviations from the block's certified length, in µm, one per repetition.
const DEVIATION_UM: [f64; 20] = [
    0.11, 0.02, 0.14, 0.20, 0.17, 0.31, 0.26, 0.29, 0.44, 0.38, 0.46, 0.58, 0.49, 0.61, 0.66, 0.71,
    0.65, 0.79, 0.83, 0.80,
];

#[expect(clippy::cast_precision_loss, reason = "twenty repetitions")]
fn order(i: usize) -> f64 {
    i as f64
}

fn main() -> Result<(), LoopError> {
    let n = DEVIATION_UM.len();
    // The declared model: every repetition measures the same length.
    let declared = Declared::new(
        Layout::scalars((0..n).map(|i| format!("repetition {i}")), "µm", None),
        vec![Parameter::new("deviation", "µm", 1.0)],
        vec![Effect::new(
            "drift",
            "the reading grows with every repetition",
            vec![Parameter::new("drift", "µm per repetition", 1.0)],
        )],
    );
    let residuals = |at: &State| {
        let drift = at.amplitudes[0][0];
        DVector::from_fn(n, |i, _| DEVIATION_UM[i] - at.base[0] - drift * order(i))
    };
    let room_c = (0..n).map(|i| 20.0 + 0.05 * order(i)).collect();
    let room = Covariate::recorded("room_c", Quantity::Temperature, room_c);
    let model = Differenced { declared, residuals };
    let closure = close_loop(&model, &[room], &Options::default())?;

    assert_eq!(closure.steps.len(), 1);
    assert_eq!(closure.steps[0].effect, "drift");
    assert_eq!(closure.steps[0].indistinguishable_from, ["covariate:room_c"]);
    assert!(closure.after.held_out_rms < 0.3 * closure.before.held_out_rms);
    Ok(())
}
