//! Input that cannot be judged: one clear error each.

use model_discrepancy::{
    Covariate, LoopError, Options, Projected, Quantity, Scope, State, assess, check_tangents,
    close_loop, lack_of_fit,
};
use nalgebra::{DMatrix, Vector3};

use crate::linear_model::{scalars, set_base};

fn run(model: &model_discrepancy::LinearModel) -> LoopError {
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
    set_base(
        &mut model,
        &["zero", "datum"],
        DMatrix::from_columns(&[
            nalgebra::DVector::from_element(5, 1.0),
            nalgebra::DVector::from_element(5, 2.0),
        ]),
    );
    let error = run(&model);
    assert!(matches!(error, LoopError::Unobservable { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("zero") && text.contains("datum"), "{text}");
    assert!(assess(&model, &Options::default()).is_err());
}

#[test]
fn sigmas_and_layouts_are_checked() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
    model.declared.layout.rows[2].sigma = 0.0;
    assert!(matches!(run(&model), LoopError::InvalidSigma { row: 2, .. }));
    model.declared.layout.rows[2].sigma = 1.0;
    model.declared.layout.rows[3].observation = 9;
    assert!(matches!(run(&model), LoopError::InconsistentLayout { row: 3 }));
}

#[test]
fn a_start_of_the_wrong_length_is_an_error() {
    // The model has no base parameter.
    for length in [1, 2] {
        let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
        model.declared.start = nalgebra::DVector::zeros(length);
        let assessed = assess(&model, &Options::default()).expect_err("no start of this model");
        let places = Covariate::coordinate("x_mm", Quantity::Position, vec![0.0, 0.0, 1.0, 1.0]);
        let tested = lack_of_fit(&model, &[places]).expect_err("no start of this model");
        for error in [run(&model), assessed, tested] {
            assert!(
                matches!(error, LoopError::InconsistentModel { field: "start", .. }),
                "{error}"
            );
        }
    }
}

#[test]
fn tangents_are_not_right_at_what_is_no_state() {
    let model = scalars(&[1.0, 2.0, 3.0, 4.0], &[("ramp", vec![0.0, 1.0, 2.0, 3.0])]);
    let vector = |length: usize| nalgebra::DVector::<f64>::zeros(length);
    let state = |base: usize, amplitudes: &[usize]| State {
        base: vector(base),
        amplitudes: amplitudes.iter().map(|length| vector(*length)).collect(),
    };
    // The model has no base parameter, and one effect of one parameter.
    assert!(check_tangents(&model, &state(0, &[1])).is_finite());
    for at in [state(1, &[1]), state(0, &[]), state(0, &[1, 1]), state(0, &[2]), state(0, &[0])] {
        assert!(check_tangents(&model, &at).is_infinite(), "{at:?}");
    }
}

/// A course or patch that was described for other rows, as those of a model to which readings were added.
#[test]
fn a_place_that_was_found_has_all_rows_of_the_layout() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[("drift", vec![0.0, 1.0, 2.0, 3.0])]);
    let at = State::start(&model);
    for by_place in [vec![DMatrix::zeros(3, 1)], vec![DMatrix::zeros(4, 1); 2]] {
        model.declared.effects[0].by_place = by_place;
        assert!(matches!(run(&model), LoopError::InconsistentModel { field: "by_place", .. }));
        assert!(check_tangents(&model, &at).is_infinite());
    }
    model.declared.effects[0].by_place = vec![DMatrix::zeros(4, 1)];
    assert!(check_tangents(&model, &at).is_finite());
}

#[test]
fn what_is_said_beside_the_layout_is_checked() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
    model.declared.directions = Some(vec![Vector3::z(); 3]);
    assert!(matches!(run(&model), LoopError::InconsistentModel { field: "directions", .. }));
    model.declared.directions = None;
    let projected = |first_row, observations: &[usize], columns| Projected {
        first_row,
        readings: observations.iter().map(|&o| (o, 0)).collect(),
        combination: DMatrix::identity(2, columns),
    };
    for wrong in [
        vec![projected(3, &[0, 1], 2)],
        vec![projected(0, &[0, 4], 2)],
        vec![projected(0, &[0, 1], 3)],
        vec![projected(0, &[0, 1], 2), projected(1, &[2, 3], 2)],
    ] {
        model.declared.projected = wrong;
        assert!(matches!(run(&model), LoopError::InconsistentModel { field: "projected", .. }));
    }
}

#[test]
fn an_effect_that_moves_nothing_is_an_error_unless_it_says_so() {
    let mut model = scalars(&[1.0, 2.0, 3.0, 4.0], &[("forgotten", vec![0.0; 4])]);
    let error = run(&model);
    assert!(matches!(&error, LoopError::EmptyColumn { effect, .. } if effect == "forgotten"));
    assert!(check_tangents(&model, &State::start(&model)).is_infinite());
    model.declared.effects[0].scope = Scope::SomeDesigns;
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    assert_eq!(closure.not_observable[0].effect, "forgotten");
    assert!(check_tangents(&model, &State::start(&model)) < 1e-9);
}

#[test]
fn covariates_are_checked() {
    let model = scalars(&[1.0, 2.0, 3.0, 4.0], &[]);
    for values in [vec![1.0; 3], vec![1.0, f64::NAN, 2.0, 3.0]] {
        let covariate = Covariate::recorded("air_c", Quantity::Temperature, values);
        let error = close_loop(&model, &[covariate], &Options::default()).unwrap_err();
        assert!(matches!(error, LoopError::InvalidCovariate { .. }), "{error}");
    }
}

#[test]
fn nan_in_the_data_is_an_error() {
    let mut model = scalars(&[1.0, 2.0, 3.0, f64::NAN, 5.0], &[]);
    set_base(&mut model, &["level"], DMatrix::from_element(5, 1, 1.0));
    assert!(matches!(run(&model), LoopError::NotFinite { .. }));
}

#[test]
fn exact_data_need_nothing() {
    let model = scalars(&[0.0; 12], &[("offset", vec![1.0; 12])]);
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    assert!(closure.steps.is_empty());
    assert_eq!(closure.before.train_rms.to_bits(), 0.0_f64.to_bits());
}
