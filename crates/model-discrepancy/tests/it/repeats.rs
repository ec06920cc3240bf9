//! Lack of fit where places repeat, and one group apart from the others.

use std::f64::consts::TAU;

use model_discrepancy::{
    Closure, Covariate, LinearModel, Options, Quantity, Verdict, close_loop, lack_of_fit,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{body, noise, normal, points, scalars};

/// Places of a run, there and back, five times.
const PLACES: usize = 9;
const CYCLES: usize = 5;

fn positions() -> Vec<f64> {
    let there = (0..PLACES).map(|i| 50.0 * i as f64);
    let back = there.clone().rev();
    let cycle: Vec<f64> = there.chain(back).collect();
    cycle.repeat(CYCLES)
}

fn commanded(values: Vec<f64>) -> Covariate {
    Covariate::coordinate("commanded_mm", Quantity::Position, values)
}

/// One where the noise remembers for so long that nothing is a repeat.
fn p_value(data: &[f64]) -> f64 {
    let test = lack_of_fit(&scalars(data, &[]), &[commanded(positions())]).expect("it fits");
    test.map_or(1.0, |test| test.p_value)
}

/// Sets of data in which chance alone looks like agreement at 5 %.
fn false_alarms(phi: f64, sets: u64) -> usize {
    let alarm = |seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let n = positions().len();
        let data: Vec<f64> = noise(n, 0.003, phi, &mut rng).iter().map(|v| v.x).collect();
        p_value(&data) <= 0.05
    };
    (0..sets).filter(|&seed| alarm(seed)).count()
}

#[test]
fn noise_alone_repeats_as_often_as_the_level_says() {
    // 5 % of 400, three standard deviations of the count allowed.
    let white = false_alarms(0.0, 400);
    assert!((7..=33).contains(&white), "{white}");
    // Two standard errors of the memory are allowed for: fewer.
    let with_memory = false_alarms(0.8, 400);
    assert!(with_memory <= 33, "{with_memory}");
}

#[test]
fn a_profile_that_returns_in_every_cycle_is_no_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let profile = |x: &f64| 0.02 * (TAU * x / 190.0).sin() + 0.01 * (TAU * x / 70.0).cos();
    let data: Vec<f64> =
        positions().iter().map(|x| profile(x) + 0.002 * normal(&mut rng)).collect();
    assert!(p_value(&data) < 1e-12);
    let test = lack_of_fit(&scalars(&data, &[]), &[commanded(positions())]).unwrap().unwrap();
    assert_eq!(test.levels, PLACES);
    // At either end there and back follow each other and are one visit.
    assert_eq!(test.repeats, 2 * CYCLES * PLACES - (2 * CYCLES - 1) - PLACES);
    let model = scalars(&data, &[]);
    let closure =
        close_loop(&model, &[commanded(positions())], &Options::default()).expect("closes");
    assert_eq!(closure.verdict, Verdict::StructureRemains, "{:?}", closure.remaining);
}

#[test]
fn without_repeats_there_is_no_test() {
    let data: Vec<f64> = (0..20).map(|i| 1e-3 * f64::from(i % 3)).collect();
    let places = commanded((0..20).map(f64::from).collect());
    assert_eq!(lack_of_fit(&scalars(&data, &[]), &[places]).unwrap(), None);
}

/// Twelve groups of ten readings.
fn grouped(data: &[f64]) -> LinearModel {
    let mut model = scalars(data, &[]);
    model.declared.layout.observations = (0..data.len()).map(|i| i / 10).collect();
    model.declared.layout.groups.truncate(12);
    model
}

#[test]
fn one_group_apart_is_named() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let off = |i: usize| if i / 10 == 7 { 0.05 } else { 0.0 };
    let data: Vec<f64> = (0..120).map(|i| off(i) + 0.01 * normal(&mut rng)).collect();
    let closure = close_loop(&grouped(&data), &[], &Options::default()).expect("closes");
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    let of_group = closure.remaining.iter().find(|r| r.covariate == "group");
    assert!(of_group.is_some_and(|r| r.shape.starts_with("7 ")), "{:?}", closure.remaining);
}

/// Groups as runs of as many readings.
fn in_runs(data: &[f64], groups: usize) -> LinearModel {
    let mut model = scalars(data, &[]);
    let readings = data.len() / groups;
    model.declared.layout.observations = (0..data.len()).map(|i| i / readings).collect();
    model.declared.layout.groups.truncate(groups);
    model
}

fn of_group(closure: &Closure) -> Option<&str> {
    let found = closure.remaining.iter().find(|r| r.covariate == "group");
    found.map(|found| found.shape.as_str())
}

/// One cycle of five that reads 20 σ high is five times as far off as the means of four scatter.
#[test]
fn one_of_five_groups_apart_is_named() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let off = |i: usize| if i / 24 == 2 { 0.2 } else { 0.0 };
    let data: Vec<f64> = (0..120).map(|i| off(i) + 0.01 * normal(&mut rng)).collect();
    let closure = close_loop(&in_runs(&data, 5), &[], &Options::default()).expect("closes");
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    assert!(of_group(&closure).is_some_and(|s| s.starts_with("2 ")), "{:?}", closure.remaining);
}

/// Groups that each lie elsewhere, by three times what a reading scatters: no single one is apart, and
/// no noise is declared.
#[test]
fn groups_that_each_lie_elsewhere_are_structure() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    let at: Vec<f64> = (0..12).map(|_| 0.03 * normal(&mut rng)).collect();
    let data: Vec<f64> = (0..360).map(|i| at[i / 30] + 0.01 * normal(&mut rng)).collect();
    let closure = close_loop(&in_runs(&data, 12), &[], &Options::default()).expect("closes");
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    let shape = of_group(&closure).unwrap_or_default();
    assert!(shape.starts_with("groups lie apart"), "{:?}", closure.remaining);
}

/// The level is one in a thousand; of 200 sets more than three say so once in 20 000 times.
#[test]
fn noise_that_remembers_puts_no_groups_apart() {
    for phi in [0.0, 0.5, 0.9] {
        let alarm = |seed: &u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(*seed);
            let data: Vec<f64> = noise(360, 0.01, phi, &mut rng).iter().map(|v| v.x).collect();
            let options = Options { nested: false, ..Options::default() };
            let closure = close_loop(&in_runs(&data, 12), &[], &options).expect("closes");
            of_group(&closure).is_some()
        };
        let alarms = (0..200).filter(alarm).count();
        assert!(alarms <= 3, "φ = {phi}: {alarms} of 200");
    }
}

/// Every place has an error of its own, of which a sag, a shear or a scale takes a part: any few numbers
/// do, and their names say nothing.
#[test]
fn laws_of_the_place_do_not_stand_beside_an_error_of_every_place() {
    const TARGETS: usize = 10;
    for seed in 0..12 {
        let places = points(TARGETS, seed);
        let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
        let own: Vec<_> = noise(TARGETS, 0.1, 0.0, &mut rng);
        let visited = |i: usize| i % TARGETS;
        let at: Vec<_> = (0..5 * TARGETS).map(|i| places[visited(i)]).collect();
        let scatter = noise(at.len(), 0.004, 0.0, &mut rng);
        let errors: Vec<_> = scatter.iter().enumerate().map(|(i, e)| e + own[visited(i)]).collect();
        let along = |name: &str, axis: usize| {
            let values = at.iter().map(|p| p[axis]).collect();
            Covariate::coordinate(name, Quantity::Position, values)
        };
        let covariates = [along("x_mm", 0), along("y_mm", 1), along("z_mm", 2)];
        let closure = close_loop(&body(&at, &errors), &covariates, &Options::default()).unwrap();
        let named = closure.steps.iter().find(|s| !s.effect.starts_with("covariate:"));
        assert!(named.is_none(), "{seed}: {named:?}");
        assert!(!closure.steps.is_empty(), "{seed}: {:?}", closure.remaining);
    }
}

#[test]
fn chi_squared_is_told_with_its_interval() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let data: Vec<f64> = (0..120).map(|_| 3.0 * normal(&mut rng)).collect();
    let mut model = grouped(&data);
    model.declared.layout.sigma_declared = true;
    let closure = close_loop(&model, &[], &Options::default()).expect("closes");
    assert_eq!(closure.verdict, Verdict::NoiseLargerThanDeclared);
    let (chi2, [low, high]) = closure.after.chi2_per_dof.zip(closure.after.chi2_interval).unwrap();
    // Nine, and three standard deviations of it; √(2/120) is 0.13.
    assert!((chi2 - 9.0).abs() < 9.0 * 0.39 && low > 0.5 && high < 1.6, "{chi2} {low} {high}");
}

/// What no smooth shape or period describes: every place has an error of its own.
#[test]
fn a_profile_without_a_shape_is_corrected_place_by_place() {
    const OFF_MM: [f64; PLACES] = [0.0, 0.021, -0.013, 0.017, -0.024, 0.006, 0.019, -0.02, 0.011];
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let place = |x: &f64| (0..PLACES).find(|&i| (x - 50.0 * i as f64).abs() < 1.0);
    let off = |x: &f64| OFF_MM[place(x).expect("one of the places")];
    let data: Vec<f64> = positions().iter().map(|x| off(x) + 0.002 * normal(&mut rng)).collect();
    let closure =
        close_loop(&scalars(&data, &[]), &[commanded(positions())], &Options::default()).unwrap();
    let step = &closure.steps[0];
    assert_eq!(step.effect, "covariate:commanded_mm");
    assert!(step.description.contains("a value of its own at each level"), "{}", step.description);
    assert!(closure.after.held_out_rms < 0.2 * closure.before.held_out_rms);
    // Between two places the table says what the places say.
    let at = |name: &str| step.parameters.iter().find(|p| p.name == name).expect("a place");
    let (one, other) = (at("at 50"), at("at 100"));
    let std = one.std.hypot(other.std);
    assert!((one.value - other.value - 0.034).abs() < 4.0 * std, "{one:?} {other:?}");
    // Nobody has named a cause.
    assert_eq!(closure.verdict, Verdict::StructureRemains);
}

/// Few places that are visited again and again are no runs of readings: what wanders from reading to
/// reading is seen, whether its groups are few or not.
#[test]
fn what_wanders_over_few_places_is_structure() {
    const FEW: usize = 5;
    const ROUNDS: usize = 6;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let wander = |i: usize| 0.02 * (TAU * i as f64 / 17.0).sin();
    let data: Vec<f64> = (0..FEW * ROUNDS).map(|i| wander(i) + 0.004 * normal(&mut rng)).collect();
    let mut model = scalars(&data, &[]);
    model.declared.layout.observations = (0..data.len()).map(|i| i % FEW).collect();
    model.declared.layout.groups.truncate(FEW);
    let closure = close_loop(&model, &[], &Options::default()).expect("closes");
    assert_eq!(closure.verdict, Verdict::StructureRemains, "{:?}", closure.steps);
    assert!(
        closure.remaining.iter().any(|r| r.shape == "autocorrelated"),
        "{:?}",
        closure.remaining
    );
}
