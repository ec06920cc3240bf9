//! The declared model as the loop sees it.

use model_discrepancy::{
    Covariate, Model, Options, Proposal, Quantity, Role, State, Verdict, check_tangents, close_loop,
};
use nalgebra::{DVector, Vector3};
use pose_icp::{
    EdgeTouches, MeasuredTouch, PoseModel, PoseOptions, PoseParameter, PoseStart, Touch,
};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use crate::pose_scene::{
    RADIUS_MM, TIP_MM, center_over, edge, paraboloid, random_pose, tip, touches,
};

/// Sunflower of `n` points within `radius_mm`.
fn spread(n: u32, radius_mm: f64) -> Vec<[f64; 2]> {
    (0..n)
        .map(|i| {
            let radius = radius_mm * ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
            let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
            [radius * cos, radius * sin]
        })
        .collect()
}

fn measured(touches: Vec<Touch>) -> Vec<MeasuredTouch> {
    let named = |(i, touch): (usize, Touch)| MeasuredTouch {
        name: format!("P{i}"),
        group: format!("P{i}"),
        role: Role::Fit,
        touch,
    };
    touches.into_iter().enumerate().map(named).collect()
}

/// Central differences over tilts of 4e-5 rad of an asphericity that varies over 40/480 rad.
const DIFFERENCE_TOL: f64 = 1e-5;

#[test]
fn derivatives_agree_with_differences_for_every_effect_and_clamping() {
    let mut rng = ChaCha8Rng::seed_from_u64(461);
    let pose = random_pose(&mut rng);
    let points = touches(&pose, &spread(14, 45.0), 1e-3, &mut rng);
    let recorded =
        [("time_s", Quantity::Time), ("part_c", Quantity::Temperature)].map(|(name, quantity)| {
            let values = (0..14).map(|i| 20.0 + f64::from(i * i % 11)).collect();
            Covariate::recorded(name, quantity, values)
        });
    // Side touches to 1 mm, so that rounding of whitened rows stays below the differences.
    let edge = EdgeTouches { sigma_mm: 1.0, ..edge(&pose, 1e-3, &mut rng) };
    let side = edge.locate(tip(), 0.3).unwrap();
    let held = vec![PoseParameter::X, PoseParameter::Beta, PoseParameter::Gamma];
    for options in [
        PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() },
        PoseOptions { tip: tip(), held, ..PoseOptions::default() },
    ] {
        let model =
            PoseModel::new(paraboloid(), measured(points.clone()), &recorded, &pose, &options)
                .unwrap();
        let mut models: Vec<Box<dyn Model>> = vec![Box::new(model.clone())];
        models.extend(model.proposals().iter().filter_map(Proposal::model));
        assert!(models.len() > 8, "{}", models.len());
        for model in models {
            let mut at = State::start(&*model);
            at.base = DVector::from_fn(at.base.len(), |_, _| rng.random_range(-1e-3..1e-3));
            let worst = check_tangents(&*model, &at);
            assert!(worst < DIFFERENCE_TOL, "{worst:e}");
            for amplitude in at.amplitudes.iter_mut().flat_map(|a| a.iter_mut()) {
                *amplitude = rng.random_range(-1e-5..1e-5);
            }
            let worst = check_tangents(&*model, &at);
            assert!(worst < DIFFERENCE_TOL, "{worst:e}");
        }
    }
}

#[test]
fn astigmatism_is_found_with_its_size_and_nothing_is_where_nothing_is() {
    let mut rng = ChaCha8Rng::seed_from_u64(462);
    let pose = random_pose(&mut rng);
    let at = spread(40, 48.0);
    let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
    let options = PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
    let close = |touches: Vec<Touch>| {
        let touches = measured(touches);
        let model = PoseModel::new(paraboloid(), touches, &[], &side.start, &options).unwrap();
        close_loop(&model, &model.all_covariates(), &Options::default()).unwrap()
    };
    let clean = touches(&pose, &at, 1e-3, &mut rng);
    assert_eq!(close(clean.clone()).verdict, Verdict::NothingMissing);

    // 8 µm at the rim, raised along the part's own z.
    let up = center_over(&pose, 0.0, 0.0, TIP_MM + 1.0) - center_over(&pose, 0.0, 0.0, TIP_MM);
    let bent: Vec<Touch> = (clean.iter().zip(&at))
        .map(|(touch, [x, y])| {
            let height = 8e-3 * (x * x - y * y) / 2500.0;
            Touch { center_mm: touch.center_mm + up * height, ..*touch }
        })
        .collect();
    let closure = close(bent);
    let step = &closure.steps[0];
    let names: Vec<&str> = std::iter::once(step.effect.as_str())
        .chain(step.indistinguishable_from.iter().map(String::as_str))
        .collect();
    assert!(names.contains(&"astigmatism"), "{names:?}");
    if step.effect == "astigmatism" {
        let cos = &step.parameters[0];
        assert!((cos.value - 8.0).abs() < 4.0 * cos.std, "{cos:?}");
    }
    assert_eq!(closure.verdict, Verdict::Explained);
}

/// Play of 60 µm in x shows as 3 µm on slopes of a twentieth, and stretches what is touched from outside
/// inwards: it is no scale of that axis.
#[test]
fn play_on_a_weakly_curved_mirror_is_no_scale() {
    const PLAY_MM: f64 = 0.06;
    const SIGMA_MM: f64 = 5e-4;
    let mut rng = ChaCha8Rng::seed_from_u64(464);
    let pose = PoseStart::level(random_pose(&mut rng).position_mm, 0.0);
    // In no order: touches far out come from the inside more often than not.
    let mut at = spread(60, 48.0);
    at.shuffle(&mut rng);
    let side = edge(&pose, SIGMA_MM, &mut rng).locate(tip(), 0.0).unwrap();
    let options = PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
    let mut points = touches(&pose, &at, SIGMA_MM, &mut rng);
    let mut before: Option<f64> = None;
    for touch in &mut points {
        let x_mm = touch.center_mm.x;
        let way = before.replace(x_mm).map_or(1.0, |before| (x_mm - before).signum());
        touch.center_mm.x += 0.5 * PLAY_MM * way;
    }
    let model = PoseModel::new(paraboloid(), measured(points), &[], &side.start, &options).unwrap();
    let closure = close_loop(&model, &model.all_covariates(), &Options::default()).unwrap();
    let names: Vec<_> = closure.steps.iter().map(|s| (&*s.effect, s.subject.as_deref())).collect();
    assert_eq!(names, [("reversal", Some("x, by touch"))]);
    let play = &closure.steps[0].parameters[0];
    assert!((play.value - 500.0 * PLAY_MM).abs() < 4.0 * play.std, "{play:?}");
}

/// What is known beforehand lies nowhere on the part: columns have their mean there, on which no trend turns.
#[test]
fn prior_knowledge_has_the_mean_of_every_column() {
    let mut rng = ChaCha8Rng::seed_from_u64(463);
    let pose = random_pose(&mut rng);
    let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
    let options = PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
    let points = measured(touches(&pose, &spread(14, 45.0), 1e-3, &mut rng));
    let warm = (0..14).map(|i| 20.0 + f64::from(i)).collect();
    let column = Covariate::recorded("part_c", Quantity::Temperature, warm);
    let model = PoseModel::new(paraboloid(), points, &[column], &pose, &options).unwrap();
    let observations = model.declared().layout.observations.len();
    assert!(observations > 14, "the side is an observation of its own");
    for covariate in model.all_covariates() {
        let (of_touches, beside) = covariate.values.split_at(14);
        let mean = of_touches.iter().sum::<f64>() / 14.0;
        assert_eq!(covariate.values.len(), observations);
        // Round-off of 14 terms of 50 mm.
        assert!(beside.iter().all(|v| (v - mean).abs() < 1e-12), "{}", covariate.name);
    }
    let warm = model.all_covariates().into_iter().find(|c| c.name == "part_c").unwrap();
    assert!((warm.values[14] - 26.5).abs() < 1e-12);
}

/// Effects of tip and machine by their definitions, on a mirror that lies level: a larger ball is read farther
/// off by as much, and an axis that leans moves a touch along the other by its share of the way.
#[test]
fn tip_and_squareness_are_what_they_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(464);
    let pose = PoseStart::level(Vector3::new(40.0, -25.0, 10.0), 0.0);
    let at = spread(14, 45.0);
    let points = touches(&pose, &at, 0.0, &mut rng);
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    let model =
        PoseModel::new(paraboloid(), measured(points.clone()), &[], &pose, &options).unwrap();
    let start = State::start(&model);
    let effect = |id: &str| model.declared().effects.iter().position(|e| e.id == id).unwrap();
    let of_tip = model.tangent(&start, effect("tip-radius"));
    assert!(of_tip.column(0).iter().take(14).all(|v| (v.abs() - 1.0).abs() < 1e-12), "{of_tip}");
    let squareness = effect("squareness");
    let tangent = model.tangent(&start, squareness);
    let names = &model.declared().effects[squareness].parameters;
    for (k, parameter) in names.iter().enumerate() {
        let [first, second] = [0, 1].map(|i| "xyz".find(&parameter.name[i..=i]).unwrap());
        let lever = |i: usize| points[i].center_mm[second];
        let share = |i: usize| {
            let [x, y] = at[i];
            let normal = Vector3::new(-x / RADIUS_MM, -y / RADIUS_MM, 1.0).normalize();
            normal[first]
        };
        let (low, high) = (3, 11);
        let by_lever = tangent[(high, k)] / share(high) - tangent[(low, k)] / share(low);
        // Feet good to 1e-12 mm over slopes of a tenth.
        assert!(
            (by_lever.abs() - (lever(high) - lever(low)).abs()).abs() < 1e-9,
            "{}",
            parameter.name
        );
    }
}

/// A milliradian between x and z moves a touch of this mirror by a twentieth of a micrometre: what touches of a micrometre
/// cannot show is not asked of them.
#[test]
fn squareness_to_z_is_looked_for_where_touches_are_good_enough() {
    let pose = PoseStart::level(Vector3::new(40.0, -25.0, 10.0), 0.0);
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    let names = |sigma_mm: f64| {
        let mut rng = ChaCha8Rng::seed_from_u64(466);
        let points = measured(touches(&pose, &spread(14, 45.0), sigma_mm, &mut rng));
        let model = PoseModel::new(paraboloid(), points, &[], &pose, &options).unwrap();
        let effects = &model.declared().effects;
        let squareness = effects.iter().find(|e| e.id == "squareness").unwrap();
        squareness.parameters.iter().map(|p| p.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(names(1e-3), ["xy"]);
    assert_eq!(names(1e-5), ["xy", "xz", "yz"]);
}

/// Readings that come to rest show as a settling drift before anything is fitted.
#[test]
fn a_drift_that_settles_is_in_the_catalogue() {
    let mut rng = ChaCha8Rng::seed_from_u64(465);
    let pose = random_pose(&mut rng);
    let mut points = touches(&pose, &spread(40, 48.0), 1e-3, &mut rng);
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    let seconds: Vec<f64> = (0..40).map(|i| 5.0 * f64::from(i)).collect();
    let time = Covariate::recorded("time_s", Quantity::Time, seconds.clone());
    let settling = |points: &[Touch]| {
        let columns = [time.clone()];
        let points = measured(points.to_vec());
        let model = PoseModel::new(paraboloid(), points, &columns, &pose, &options).unwrap();
        let effects = model.declared().effects.clone();
        let is_settling = |s: &String| s.contains("settling");
        effects.iter().filter(|e| e.subject.as_ref().is_some_and(is_settling)).count()
    };
    assert_eq!(settling(&points), 0);
    // Forty times the noise, to a third within a tenth of the session.
    for (touch, time) in points.iter_mut().zip(&seconds) {
        touch.center_mm.z -= 0.04 * (-time / 20.0).exp();
    }
    assert!(settling(&points) > 0);
}

/// To touches a machine's z axis that reads long is a vertex radius, and both have their noise in the readings: which of
/// the two is named must not go by whether the radius is short or long.
#[test]
fn a_radius_that_is_short_is_named_as_one_that_is_long_is() {
    const SIGMA_MM: f64 = 1e-3;
    let mut rng = ChaCha8Rng::seed_from_u64(467);
    for seed in 0..4 {
        for share in [-5e-3, 5e-3] {
            let pose = PoseStart::level(random_pose(&mut rng).position_mm, 0.0);
            let side = edge(&pose, SIGMA_MM, &mut rng).locate(tip(), 0.0).unwrap();
            let prior = side.prior;
            let options =
                PoseOptions { tip: tip(), lateral: Some(prior), ..PoseOptions::default() };
            let made_mm = RADIUS_MM * (1.0 + share);
            let noise = Normal::new(0.0, SIGMA_MM).unwrap();
            let touch = |[x, y]: [f64; 2]| {
                let normal = Vector3::new(-x / made_mm, -y / made_mm, 1.0).normalize();
                let on = Vector3::new(x, y, (x * x + y * y) / (2.0 * made_mm));
                let center = pose.position_mm + on + normal * (TIP_MM + noise.sample(&mut rng));
                Touch::new(center, SIGMA_MM)
            };
            let points = measured(spread(50, 45.0).into_iter().map(touch).collect());
            let model = PoseModel::new(paraboloid(), points, &[], &side.start, &options).unwrap();
            let closure = close_loop(&model, &model.all_covariates(), &Options::default()).unwrap();
            let names: Vec<&str> = closure.steps.iter().map(|s| &*s.effect).collect();
            assert_eq!(names, ["vertex-radius"], "{seed}: {share}");
            let rivals = &closure.steps[0].indistinguishable_from;
            assert!(rivals.iter().any(|r| r == "axis-scale"), "{rivals:?}");
        }
    }
}
