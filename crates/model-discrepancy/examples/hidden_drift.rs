//! Finds a drift that nobody declared: a gauge block measured twenty times while the room warms.
//!
//! Whether it is time or temperature that does it, these data cannot say; the loop says so.

use model_discrepancy::{
    Covariate, Effect, Group, Layout, LoopError, Model, Options, Origin, Parameter, Role, Row,
    State, close_loop,
};
use nalgebra::{DMatrix, DVector};

/// Deviations from the block's certified length, in µm, one per repetition.
const DEVIATION_UM: [f64; 20] = [
    0.11, 0.02, 0.14, 0.20, 0.17, 0.31, 0.26, 0.29, 0.44, 0.38, 0.46, 0.58, 0.49, 0.61, 0.66, 0.71,
    0.65, 0.79, 0.83, 0.80,
];

/// The declared model: every repetition measures the same length.
struct Repetitions {
    layout: Layout,
    base: Vec<Parameter>,
    effects: Vec<Effect>,
}

impl Repetitions {
    fn new() -> Self {
        let n = DEVIATION_UM.len();
        let row = |observation| Row { observation, component: 0, sigma: 1.0, reported: true };
        let group = |i| Group { name: format!("repetition {i}"), role: Role::Fit };
        let parameter = |name: &str, unit: &str| Parameter {
            name: name.to_owned(),
            unit: unit.to_owned(),
            report_factor: 1.0,
        };
        Self {
            layout: Layout {
                rows: (0..n).map(row).collect(),
                observations: (0..n).collect(),
                groups: (0..n).map(group).collect(),
                unit: "µm".to_owned(),
                sigma_declared: false,
            },
            base: vec![parameter("deviation", "µm")],
            effects: vec![Effect {
                id: "drift".to_owned(),
                subject: None,
                description: "the reading grows with every repetition".to_owned(),
                driver: None,
                searched: 1,
                parameters: vec![parameter("drift", "µm per repetition")],
            }],
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "twenty repetitions")]
fn order(i: usize) -> f64 {
    i as f64
}

impl Model for Repetitions {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn base(&self) -> &[Parameter] {
        &self.base
    }

    fn effects(&self) -> &[Effect] {
        &self.effects
    }

    fn start(&self) -> DVector<f64> {
        DVector::zeros(1)
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let drift = at.amplitudes[0][0];
        DVector::from_fn(DEVIATION_UM.len(), |i, _| DEVIATION_UM[i] - at.base[0] - drift * order(i))
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        DMatrix::from_element(DEVIATION_UM.len(), 1, -1.0)
    }

    fn tangent(&self, _: &State, _: usize) -> DMatrix<f64> {
        DMatrix::from_fn(DEVIATION_UM.len(), 1, |i, _| -order(i))
    }
}

fn main() -> Result<(), LoopError> {
    let room_c = (0..DEVIATION_UM.len()).map(|i| 20.0 + 0.05 * order(i)).collect();
    let room = Covariate { name: "room_c".to_owned(), values: room_c, origin: Origin::Recorded };
    let closure = close_loop(&Repetitions::new(), &[room], &Options::default())?;

    assert_eq!(closure.steps.len(), 1);
    assert_eq!(closure.steps[0].effect, "drift");
    assert_eq!(closure.steps[0].indistinguishable_from, ["covariate:room_c"]);
    assert!(closure.after.held_out_rms < 0.3 * closure.before.held_out_rms);
    Ok(())
}
