//! Input that cannot be judged: one clear error each.

use model_discrepancy::{Condensed, Covariate, LoopError, Options, Origin, assess, close_loop};
use nalgebra::{DMatrix, Vector3};

use crate::linear_model::{parameter, scalars};

fn run(model: &crate::linear_model::LinearModel) -> LoopError {
    close_loop(model, &[], &Options::default()).expect_err("the data cannot be judged")
}

#[test]
fn too_few_groups() {
    let error = run(&scalars(&[1.0, 2.0], &[]));
    assert!(matches!(error, LoopError::TooFewGroups { groups: 2, needed: 3, .. }), "{error}");
}

#[test]
fn a_free_direction_is_named() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0, 5.0], &[]);
    model.base = DMatrix::from_columns(&[
        nalgebra::DVector::from_element(5, 1.0),
        nalgebra::DVector::from_element(5, 2.0),
    ]);
    model.base_names = vec![parameter("zero"), parameter("datum")];
    let error = run(&model);
    assert!(matches!(error, LoopError::Unobservable { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("zero") && text.contains("datum"), "{text}");
    assert!(assess(&model, &Options::default()).is_err());
}

#[test]
fn sigmas_and_layouts_are_checked() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
    model.layout.rows[2].sigma = 0.0;
    assert!(matches!(run(&model), LoopError::InvalidSigma { row: 2, .. }));
    model.layout.rows[2].sigma = 1.0;
    model.layout.rows[3].observation = 9;
    assert!(matches!(run(&model), LoopError::InconsistentLayout { row: 3 }));
}

#[test]
fn what_is_said_beside_the_layout_is_checked() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
    model.directions = Some(vec![Vector3::z(); 3]);
    assert!(matches!(run(&model), LoopError::InconsistentModel { method: "directions", .. }));
    model.directions = None;
    let condensed = |first_row, observations: &[usize], columns| Condensed {
        first_row,
        observations: observations.to_vec(),
        combination: DMatrix::identity(2, columns),
    };
    for wrong in [
        vec![condensed(3, &[0, 1], 2)],
        vec![condensed(0, &[0, 4], 2)],
        vec![condensed(0, &[0, 1], 3)],
        vec![condensed(0, &[0, 1], 2), condensed(1, &[2, 3], 2)],
    ] {
        model.condensed = wrong;
        assert!(matches!(run(&model), LoopError::InconsistentModel { method: "condensed", .. }));
    }
}

#[test]
fn covariates_are_checked() {
    let model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
    for values in [vec![1.0; 3], vec![1.0, f64::NAN, 2.0, 3.0]] {
        let covariate = Covariate { name: "air_c".to_owned(), values, origin: Origin::Recorded };
        let error = close_loop(&model, &[covariate], &Options::default()).unwrap_err();
        assert!(matches!(error, LoopError::InvalidCovariate { .. }), "{error}");
    }
}

#[test]
fn nan_in_the_data_is_an_error() {
    let mut model = scalars(&[1.0, 2.0, 3.0, f64::NAN, 5.0], &[]);
    model.base = DMatrix::from_element(5, 1, 1.0);
    model.base_names = vec![parameter("level")];
    assert!(matches!(run(&model), LoopError::NotFinite { .. }));
}

#[test]
fn exact_data_need_nothing() {
    let model = scalars(&[0.0; 12], &[("offset", vec![1.0; 12])]);
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    assert!(closure.steps.is_empty());
    assert_eq!(closure.before.train_rms.to_bits(), 0.0_f64.to_bits());
}
