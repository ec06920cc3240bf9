//! Errors before and after, on data that chose nothing.

use model_discrepancy::{
    Closure, Declared, Differenced, HoldOut, Inside, LinearModel, Model, Options, Proposal,
    Remaining, Role, State, Verdict, check_tangents, close_loop,
};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::linear_model::{body, coordinates, noise, normal, points, scalars};

fn scaled_body(seed: u64, n: usize) -> (LinearModel, Vec<Vector3<f64>>) {
    body_scaled_by(8e-5, seed, n)
}

fn body_scaled_by(scale: f64, seed: u64, n: usize) -> (LinearModel, Vec<Vector3<f64>>) {
    let points = points(n, seed);
    let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
    let mut errors = noise(n, 0.01, 0.0, &mut rng);
    for (e, p) in errors.iter_mut().zip(&points) {
        *e += p * scale;
    }
    (body(&points, &errors), points)
}

#[test]
fn nested_error_is_near_the_noise_floor() {
    let (model, points) = scaled_body(5, 24);
    let closure = close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
    assert_eq!(closure.after.hold_out, HoldOut::Nested);
    let floor = 0.01 * 3_f64.sqrt();
    // 72 residuals: the floor itself is known to 1/√144 = 8 %, the fit of 7 parameters adds 5 %.
    assert!(closure.after.held_out_rms < 1.3 * floor, "{}", closure.after.held_out_rms);
    assert!(closure.before.held_out_rms > 1.4 * closure.after.held_out_rms);
    assert_eq!(closure.steps[0].stability.resampled, Some(1.0));
}

/// What just reaches its level with all groups misses it in half of the repetitions without some of them,
/// and is needed in all: that alone is no reason to take it back.
#[test]
fn what_just_reaches_its_level_is_not_called_unstable() {
    // 12 points, 35 µm per metre: of 40 such sets three were called so where only the level counted.
    let mut found = 0;
    for seed in 200..240 {
        let (model, points) = body_scaled_by(3.5e-5, seed, 12);
        let closure = close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
        found += usize::from(closure.steps.iter().any(|s| s.effect == "scale"));
        let unstable = |shape: &str| shape.contains("without some groups");
        let left = closure.remaining.iter().find(|r| unstable(&r.shape));
        assert!(left.is_none_or(|r| r.covariate != "scale"), "seed {seed}: {left:?}");
    }
    assert!((5..40).contains(&found), "{found}: neither never nor always, so near its level");
}

/// A scale of 80 ppm moves points 400 mm from their middle by 30 µm: far more than a decimal of 1 µm
/// hides, far less than one of 1 mm.
#[test]
fn what_the_last_decimal_hides_is_not_added() {
    let (mut model, points) = scaled_body(5, 24);
    model.declared.resolution = 1e-3;
    let closure = close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
    assert_eq!(closure.steps[0].effect, "scale");
    assert_eq!(closure.steps[0].stability.perturbed, Some(1.0));

    model.declared.resolution = 1.0;
    let coarse = close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
    assert!(coarse.steps.is_empty(), "{:?}", coarse.steps);
    let left = coarse.remaining.iter().find(|r| r.covariate == "scale").unwrap();
    assert!(left.shape.contains("readings moved within their resolution"), "{}", left.shape);
    assert_ne!(coarse.verdict, Verdict::NothingMissing);
}

/// A check point known a hundred times less well says nothing once it is weighed; but the error that is reported is
/// its error, and that rises.
#[test]
fn what_raises_the_reported_error_on_check_groups_explains_nothing() {
    const COARSE: usize = 25;
    let explained = |coarse_by: f64| {
        let points = points(30, 6);
        let mut errors = noise(30, 0.01, 0.0, &mut ChaCha8Rng::seed_from_u64(1006));
        for (i, (e, p)) in errors.iter_mut().zip(&points).enumerate() {
            *e += p * (if i == COARSE { coarse_by } else { 8e-5 });
        }
        let mut model = body(&points, &errors);
        for group in &mut model.declared.layout.groups[20..] {
            group.role = Role::Check;
        }
        for row in model.declared.layout.rows.iter_mut().filter(|r| r.observation == COARSE) {
            row.sigma *= 100.0;
        }
        close_loop(&model, &coordinates(&points), &Options::default()).unwrap()
    };
    let sound = explained(8e-5);
    assert_eq!(sound.verdict, Verdict::Explained, "{:?}", sound.remaining);
    let against = explained(-8e-4);
    assert_eq!(against.steps[0].effect, "scale");
    assert!(against.after.held_out_rms > against.before.held_out_rms);
    assert_eq!(against.verdict, Verdict::StructureRemains);
    assert!(against.remaining.iter().any(|r| r.covariate == "unseen groups"));
}

#[test]
fn check_groups_are_judged_and_never_fitted() {
    let (mut model, points) = scaled_body(6, 30);
    for group in &mut model.declared.layout.groups[20..] {
        group.role = Role::Check;
    }
    let closure = close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
    assert_eq!(closure.after.hold_out, HoldOut::CheckGroups);
    assert_eq!(closure.steps[0].effect, "scale");

    let mut spoiled = model.clone();
    for value in spoiled.residual.rows_mut(60, 30).iter_mut() {
        *value += 1.0;
    }
    let again = close_loop(&spoiled, &coordinates(&points), &Options::default()).unwrap();
    assert_eq!(again.state, closure.state, "check groups must not move the fit");
    assert!(again.after.held_out_rms > 1.0);
}

#[test]
fn noise_beyond_what_was_declared_is_its_own_verdict() {
    let (n, points) = (30, points(30, 7));
    let mut rng = ChaCha8Rng::seed_from_u64(1007);
    let mut model = body(&points, &noise(n, 0.03, 0.0, &mut rng));
    for row in &mut model.declared.layout.rows {
        row.sigma = 0.01;
    }
    model.declared.layout.sigma_declared = true;
    let closure = close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
    assert!(closure.steps.is_empty());
    assert_eq!(closure.verdict, Verdict::NoiseLargerThanDeclared);
    assert!(closure.before.chi2_per_dof.unwrap() > 5.0);
}

/// Standard deviations of 0.05 mm where 0.01 mm are declared, and a scale: of 300 ppm, some 0.1 mm, it is
/// named all the same; of 70 ppm it takes a sixth of what exceeds the declared noise.
#[test]
fn a_name_that_hardly_lowers_what_exceeds_the_noise_does_not_stand() {
    let closed = |scale: f64| {
        let points = points(60, 7);
        let mut rng = ChaCha8Rng::seed_from_u64(1009);
        let errors = noise(60, 0.05, 0.0, &mut rng);
        let errors: Vec<_> = errors.iter().zip(&points).map(|(e, p)| e + p * scale).collect();
        let mut model = body(&points, &errors);
        model.declared.layout.rows.iter_mut().for_each(|row| row.sigma = 0.01);
        model.declared.layout.sigma_declared = true;
        close_loop(&model, &coordinates(&points), &Options::default()).unwrap()
    };
    let large = closed(3e-4);
    assert_eq!(large.steps.len(), 1, "{:?}", large.remaining);
    assert_eq!(large.verdict, Verdict::NoiseLargerThanDeclared, "{:?}", large.remaining);
    let small = closed(7e-5);
    assert!(small.steps.is_empty(), "{:?}", small.steps);
    let left = small.remaining.iter().find(|r| r.covariate == "noise");
    assert!(left.is_some_and(|r| r.shape.contains("(scale)")), "{:?}", small.remaining);
}

#[test]
fn the_same_data_give_the_same_answer() {
    let (model, points) = scaled_body(8, 20);
    let run = || close_loop(&model, &coordinates(&points), &Options::default()).unwrap();
    assert_eq!(format!("{:?}", run()), format!("{:?}", run()));
}

#[test]
fn the_checker_sees_a_wrong_tangent() {
    let (model, _) = scaled_body(9, 12);
    let at = State::start(&model);
    // Linear in every parameter: differences are exact but for round-off of the step.
    assert!(check_tangents(&model, &at) < 1e-8);
    let mut wrong = model.clone();
    wrong.base = wrong.base.scale(1.01);
    let mixed = Mixed { right: model, wrong };
    assert!(check_tangents(&mixed, &at) > 1e-3);
}

/// Residuals of one model, derivatives of another.
struct Mixed {
    right: LinearModel,
    wrong: LinearModel,
}

impl Model for Mixed {
    fn declared(&self) -> &Declared {
        self.right.declared()
    }
    fn residuals(&self, at: &State) -> nalgebra::DVector<f64> {
        self.right.residuals(at)
    }
    fn base_jacobian(&self, at: &State) -> nalgebra::DMatrix<f64> {
        self.wrong.base_jacobian(at)
    }
    fn tangent(&self, at: &State, effect: usize) -> nalgebra::DMatrix<f64> {
        self.wrong.tangent(at, effect)
    }
    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        Vec::new()
    }
}

#[test]
fn differences_close_the_loop_as_well() {
    let (model, _) = scaled_body(3, 10);
    let declared = model.declared.clone();
    let by_difference = Differenced { declared, residuals: |at: &State| model.residuals(at) };
    let at = State::start(&model);
    for effect in 0..model.declared.effects.len() {
        let (a, b) = (model.tangent(&at, effect), by_difference.tangent(&at, effect));
        // Round-off of a residual near one, over a step that moves it by 6e-6, a few times over.
        let longest = a.amax();
        assert!((a - b).amax() < 1e-9 * longest);
    }
    let options = Options::default();
    let [a, b] =
        [&model as &dyn Model, &by_difference].map(|m| close_loop(m, &[], &options).unwrap());
    assert_eq!(a.steps[0].effect, b.steps[0].effect);
    assert!((a.steps[0].p_value / b.steps[0].p_value - 1.0).abs() < 1e-4);
}

/// Five readings far out tell two names apart, the last of them alone: without that one the other name is
/// chosen, and misses it by more than none would. All other repetitions agree.
#[test]
fn one_repetition_that_chooses_otherwise_takes_no_name_back() {
    const NEAR: usize = 48;
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let far = [8.0, -8.0, 8.0, -8.0];
    let near: Vec<[f64; 2]> = (0..NEAR).map(|_| [0, 1].map(|_| 0.3 * normal(&mut rng))).collect();
    let column = |of: usize, last: f64| -> Vec<f64> {
        near.iter().map(|pair| pair[of]).chain(far).chain([last]).collect()
    };
    let (right, wrong) = (column(0, 8.0), column(1, -24.0));
    let mut data: Vec<f64> = right.iter().map(|trace| trace + 0.5 * normal(&mut rng)).collect();
    // What makes the wrong one the likelier without the last.
    for (value, [a, b]) in data.iter_mut().zip(&near) {
        *value += 1.5 * b - a;
    }
    let model = scalars(&data, &[("right", right), ("wrong", wrong)]);
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    assert_eq!(names, ["right"], "{:?}", closure.remaining);
    let again = closure.steps[0].stability.resampled.unwrap();
    assert!((0.9..1.0).contains(&again), "{again}");
    // And nothing is explained while any error on unseen groups does not fall.
    assert!(closure.after.held_out_rms > closure.before.held_out_rms);
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    let is_told = |left: &Remaining| {
        left.covariate == "unseen groups" && left.shape.contains("but for 4, 28, 52,")
    };
    assert!(closure.remaining.iter().any(is_told), "{:?}", closure.remaining);
}

/// Half as much scatter again as declared, in squares and more: of normal noise it is too much, of noise with heavy tails
/// it may be the few readings that are far off.
#[test]
fn how_much_more_scatter_is_larger_noise_depends_on_its_tails() {
    const N: usize = 120;
    const SQUARES: f64 = 1.7;
    let verdict = |inverse: &dyn Fn(f64) -> f64| {
        // Quantiles in an order without any pattern.
        let data: Vec<f64> = (0..N)
            .map(|i| inverse(((i * 37 + i * i * 11) % N) as f64 / N as f64 + 0.5 / N as f64))
            .collect();
        let mean_square = data.iter().map(|v| v * v).sum::<f64>() / N as f64;
        let mut model = scalars(&data, &[]);
        model.declared.layout.sigma_declared = true;
        let sigma = (mean_square / SQUARES).sqrt();
        model.declared.layout.rows.iter_mut().for_each(|row| row.sigma = sigma);
        close_loop(&model, &[], &Options::default()).expect("closes").verdict
    };
    let (normal, tails) = (Normal::standard(), StudentsT::new(0.0, 1.0, 3.0).expect("a law"));
    assert_eq!(verdict(&|p| normal.inverse_cdf(p)), Verdict::NoiseLargerThanDeclared);
    assert_eq!(verdict(&|p| tails.inverse_cdf(p)), Verdict::NothingMissing);
}

/// A reading nine standard uncertainties off among sixty normal ones may be of a tail: it has no name, and is pointed at.
/// Among readings of which none stands out, nothing is.
#[test]
fn a_reading_that_stands_out_is_pointed_at() {
    const N: usize = 60;
    const FAR: usize = 17;
    let closed = |off: f64| {
        let mut data: Vec<f64> = (0..N)
            .map(|i| {
                let p = ((i * 37 + i * i * 11) % N) as f64 / N as f64 + 0.5 / N as f64;
                Normal::standard().inverse_cdf(p)
            })
            .collect();
        data[FAR] = off;
        let mut model = scalars(&data, &[]);
        model.declared.layout.sigma_declared = true;
        model.declared.layout.rows.iter_mut().for_each(|row| row.sigma = 1.0);
        close_loop(&model, &[], &Options::default()).expect("closes")
    };
    let pointed = |closure: &Closure, at: &str| closure.warnings.iter().any(|w| w.contains(at));
    let far = closed(9.0);
    assert_eq!(far.verdict, Verdict::NoiseLargerThanDeclared);
    assert!(
        pointed(&far, "a reading of 17 lies 9.0 standard uncertainties off"),
        "{:?}",
        far.warnings
    );
    assert!(!pointed(&closed(1.0), "standard uncertainties off"));
}
