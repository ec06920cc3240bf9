//! What the loop hands back: the map with the accepted effects, and how well it is known.

use frame_fit::{
    FrameMap, FrameModel, MapWithEffects, MeasuredPoint, Options, PointPair, Transform,
};
use model_discrepancy::{Closure, Column, Model, State, close_loop};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, SMatrix, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

const SIGMA_MM: f64 = 0.005;

/// 1e3 mm · 2⁻⁵² · a few dozen operations.
const EXACT_TOL_MM: f64 = 1e-11;

/// Points in a cube of 400 mm far from the origin, read through a strained source frame.
fn survey(
    seed: u64,
    transform: Transform,
    strain: &SMatrix<f64, 3, 3>,
) -> (FrameMap<3>, Vec<PointPair<3>>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sound = scene::random_map::<3>(&mut rng, transform);
    let strained =
        FrameMap { linear: SMatrix::identity() + strain, translation_mm: Vector3::zeros() };
    let truth = sound.after(&strained);
    let pairs = scene::cloud::<3>(&mut rng, 24, 200.0)
        .into_iter()
        .map(|p| {
            let source = p + Vector3::new(300.0, -200.0, 100.0);
            let noise = scene::gauss::<3>(&mut rng) * SIGMA_MM;
            PointPair::isotropic(source, truth.apply(&source) + noise, SIGMA_MM)
        })
        .collect();
    (truth, pairs)
}

fn model(pairs: &[PointPair<3>], transform: Transform) -> FrameModel<3> {
    let point = |(i, pair): (usize, &PointPair<3>)| MeasuredPoint::new(format!("P{i}"), *pair);
    let points = pairs.iter().enumerate().map(point).collect();
    FrameModel::new(points, &[], &Options::of(transform)).unwrap()
}

fn close(model: &FrameModel<3>) -> Closure {
    let options = model_discrepancy::Options { nested: false, ..Default::default() };
    close_loop(model, &[], &options).unwrap()
}

fn handed_back(model: &FrameModel<3>, closure: &Closure) -> MapWithEffects<3> {
    model.with_effects(&closure.state, &closure.columns, &closure.covariance)
}

#[test]
fn the_map_leaves_the_residual_of_the_loop() {
    let cases = [
        (Transform::Rigid, SMatrix::<f64, 3, 3>::identity() * -2e-4),
        (Transform::Rigid, SMatrix::from_diagonal(&Vector3::new(2e-4, -3e-4, 0.0))),
        (Transform::Rigid, Matrix3::new(0.0, 3e-4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
        (Transform::Translation, Matrix3::new(0.0, -3e-4, 0.0, 3e-4, 0.0, 0.0, 0.0, 0.0, 0.0)),
        (Transform::None, SMatrix::identity() * 3e-4),
    ];
    for (seed, (transform, strain)) in (50..).zip(cases) {
        let (_, pairs) = survey(seed, transform, &strain);
        let model = model(&pairs, transform);
        let closure = close(&model);
        assert_eq!(closure.steps.len(), 1, "{transform:?}: {:?}", closure.steps);
        let of = handed_back(&model, &closure);
        assert!(of.conditions.is_empty(), "{:?}", of.conditions);
        for (i, pair) in pairs.iter().enumerate() {
            let left = pair.target_mm - of.map.apply(&pair.source_mm);
            let of_loop = Vector3::from_column_slice(&closure.residuals_after[3 * i..3 * i + 3]);
            assert!((left - of_loop).norm() < EXACT_TOL_MM, "{transform:?}: {left} {of_loop}");
        }
    }
}

/// Entries of `[L | t]`, row by row.
fn entries(map: &FrameMap<3>) -> DVector<f64> {
    DVector::from_fn(12, |k, _| match k % 4 {
        3 => map.translation_mm[k / 4],
        column => map.linear[(k / 4, column)],
    })
}

/// With unit variance in one column, the covariance is the square of the derivative by it.
#[test]
fn the_covariance_follows_the_derivatives_of_the_map() {
    let (_, pairs) = survey(60, Transform::Rigid, &(SMatrix::identity() * -2e-4));
    let model = model(&pairs, Transform::Rigid);
    let closure = close(&model);
    for (k, column) in closure.columns.iter().enumerate() {
        let mut unit = DMatrix::zeros(closure.columns.len(), closure.columns.len());
        unit[(k, k)] = 1.0;
        let square = model.with_effects(&closure.state, &closure.columns, &unit).covariance;
        // Half the digits of a central difference are lost in values of 1e3 mm.
        let step = 1e-5;
        let at = |sign: f64| {
            let moved = stepped(&closure.state, *column, sign * step);
            entries(&model.with_effects(&moved, &closure.columns, &unit).map)
        };
        let derivative = (at(1.0) - at(-1.0)) / (2.0 * step);
        let difference = (&derivative * derivative.transpose() - &square).amax();
        assert!(difference < 1e-4 * square.amax(), "{column:?}: {difference}");
    }
}

fn stepped(state: &State, column: Column, step: f64) -> State {
    let mut state = state.clone();
    match column {
        Column::Base(k) => state.base[k] += step,
        Column::Amplitude { effect, parameter } => state.amplitudes[effect][parameter] += step,
        Column::Empirical { .. } | Column::Place { .. } => {}
    }
    state
}

/// Translation at the far origin, and every entry of the matrix, after a scale was found.
#[test]
fn intervals_after_an_effect_hold_the_truth() {
    let (mut held, mut all) = ([0; 12], 0);
    for seed in 0..200 {
        let strain = SMatrix::identity() * -2e-4;
        let (truth, pairs) = survey(7000 + seed, Transform::Rigid, &strain);
        let model = model(&pairs, Transform::Rigid);
        let closure = close(&model);
        let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        if names != ["scale"] {
            continue;
        }
        all += 1;
        let of = handed_back(&model, &closure);
        let miss = entries(&of.map) - entries(&truth);
        for (k, held) in held.iter_mut().enumerate() {
            *held += i32::from(miss[k].abs() <= 1.96 * of.covariance[(k, k)].sqrt());
        }
    }
    assert!(all >= 180, "named in {all} of 200");
    for (k, held) in held.into_iter().enumerate() {
        // 95 % of 190 ± 3: four standard deviations.
        let share = f64::from(held) / f64::from(all);
        assert!((0.887..=1.0).contains(&share), "entry {k}: {held} of {all}");
    }
    let mean = f64::from(held.iter().sum::<i32>()) / f64::from(12 * all);
    // Entries of one survey depend on each other: the scatter is that of three or so a survey.
    assert!((0.92..=0.98).contains(&mean), "{mean}");
}

/// A scale about another point is the same map.
#[test]
fn the_reference_is_the_centroid_of_the_fitted_points() {
    let (_, pairs) = survey(61, Transform::Rigid, &SMatrix::zeros());
    let model = model(&pairs, Transform::Rigid);
    let of = handed_back(&model, &close(&model));
    let sum = pairs.iter().fold(Vector3::zeros(), |sum, p| sum + p.source_mm.coords);
    let centroid = Point3::from(sum / pairs.len() as f64);
    assert!((of.reference_mm - centroid).norm() < EXACT_TOL_MM);
}

/// Far from the fit, where motions and strains do not simply add up, and for every family.
#[test]
fn the_covariance_follows_the_derivatives_far_from_the_fit() {
    /// Of central differences over steps of 1e-5: their square, and round-off over it.
    const DIFFERENCE_TOL: f64 = 1e-6;
    const STEP: f64 = 1e-5;
    for (seed, transform) in (70..).zip(Transform::ALL) {
        let (_, pairs) = survey(seed, transform, &SMatrix::zeros());
        let model = model(&pairs, transform);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut state = State::start(&model);
        let declared = model.declared();
        let mut columns: Vec<Column> = (0..declared.base.len()).map(Column::Base).collect();
        for (value, parameter) in state.base.iter_mut().zip(&declared.base) {
            let size = if parameter.unit == "mm" { 20.0 } else { 0.2 };
            *value = scene::uniform::<1>(&mut rng, size)[0];
        }
        for (effect, declared) in declared.effects.iter().enumerate() {
            if ["shift", "rotation", "scale", "anisotropic-scale", "shear"].contains(&&*declared.id)
            {
                for parameter in 0..declared.parameters.len() {
                    state.amplitudes[effect][parameter] = scene::uniform::<1>(&mut rng, 0.1)[0];
                    columns.push(Column::Amplitude { effect, parameter });
                }
            }
        }
        let nothing = DMatrix::zeros(columns.len(), columns.len());
        for (k, column) in columns.iter().enumerate() {
            let at = |step: f64| {
                let moved = stepped(&state, *column, step);
                entries(&model.with_effects(&moved, &columns, &nothing).map)
            };
            let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            let mut unit = nothing.clone();
            unit[(k, k)] = 1.0;
            let square = model.with_effects(&state, &columns, &unit).covariance;
            let off = (square - &expected * expected.transpose()).amax();
            let least = DIFFERENCE_TOL * expected.amax().max(1.0).powi(2);
            assert!(off < least, "{transform}, {column:?}: {off:e}");
        }
    }
}
