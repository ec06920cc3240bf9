//! A patch that lies lower than the rest of a plate.

use model_discrepancy::{
    Declared, Effect, Group, Layout, LinearModel, Options, Parameter, Patch, Role, Row, State,
    Verdict, clearest_patches, close_loop,
};
use nalgebra::{DMatrix, DVector, Point3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const TOUCHES: usize = 120;
const SIGMA_MM: f64 = 1e-3;
const HALF_MM: f64 = 50.0;
/// Patches that 200 plates without any may show: one in a hundred is let pass, and the law of
/// small numbers gives more than 7 for 2 once in a thousand.
const MOST_FALSE: usize = 7;

/// Touches of a plate whose height and tilts are fitted; `low` says how much lower it is at a place.
fn plate(seed: u64, low: impl Fn(&Point3<f64>) -> f64) -> (LinearModel, Vec<Option<Point3<f64>>>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut side = || rng.random_range(-HALF_MM..HALF_MM);
    let places: Vec<_> = (0..TOUCHES).map(|_| Point3::new(side(), side(), 0.0)).collect();
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let read = places.iter().map(|p| SIGMA_MM * noise() - low(p));
    let residual = DVector::from_iterator(TOUCHES, read);
    let mut layout = Layout { unit: "mm".into(), sigma_declared: true, ..Layout::default() };
    for index in 0..TOUCHES {
        layout.groups.push(Group { name: format!("touch {index}"), role: Role::Fit });
        layout.observations.push(index);
        layout.rows.push(Row { observation: index, component: 0, sigma: SIGMA_MM, reported: true });
    }
    let base = ["height", "tilt x", "tilt y"].map(|name| Parameter::new(name, "mm", 1.0));
    let columns = DMatrix::from_fn(TOUCHES, 3, |i, k| [1.0, places[i].x, places[i].y][k]);
    let model = LinearModel {
        declared: Declared::new(layout, base.to_vec(), Vec::new()),
        residual,
        base: columns,
        tangents: Vec::new(),
        extended: Vec::new(),
    };
    (model, places.into_iter().map(Some).collect())
}

fn found(model: &LinearModel, places: &[Option<Point3<f64>>]) -> Option<Patch> {
    clearest_patches(model, &State::start(model), places).first().copied()
}

#[test]
fn a_plate_without_one_shows_none() {
    let shown = (0..200).filter(|seed| {
        let (model, places) = plate(*seed, |_| 0.0);
        found(&model, &places).is_some()
    });
    assert!(shown.count() <= MOST_FALSE);
}

#[test]
fn its_place_is_found_and_the_loop_names_it() {
    // Flat inside and steep at its edge, unlike the bell that is looked for.
    let middle = Point3::new(12.0, -9.0, 0.0);
    let low = |p: &Point3<f64>| 8e-3 / (1.0 + ((p - middle).norm() / 16.0).powi(6));
    for seed in 0..10 {
        let (mut model, places) = plate(300 + seed, low);
        let patch = found(&model, &places).expect("eight times the noise, some ten touches");
        assert!((patch.center_mm - middle).norm() < 8.0, "{patch:?}");
        with_patch(&mut model, &places);
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        assert_eq!(names, ["patch"], "{:?}", closure.verdict);
        assert!(closure.steps[0].parameters[0].value < -4.0, "µm, lower");
        assert_ne!(closure.verdict, Verdict::NothingMissing);
    }
}

/// The model with the patches that it shows in its catalogue.
fn with_patch(model: &mut LinearModel, places: &[Option<Point3<f64>>]) {
    for patch in clearest_patches(model, &State::start(model), places) {
        add(model, &patch, places);
    }
}

fn add(model: &mut LinearModel, patch: &Patch, places: &[Option<Point3<f64>>]) {
    let shares = places.iter().flatten().map(|p| -patch.share(p));
    model.tangents.push(DMatrix::from_iterator(TOUCHES, 1, shares));
    model.declared.effects.push(patch.effect(places));
}

type Bend = fn(&Point3<f64>) -> f64;

/// Bends of the whole plate: height at a place, over that at its edge.
const BENDS: [(&str, Bend); 4] = [
    ("bowl", |p| p.coords.norm_squared() / HALF_MM.powi(2)),
    ("saddle", |p| (p.x * p.x - p.y * p.y) / HALF_MM.powi(2)),
    ("twist", |p| p.x * p.y / HALF_MM.powi(2)),
    ("wave", |p| p.x * (p.coords.norm_squared() / HALF_MM.powi(2) - 1.0) / HALF_MM),
];

fn with_bends(model: &mut LinearModel, places: &[Option<Point3<f64>>]) {
    for (id, bend) in BENDS {
        let heights = places.iter().flatten().map(bend);
        model.tangents.push(DMatrix::from_iterator(TOUCHES, 1, heights));
        let height = Parameter::new("height", "µm", 1e3);
        model.declared.effects.push(Effect::new(id, "the plate is bent", vec![height]));
    }
}

/// Touches within its radius with which a patch of eight times the noise is sure to show.
const FEWEST_HELD: usize = 8;

#[test]
fn one_is_found_beside_a_bend_that_hides_it() {
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x9a7c);
        let middle = Point3::new(rng.random_range(-30.0..30.0), rng.random_range(-30.0..30.0), 0.0);
        let (bent, bend) = BENDS[rng.random_range(0..BENDS.len())];
        let low = |p: &Point3<f64>| {
            8e-3 * (-2.0 * (p - middle).norm_squared() / 20.0_f64.powi(2)).exp() + 12e-3 * bend(p)
        };
        let (mut model, places) = plate(2300 + seed, low);
        let held = places.iter().flatten().filter(|p| (*p - middle).norm() < 20.0).count();
        if held < FEWEST_HELD {
            continue;
        }
        with_bends(&mut model, &places);
        with_patch(&mut model, &places);
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let mut names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        names.sort_unstable();
        let mut truth = [bent, "patch"];
        truth.sort_unstable();
        assert_eq!(names, truth, "seed {seed}: {:?}", closure.verdict);
    }
}

#[test]
fn what_its_place_leaves_has_no_other_name() {
    let middle = Point3::new(12.0, -9.0, 0.0);
    let low =
        |p: &Point3<f64>| 20e-3 * (-2.0 * (p - middle).norm_squared() / 24.0_f64.powi(2)).exp();
    for seed in 0..10 {
        let (mut model, places) = plate(2400 + seed, low);
        with_bends(&mut model, &places);
        // A few standard uncertainties of a place beside the true one.
        let beside = Point3::new(14.0, -8.0, 0.0);
        let patch = Patch { center_mm: beside, radius_mm: 24.0, steepness: 2, searched: 1 };
        add(&mut model, &patch, &places);
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        assert_eq!(names, ["patch"], "seed {seed}: {:?}", closure.verdict);
    }
}

#[test]
fn one_over_a_third_of_the_plate_is_a_patch_and_nothing_beside_it() {
    let middle = Point3::new(8.0, -5.0, 0.0);
    let low =
        |p: &Point3<f64>| 8e-3 * (-2.0 * (p - middle).norm_squared() / 34.0_f64.powi(2)).exp();
    for seed in 0..10 {
        let (mut model, places) = plate(2000 + seed, low);
        with_patch(&mut model, &places);
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        assert_eq!(names, ["patch"], "{:?}", closure.verdict);
        assert_eq!(closure.verdict, Verdict::Explained);
        let height = &closure.steps[0].parameters[0];
        assert!((height.value + 8.0).abs() < 4.0 * height.std, "{height:?}");
    }
}

#[test]
fn a_bend_of_the_whole_plate_is_none() {
    let bowl = |p: &Point3<f64>| p.coords.norm_squared() / HALF_MM.powi(2);
    for seed in 0..10 {
        let (mut model, places) = plate(2100 + seed, |p| 5e-3 * bowl(p));
        let heights = places.iter().flatten().map(bowl);
        model.tangents.push(DMatrix::from_iterator(TOUCHES, 1, heights));
        let height = Parameter::new("height", "µm", 1e3);
        model.declared.effects.push(Effect::new("bowl", "the plate is bent", vec![height]));
        with_patch(&mut model, &places);
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let step = &closure.steps[0];
        assert_eq!((step.effect.as_str(), step.indistinguishable_from.len()), ("bowl", 0));
        assert_eq!(closure.verdict, Verdict::Explained);
    }
}

#[test]
fn intervals_count_its_place_as_fitted() {
    const PLATES: u64 = 200;
    const HEIGHT_MM: f64 = -6e-3;
    /// Standard deviations of a share that chance alone passes once in 400.
    const CHANCE: f64 = 3.0;
    let ratio = |n: u64| f64::from(u32::try_from(n).unwrap());
    let middle = Point3::new(12.0, -9.0, 0.0);
    let low = |p: &Point3<f64>| {
        -HEIGHT_MM * (-2.0 * (p - middle).norm_squared() / 20.0_f64.powi(2)).exp()
    };
    let (mut counted, mut covered) = (0, [0; 2]);
    for seed in 0..PLATES {
        let (mut model, places) = plate(1000 + seed, low);
        let Some(patch) = found(&model, &places) else { continue };
        let shares = places.iter().flatten().map(|p| -patch.share(p));
        model.tangents.push(DMatrix::from_iterator(TOUCHES, 1, shares));
        model.declared.effects.push(patch.effect(&places));
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        if closure.steps.len() != 1 {
            continue;
        }
        counted += 1;
        let plate_height = (closure.state.base[0], 0.0, 0);
        let patch_height = (closure.state.amplitudes[0][0], -HEIGHT_MM, 3);
        for (covered, (value, truth, k)) in covered.iter_mut().zip([plate_height, patch_height]) {
            let sigma = closure.covariance[(k, k)].sqrt();
            *covered += u64::from((value.abs() - f64::abs(truth)).abs() <= 1.96 * sigma);
        }
    }
    assert!(counted > PLATES * 9 / 10);
    for covered in covered {
        let share = ratio(covered) / ratio(counted);
        assert!((share - 0.95).abs() <= CHANCE * (0.95 * 0.05 / ratio(counted)).sqrt(), "{share}");
    }
}

#[test]
fn what_it_says_of_its_place_is_what_it_uses() {
    let (model, places) = plate(7, |p| 0.02 * (-(p.coords.norm_squared()) / 200.0).exp());
    let patch = found(&model, &places).unwrap();
    let text = patch.effect(&places).subject.unwrap();
    let said: Vec<f64> = (text.trim_matches(|c| "() m".contains(c)).split(','))
        .map(|number| number.trim().parse().unwrap())
        .collect();
    assert_eq!(said, patch.center_mm.coords.as_slice());
}
