//! Analytic tangents against differences, away from zero too.

use ft_center::{
    Displacement, DisplacementModel, GravityModel, GravityOptions, LocateOptions, Noise,
    OrbitOptions, PressModel, solve_presses,
};
use model_discrepancy::{Covariate, Model, Quantity, State, check_tangents};
use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::press_loop::grid;
use crate::simulator::{CONTACT, Colour};

/// What central differences of a smooth function leave, relative to its largest derivative.
const DIFFERENCE_TOL: f64 = 1e-6;

/// A state with every effect switched on a little, `share` of `scale` in report units.
fn everything_on(model: &dyn Model, rng: &mut ChaCha8Rng) -> State {
    let mut at = State::start(model);
    for (effect, amplitude) in model.declared().effects.iter().zip(&mut at.amplitudes) {
        *amplitude = DVector::from_iterator(
            amplitude.len(),
            effect.parameters.iter().map(|p| {
                let size = match p.unit.as_str() {
                    "ppm" => 1e4,
                    "mm" | "%" => 1.0,
                    "µm/N" | "mrad" | "N·mm" => 10.0,
                    _ => 0.3,
                };
                size * rng.random_range(-1.0..1.0) / p.report_factor
            }),
        );
    }
    at
}

pub(crate) fn assert_tangents(model: &dyn Model) {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let declared = State::start(model);
    let worst = check_tangents(model, &declared);
    assert!(worst < DIFFERENCE_TOL, "declared model: {worst:e}");
    for _ in 0..5 {
        let worst = check_tangents(model, &everything_on(model, &mut rng));
        assert!(worst < DIFFERENCE_TOL, "with effects: {worst:e}");
    }
    for proposal in model.proposals() {
        let extended = &*proposal.model().unwrap();
        let worst = check_tangents(extended, &everything_on(extended, &mut rng));
        assert!(worst < DIFFERENCE_TOL, "{}: {worst:e}", proposal.text);
    }
}

#[test]
fn presses() {
    let presses = grid(&[40.0, 70.0], 8.0, &Colour::COLOURED, 1, |_, _| {});
    let solved = solve_presses(&presses, &CONTACT, &OrbitOptions::default()).unwrap();
    let warm = Covariate::recorded(
        "air_c",
        Quantity::Temperature,
        (0..18).map(|i| 19.0 + 0.3 * f64::from(i)).collect(),
    );
    let options = LocateOptions::default();
    assert_tangents(&PressModel::new(&solved, &CONTACT, &options, &[warm]).unwrap());
}

#[test]
fn displacements() {
    let rows: Vec<_> = (1..8)
        .map(|i| Displacement {
            point: i.to_string(),
            commanded_mm: f64::from(i),
            solved_mm: 1.02 * f64::from(i) + 0.1,
        })
        .collect();
    assert_tangents(&DisplacementModel::new(&rows, None).unwrap());
}

#[test]
fn static_poses() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let noise = Noise { force_n: 0.05, moment_nmm: 2.0 };
    let poses = crate::gravity::poses(10, &noise, &mut rng, |_, _| {});
    let warm = Covariate::recorded(
        "air_c",
        Quantity::Temperature,
        (0..10).map(|i| 19.0 + 0.3 * f64::from(i)).collect(),
    );
    assert_tangents(&GravityModel::new(&poses, &GravityOptions::default(), &[warm]).unwrap());
}
