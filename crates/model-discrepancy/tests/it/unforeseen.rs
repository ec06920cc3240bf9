//! Groups set aside that lie farther from their prediction than the noise allows.

use model_discrepancy::{
    Closure, Group, LinearModel, Options, Remaining, Role, Row, Verdict, close_loop,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{effect, normal, push, scalars, set_base};

const GROUPS: usize = 32;
const TRIALS: u64 = 400;
/// Of 24 fitted groups, 3.2 standard uncertainties of their mean.
const SIZE: f64 = 0.65;
/// Of 400 at a level of 0.5 % there are two on average; more than eight happen once in 4000.
const MOST: usize = 8;
/// Where readings of a group depend on each other, its mean square has a longer tail than the χ² of
/// the same mean and variance that the test takes: some 2 % instead of 0.5, and four standard
/// deviations of a count of eight.
const MOST_IN_RUNS: usize = 8 + 11;

fn is_check(group: usize) -> bool {
    group % 4 == 3
}

/// A level read `per_group` times in each group with AR(1) noise that starts anew in each; every
/// fourth group is only judged.
fn level(seed: u64, per_group: usize, phi: f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut data = Vec::new();
    for _ in 0..GROUPS {
        let mut state = normal(&mut rng);
        for _ in 0..per_group {
            data.push(state);
            state = phi * state + (1.0 - phi * phi).sqrt() * normal(&mut rng);
        }
    }
    let mut model = scalars(&data, &[]);
    set_base(&mut model, &["level"], DMatrix::from_element(data.len(), 1, 1.0));
    let role = |g| if is_check(g) { Role::Check } else { Role::Fit };
    model.declared.layout.groups =
        (0..GROUPS).map(|g| Group { name: format!("G{g}"), role: role(g) }).collect();
    model.declared.layout.observations = (0..data.len()).map(|i| i / per_group).collect();
    model
}

fn closed(model: &LinearModel) -> Closure {
    close_loop(model, &[], &Options::default()).expect("a level is determined")
}

fn is_unforeseen(closure: &Closure) -> bool {
    closure.remaining.iter().any(|r| r.covariate == "check groups")
}

#[test]
fn two_far_groups_among_those_set_aside_are_structure() {
    let mut model = level(1, 1, 0.0);
    assert_eq!(closed(&model).verdict, Verdict::NothingMissing);
    // Seven and eight standard deviations.
    model.residual[11] += 7.0;
    assert_eq!(closed(&model).odd_check, Some(11));
    model.residual[15] += 8.0;
    let closure = closed(&model);
    assert_eq!(closure.odd_check, None);
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    let found = &closure.remaining[0];
    assert_eq!(found.covariate, "check groups");
    assert!(found.shape.ends_with("worst G15"), "{}", found.shape);
}

#[test]
fn groups_like_the_fitted_ones_are_foreseen() {
    for (per_group, phi, most) in [(1, 0.0, MOST), (3, 0.0, MOST), (25, 0.95, MOST_IN_RUNS)] {
        let found = (0..TRIALS).filter(|&s| is_unforeseen(&closed(&level(s, per_group, phi))));
        let found = found.count();
        assert!(found <= most, "{per_group} readings a group, φ = {phi}: {found} of {TRIALS}");
    }
}

/// The same with every fitted reading a candidate for a bad one.
fn with_bad_readings(seed: u64) -> LinearModel {
    let mut model = level(seed, 1, 0.0);
    for g in (0..GROUPS).filter(|&g| !is_check(g)) {
        let mut tangent = DMatrix::zeros(GROUPS, 1);
        tangent[(g, 0)] = 1.0;
        push(&mut model, effect("bad-point", 1).about(&format!("G{g}")), tangent);
    }
    model
}

/// What lies off in one place of a part is met by fitted readings and by those set aside.
#[test]
fn a_bad_reading_is_no_accident_where_those_set_aside_lie_off_too() {
    let mut model = with_bad_readings(3);
    // Twelve standard deviations: named.
    model.residual[10] += 12.0;
    let alone = closed(&model);
    assert_eq!(alone.steps.len(), 1, "{:?}", alone.remaining);
    assert_eq!(alone.steps[0].subject.as_deref(), Some("G10"));
    for g in [9, 11, 15] {
        model.residual[g] += 12.0;
    }
    let closure = closed(&model);
    assert!(closure.steps.is_empty(), "{:?}", closure.steps);
    assert_eq!(closure.verdict, Verdict::StructureRemains);
    let taken_back = |name: &str| {
        let of = |r: &Remaining| r.covariate == name && r.shape.starts_with("no accident");
        closure.remaining.iter().any(of)
    };
    assert!(taken_back("bad-point [G9]") && taken_back("bad-point [G10]"), "{closure:?}");
}

/// A shift by five standard deviations of what is fitted from a group on, which those set aside know
/// nothing of.
#[test]
fn a_name_is_taken_back_that_groups_set_aside_refute() {
    let later = |g: usize| g >= GROUPS * 3 / 4;
    let mut model = level(4, 1, 0.0);
    let tangent = DMatrix::from_fn(GROUPS, 1, |g, _| if later(g) { 1.0 } else { 0.0 });
    push(&mut model, effect("shift", 1), tangent);
    for g in (0..GROUPS).filter(|&g| later(g)) {
        model.residual[g] += 5.0;
    }
    let borne_out = closed(&model);
    assert_eq!(borne_out.steps.len(), 1, "{:?}", borne_out.remaining);
    for g in (0..GROUPS).filter(|&g| later(g) && is_check(g)) {
        model.residual[g] -= 5.0;
    }
    let refuted = closed(&model);
    assert!(refuted.steps.is_empty(), "{:?}", refuted.steps);
    assert_eq!(refuted.verdict, Verdict::StructureRemains);
}

/// What is significant in the fitted groups once in a thousand times by chance, and goes the other way in
/// those set aside, is chance with all of them; borne out by these it stands.
#[test]
fn a_name_must_hold_with_the_groups_that_speak_against_it() {
    let wave = |g: usize| if (g / 4).is_multiple_of(2) { 1.0 } else { -1.0 };
    let of = |fitted: f64, set_aside: f64| {
        let mut model = level(7, 1, 0.0);
        model.base = DMatrix::zeros(GROUPS, 0);
        model.declared.base.clear();
        model.declared.start = nalgebra::DVector::zeros(0);
        for (check, size) in [(false, fitted), (true, set_aside)] {
            let own: Vec<usize> = (0..GROUPS).filter(|&g| is_check(g) == check).collect();
            let there: f64 = own.iter().map(|&g| wave(g) * model.residual[g]).sum();
            let there = there / own.len() as f64;
            for &g in &own {
                model.residual[g] -= there * wave(g);
            }
            let square: f64 = own.iter().map(|&g| model.residual[g].powi(2)).sum();
            let scatter = (square / own.len() as f64).sqrt();
            for &g in &own {
                model.residual[g] = model.residual[g] / scatter + size * wave(g);
            }
        }
        push(&mut model, effect("wave", 1), DMatrix::from_fn(GROUPS, 1, |g, _| wave(g)));
        closed(&model)
    };
    let borne_out = of(SIZE, SIZE);
    assert_eq!(borne_out.steps.len(), 1, "{:?}", borne_out.remaining);
    let against = of(SIZE, -0.5 * SIZE);
    assert!(against.steps.is_empty(), "{:?}", against.steps);
    assert_eq!(against.verdict, Verdict::NothingMissing, "{:?}", against.remaining);
    assert!(against.warnings.iter().any(|w| w.starts_with("wave shows")), "{:?}", against.warnings);
}

/// Declared noise is judged on all groups: what either half would let pass, both do not.
#[test]
fn declared_noise_is_judged_on_groups_set_aside_too() {
    let mut model = level(2, 1, 0.0);
    let spread: f64 = model.residual.iter().map(|v| v * v).sum();
    model.declared.layout.sigma_declared = true;
    let sigma = (spread / 32.0).sqrt() / 1.45;
    model.declared.layout.rows.iter_mut().for_each(|row: &mut Row| row.sigma = sigma);
    let with = closed(&model);
    let without = with_fitted_alone(&model);
    assert_eq!(without.verdict, Verdict::NothingMissing);
    assert_eq!(with.verdict, Verdict::NoiseLargerThanDeclared);
}

fn with_fitted_alone(model: &LinearModel) -> Closure {
    let mut alone = model.clone();
    let kept: Vec<usize> = (0..GROUPS).filter(|&g| !is_check(g)).collect();
    alone.residual = model.residual.select_rows(&kept);
    alone.base = model.base.select_rows(&kept);
    alone.declared.layout.rows.truncate(kept.len());
    alone.declared.layout.observations.truncate(kept.len());
    alone.declared.layout.groups =
        kept.iter().map(|&g| model.declared.layout.groups[g].clone()).collect();
    closed(&alone)
}
