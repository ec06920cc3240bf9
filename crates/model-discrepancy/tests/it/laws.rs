//! What a loop answers does not depend on how its model is written.

use model_discrepancy::{Closure, LinearModel, Options, chi2_interval, close_loop};
use nalgebra::{DMatrix, Vector3};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{body, noise, points};

/// The same sums of products over 120 rows, in other units or of other columns.
const AGREEMENT: f64 = 1e-6;
/// Loops are closed in every case.
const CASES: u32 = 4;

/// A body that is `ppm` too long, with noise of 10 µm.
fn scaled_body(seed: u64, ppm: f64) -> LinearModel {
    let points = points(40, seed);
    let mut errors = noise(40, 0.01, 0.0, &mut ChaCha8Rng::seed_from_u64(seed ^ 0xa5));
    for (error, point) in errors.iter_mut().zip(&points) {
        *error += point * (ppm * 1e-6);
    }
    body(&points, &errors)
}

fn closed(model: &LinearModel) -> Closure {
    close_loop(model, &[], &Options::default()).expect("the model is a whole one")
}

/// Whether two loops say the same, the second with every length `by` times as large.
fn same(one: &Closure, other: &Closure, by: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(&one.verdict, &other.verdict);
    let names = |c: &Closure| -> Vec<_> {
        c.steps.iter().map(|s| (s.effect.clone(), s.subject.clone())).collect()
    };
    prop_assert_eq!(names(one), names(other));
    let close = |a: f64, b: f64| (a - b).abs() <= AGREEMENT * a.abs().max(b.abs());
    prop_assert!(close(one.before.train_rms * by, other.before.train_rms));
    prop_assert!(close(one.after.held_out_rms * by, other.after.held_out_rms));
    for (a, b) in one.steps.iter().zip(&other.steps) {
        prop_assert!(close(a.p_value.ln(), b.p_value.ln()), "{} {}", a.p_value, b.p_value);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    /// In another unit of length: the noise is estimated, so that nothing else has one.
    #[test]
    fn another_unit_changes_no_verdict(seed in 0_u64..1000, ppm in 20.0..400.0, power in -3..4) {
        let by = 10_f64.powi(power);
        let model = scaled_body(seed, ppm);
        let mut other = model.clone();
        other.residual *= by;
        same(&closed(&model), &closed(&other), by)?;
    }

    /// With other parameters for the same base: what it can imitate is the same.
    #[test]
    fn other_parameters_for_the_same_motions_change_nothing(
        seed in 0_u64..1000,
        ppm in 20.0..400.0,
        mix in proptest::collection::vec(-0.3..0.3, 36),
    ) {
        let model = scaled_body(seed, ppm);
        let mut other = model.clone();
        // Columns of like length, mixed by a matrix that can be inverted: its diagonal leads.
        let lengths: Vec<f64> = model.base.column_iter().map(|c| c.norm()).collect();
        let mixing = DMatrix::from_fn(6, 6, |i, k| {
            let share = if i == k { 2.0 } else { mix[6 * i + k] };
            share / lengths[i]
        });
        other.base = &model.base * mixing;
        same(&closed(&model), &closed(&other), 1.0)?;
    }

    /// A motion that the base has is no evidence of anything.
    #[test]
    fn a_motion_of_the_base_is_absorbed(
        seed in 0_u64..1000, ppm in 20.0..400.0, shift in [-9.0..9.0, -9.0..9.0, -9.0..9.0],
    ) {
        let model = scaled_body(seed, ppm);
        let mut other = model.clone();
        let shift = Vector3::from(shift);
        for i in 0..40 {
            let mut rows = other.residual.fixed_rows_mut::<3>(3 * i);
            rows += shift;
        }
        same(&closed(&model), &closed(&other), 1.0)?;
    }
}

proptest! {
    /// The interval holds the mean of χ² over its degrees of freedom, which is one, and narrows.
    #[test]
    fn the_interval_of_chi2_holds_one_and_narrows(dof in 0.5..1e4) {
        let [low, high] = chi2_interval(dof);
        prop_assert!((0.0..1.0).contains(&low) && 1.0 < high, "{low} {high}");
        let [lower, higher] = chi2_interval(2.0 * dof);
        prop_assert!(low <= lower && higher < high, "{lower} {higher}");
    }
}
