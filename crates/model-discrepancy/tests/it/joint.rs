//! Several data sets of one machine.

use model_discrepancy::{
    Closure, CommonEffect, Effect, Joint, JointPart, LinearModel, Options, ShownAmplitude, State,
    Verdict, check_tangents, close_loop,
};
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{effect, normal, scalars};

const N: usize = 24;
/// Size of what the machine does, as it is found in a third of the parts at most: with a column of unit rms
/// its standard uncertainty is 1/√24 of the noise, 0.2.
const WEAK: f64 = 0.55;
/// The sign with which each part shows it.
const SIGNS: [f64; 4] = [1.0, -1.0, 1.0, 1.0];

/// A reading every step of a ramp that the machine may stretch, beside a step that is of the part.
fn part(seed: u64, stretched: f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let ramp: Vec<f64> = (0..N).map(|i| (i as f64 / 11.5 - 1.0) * 1.661).collect();
    let step = (0..N).map(|i| f64::from(u8::from(i % 3 == 0))).collect();
    let data: Vec<f64> = ramp.iter().map(|t| stretched * t + normal(&mut rng)).collect();
    let mut model = scalars(&data, &[("stretch", ramp), ("step", step)]);
    model.declared.layout.sigma_declared = true;
    model
}

fn parts(seed: u64, stretched: impl Fn(usize) -> f64) -> Vec<LinearModel> {
    (0..SIGNS.len()).map(|k| part(seed + k as u64, SIGNS[k] * stretched(k))).collect()
}

fn joint(models: &[LinearModel]) -> Joint<'_> {
    let parts = models.iter().enumerate().map(|(k, model)| JointPart {
        name: format!("part {k}"),
        model: model as &dyn model_discrepancy::Model,
        noise_ratio: 1.0,
    });
    let shown = SIGNS.iter().take(models.len()).enumerate().map(|(part, &factor)| ShownAmplitude {
        part,
        effect: 0,
        parameter: 0,
        of: 0,
        factor,
    });
    let machine: Effect = effect("stretch", 1).about("machine");
    let common = CommonEffect { effect: machine, shown: shown.collect() };
    Joint::new(parts.collect(), vec![common]).expect("one unit")
}

fn named(closure: &Closure) -> Vec<String> {
    let label = |s: &model_discrepancy::Step| {
        format!("{} [{}]", s.effect, s.subject.as_deref().unwrap_or_default())
    };
    closure.steps.iter().map(label).collect()
}

/// Of 40 machines: what no part names alone in most of them is named with all data in nearly all.
#[test]
fn what_every_part_shows_a_little_is_named_with_all_of_them() {
    let (mut alone, mut together, mut covered) = (0, 0, 0);
    for seed in (0..40).map(|k| 1000 + 10 * k) {
        let models = parts(seed, |_| WEAK);
        let close = |model: &dyn model_discrepancy::Model| {
            close_loop(model, &[], &Options::default()).unwrap()
        };
        alone += models.iter().filter(|m| !close(*m).steps.is_empty()).count();
        let closure = close(&joint(&models));
        if named(&closure) == ["stretch [machine]"] {
            together += 1;
            let size = &closure.steps[0].parameters[0];
            covered += usize::from((size.value - WEAK).abs() < 1.96 * size.std);
        }
    }
    assert!(3 * alone <= 160, "{alone} of 160 parts");
    assert!(together >= 34, "{together} of 40 machines");
    // 95 % but for three standard errors, and the little by which what is named is the larger.
    assert!(covered * 100 >= together * 82, "{covered} of {together}");
}

#[test]
fn what_one_part_alone_shows_is_not_of_the_machine() {
    let models = parts(77, |k| if k == 2 { 2.0 } else { 0.0 });
    let closure = close_loop(&joint(&models), &[], &Options::default()).unwrap();
    assert_eq!(named(&closure), ["stretch [part 2]"]);
    assert_eq!(closure.verdict, Verdict::Explained);
}

#[test]
fn derivatives_are_those_of_the_parts() {
    let models = parts(5, |_| 0.3);
    let joint = joint(&models);
    let mut at = State::start(&joint);
    for (k, amplitudes) in at.amplitudes.iter_mut().enumerate() {
        *amplitudes = DVector::from_element(amplitudes.len(), 0.1 * (k as f64 + 1.0));
    }
    let worst = check_tangents(&joint, &at);
    assert!(worst < 1e-8, "{worst:e}");
    // 0.1 of the machine, turned, and 0.4 of its own (effect 3 of nine).
    let second = joint.of_part(1, &at);
    assert!((second.amplitudes[0][0] - (0.4 - 0.1)).abs() < 1e-12, "{second:?}");
    assert_eq!(joint.rows(1), N..2 * N);
}

#[test]
fn residuals_of_two_units_are_not_joined() {
    let mut models = parts(9, |_| 0.0);
    models[1].declared.layout.unit = "N".to_owned();
    let parts =
        models.iter().map(|model| JointPart { name: "part".to_owned(), model, noise_ratio: 1.0 });
    assert!(Joint::new(parts.collect(), Vec::new()).is_none());
    assert!(Joint::new(Vec::new(), Vec::new()).is_none());
}
