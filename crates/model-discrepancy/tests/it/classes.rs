//! Effects that the data cannot tell apart, and the measurement that would.

use model_discrepancy::{LinearModel, Options, Verdict, close_loop};
use nalgebra::DMatrix;

use crate::linear_model::{scalars, set_base};

/// Document [A], Table 4: moved and solved, mm.
const MOVED_MM: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
const SOLVED_MM: [f64; 4] = [0.819, 1.961, 5.168, 10.500];

fn table_4() -> LinearModel {
    let error: Vec<_> = SOLVED_MM.iter().zip(MOVED_MM).map(|(s, m)| s - m).collect();
    let moved = MOVED_MM.to_vec();
    let effects = [
        ("datum-offset", vec![1.0; 4]),
        ("moment-gain", moved.clone()),
        ("force-gain", moved.iter().map(|m| -m).collect()),
    ];
    scalars(&error, &effects)
}

#[test]
fn two_effects_that_hide_each_other_are_found_together() {
    let closure = close_loop(&table_4(), &[], &Options::default()).unwrap();
    assert!((closure.before.train_rms - 0.280).abs() < 0.0005, "{}", closure.before.train_rms);
    let last = closure.steps.last().unwrap();
    // The document's figures to the digits printed.
    assert!((last.train_rms - 0.027).abs() < 0.0005, "{}", last.train_rms);
    assert!((last.held_out_rms - 0.066).abs() < 0.0005, "{}", last.held_out_rms);
    let mut names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["datum-offset", "moment-gain"]);
    assert!(closure.warnings.iter().any(|w| w.contains("rests on 4 groups")));
}

#[test]
fn twins_come_back_as_one_class_with_the_measurement_that_splits_them() {
    let mut model = table_4();
    let mut extended = scalars(
        &[0.0; 6],
        &[
            ("datum-offset", vec![1.0; 6]),
            ("moment-gain", vec![1.0, 2.0, 5.0, 10.0, 5.0, 10.0]),
            ("force-gain", vec![-1.0, -2.0, -5.0, -10.0, -1.0, -2.0]),
        ],
    );
    extended.declared.layout.sigma_declared = false;
    model.extended.push(("repeat the same moves".to_owned(), table_4()));
    model.extended.push(("press at a second load".to_owned(), extended));
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    let gain = closure.steps.iter().find(|s| s.effect == "moment-gain").unwrap();
    assert_eq!(gain.indistinguishable_from, ["force-gain"]);
    assert_eq!(gain.separate_by.as_deref(), Some("press at a second load"));
    let offset = closure.steps.iter().find(|s| s.effect == "datum-offset").unwrap();
    assert!(offset.indistinguishable_from.is_empty());
}

#[test]
fn what_the_model_absorbs_is_not_observable_and_says_what_hides_it() {
    let n = 12;
    let data: Vec<_> = (0..n).map(|i| 0.01 * f64::from((i * 7) % 5)).collect();
    let ramp: Vec<_> = (0..n).map(f64::from).collect();
    let mut model = scalars(&data, &[("offset", vec![2.0; 12]), ("ramp", ramp)]);
    set_base(&mut model, &["level"], DMatrix::from_element(12, 1, 1.0));
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    assert_eq!(closure.not_observable.len(), 1);
    assert_eq!(closure.not_observable[0].effect, "offset");
    assert_eq!(closure.not_observable[0].aliased_with, ["level"]);
    assert_eq!(closure.verdict, Verdict::NothingMissing);
}
