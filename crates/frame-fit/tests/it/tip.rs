//! The tip of a tool from poses of the flange.

use frame_fit::{FrameFitError, KnownDistance, TipModel, TipPose, fit_tip};
use model_discrepancy::{Covariate, Quantity, State, Verdict, check_tangents, close_loop};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

/// 1e3 mm · 2⁻⁵² · the condition of tilts of half a radian, with room.
const EXACT_TOL_MM: f64 = 1e-9;
/// What central differences show, see `check_tangents`.
const TANGENT_TOL: f64 = 1e-7;
const TIP_MM: [f64; 3] = [1.0, -2.0, 133.0];

/// Poses at places 150 mm apart, twelve each, tilted by up to half a radian.
fn poses(seed: u64, places: usize, noise_mm: f64) -> Vec<TipPose> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut poses = Vec::new();
    for k in 0..places {
        let place = Vector3::new(600.0 - 150.0 * k as f64, 40.0 * k as f64, 20.0);
        for _ in 0..12 {
            let turn = Vector3::from_fn(|_, _| rng.random_range(-0.5..0.5));
            let rotation = UnitQuaternion::from_scaled_axis(turn);
            let noise = scene::gauss::<3>(&mut rng) * noise_mm;
            let position_mm = place - rotation * Vector3::from(TIP_MM) + noise;
            poses.push(TipPose { place: format!("P{k}"), position_mm, rotation });
        }
    }
    poses
}

fn labels(poses: &[TipPose]) -> Vec<String> {
    (0..poses.len()).map(|i| format!("pose {i}")).collect()
}

fn known(distance_mm: f64, sigma_mm: f64) -> KnownDistance {
    KnownDistance { from: "P0".into(), to: "P1".into(), distance_mm, sigma_mm }
}

#[test]
fn exact_poses_give_tip_and_places_back() {
    let poses = poses(1, 3, 0.0);
    let apart = 150.0_f64.hypot(40.0);
    for distances in [vec![], vec![known(apart, 0.01)]] {
        let fit = fit_tip(&poses, &distances, Some(0.1)).unwrap();
        assert!((fit.tip_mm - Vector3::from(TIP_MM)).norm() < EXACT_TOL_MM, "{}", fit.tip_mm);
        let second = fit.places[1].1 - Vector3::new(450.0, 40.0, 20.0);
        assert!(second.norm() < EXACT_TOL_MM, "{second}");
        assert_eq!(fit.degrees_of_freedom, 108 - 12 + distances.len());
    }
}

#[test]
fn the_covariance_predicts_the_scatter() {
    const TRIALS: u32 = 200;
    // Normalised squares of the tip, three degrees of freedom each.
    let square = |seed: u64| {
        let fit = fit_tip(&poses(seed, 2, 0.05), &[], Some(0.05)).unwrap();
        let error = fit.tip_mm - Vector3::from(TIP_MM);
        let covariance = fit.covariance.fixed_view::<3, 3>(0, 0).into_owned();
        error.dot(&(covariance.try_inverse().unwrap() * error))
    };
    let mean = (0..TRIALS).map(|t| square(u64::from(100 + t))).sum::<f64>() / f64::from(TRIALS);
    // The mean of 200 has a standard deviation of √(6/200).
    let bound = 4.0 * (6.0 / f64::from(TRIALS)).sqrt();
    assert!((mean - 3.0).abs() < bound, "{mean}");
}

#[test]
fn a_known_distance_counts_by_its_uncertainty() {
    let poses = poses(2, 2, 0.05);
    let found = |sigma_mm: f64| {
        let fit = fit_tip(&poses, &[known(160.0, sigma_mm)], Some(0.05)).unwrap();
        fit.distance_errors_mm[0]
    };
    assert!(found(1e-5).abs() < 1e-4);
    let free = 150.0_f64.hypot(40.0) - 160.0;
    assert!((found(1e3) - free).abs() < 0.1, "{}", found(1e3));
}

#[test]
fn a_flange_that_turned_about_one_direction_names_it() {
    let mut poses = poses(3, 1, 0.0);
    let axis = Vector3::new(0.6, 0.0, 0.8);
    for (i, pose) in poses.iter_mut().enumerate() {
        pose.rotation = UnitQuaternion::from_scaled_axis(axis * 0.2 * i as f64);
    }
    let error = fit_tip(&poses, &[], None).unwrap_err();
    let FrameFitError::TipFree { direction, .. } = error else { panic!("{error}") };
    assert!(Vector3::from(direction).cross(&axis).norm() < 1e-6, "{direction:?}");
}

#[test]
fn bad_input_is_an_error() {
    let good = poses(4, 2, 0.01);
    let mut bad = good.clone();
    bad[5].position_mm.y = f64::NAN;
    let error = fit_tip(&bad, &[], None).unwrap_err();
    assert_eq!(error, FrameFitError::InvalidPose { index: 5 });
    let to_nowhere = KnownDistance { to: "P9".into(), ..known(1.0, 0.1) };
    let to_itself = KnownDistance { to: "P0".into(), ..known(1.0, 0.1) };
    for distance in [to_nowhere, to_itself, known(-1.0, 0.1), known(1.0, f64::NAN)] {
        let error = fit_tip(&good, &[distance], None).unwrap_err();
        assert_eq!(error, FrameFitError::InvalidDistance { index: 0 });
    }
    for n in 0..3 {
        assert!(fit_tip(&good[..n], &[], Some(0.1)).is_err(), "{n}");
    }
}

#[test]
fn tangents_agree_with_differences() {
    let poses = poses(5, 3, 0.05);
    let distances = [known(155.0, 0.1)];
    let labels = labels(&poses);
    let model = TipModel::new(&poses, &labels, &labels, &distances, None, &[]).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut state = State::start(&model);
    state.base.iter_mut().for_each(|v| *v = rng.random_range(-0.1..0.1));
    for amplitude in &mut state.amplitudes {
        amplitude.iter_mut().for_each(|v| *v = rng.random_range(-1e-3..1e-3));
    }
    let worst = check_tangents(&model, &state);
    assert!(worst < TANGENT_TOL, "{worst:.1e}");
}

#[test]
fn a_tip_that_slipped_between_two_places_is_named() {
    let mut poses = poses(7, 4, 0.01);
    for pose in &mut poses[24..] {
        let slip = pose.rotation * Vector3::new(0.15, -0.1, 0.0);
        pose.position_mm -= slip;
    }
    let labels = labels(&poses);
    let model = TipModel::new(&poses, &labels, &labels, &[], Some(0.01), &[]).unwrap();
    let options = model_discrepancy::Options { nested: false, ..Default::default() };
    let closure = close_loop(&model, &model.coordinates(), &options).unwrap();
    assert_eq!(closure.verdict, Verdict::Explained);
    assert_eq!(closure.steps.len(), 1);
    let step = &closure.steps[0];
    assert_eq!(step.effect, "tip-slip");
    assert_eq!(step.subject.as_deref(), Some("from pose 24 on"));
    // The residual shrinks by what the flange went back; five standard uncertainties.
    for (parameter, slip) in step.parameters.iter().zip([-0.15, 0.1, 0.0]) {
        assert!((parameter.value - slip).abs() < 5.0 * parameter.std, "{parameter:?}");
    }
}

/// A spindle warms up while three places are touched in turn, four times over: the tool grows along
/// its axis, evenly or until it comes to rest. What the flange is moved by is the growth, backwards.
#[test]
fn a_tool_that_grows_is_named_and_its_growth_found() {
    const GROWTH_MM: f64 = 0.08;
    const STEP_S: f64 = 30.0;
    let options = model_discrepancy::Options { nested: false, ..Default::default() };
    for (comes, subject) in
        [((|t| t) as fn(f64) -> f64, "tip"), (|t: f64| 1.0 - (-6.0 * t).exp(), "tip, settling")]
    {
        let mut poses = poses(9, 3, 0.01);
        let n = poses.len();
        poses = (0..n).map(|i| poses[12 * (i % 3) + i / 3].clone()).collect();
        for (i, pose) in poses.iter_mut().enumerate() {
            let growth_mm = GROWTH_MM * comes(i as f64 / (n - 1) as f64);
            pose.position_mm -= pose.rotation * Vector3::new(0.0, 0.0, growth_mm);
        }
        let labels = labels(&poses);
        let time = Covariate::coordinate(
            "time_s",
            Quantity::Time,
            (0..n).map(|i| STEP_S * i as f64).collect(),
        );
        let model =
            TipModel::new(&poses, &labels, &labels, &[], Some(0.01), std::slice::from_ref(&time))
                .unwrap();
        let mut covariates = model.coordinates();
        covariates.push(time);
        let closure = close_loop(&model, &covariates, &options).unwrap();
        assert_eq!(closure.verdict, Verdict::Explained, "{subject}");
        assert_eq!(closure.steps.len(), 1, "{subject}: {:?}", closure.steps);
        let step = &closure.steps[0];
        assert_eq!((step.effect.as_str(), step.subject.as_deref()), ("drift", Some(subject)));
        let whole = if subject == "tip" { STEP_S * (n - 1) as f64 / 3600.0 } else { 1.0 };
        let along = &step.parameters[2];
        let off = along.value * whole + GROWTH_MM;
        assert!(off.abs() < 5.0 * along.std * whole, "{subject}: {along:?}");
    }
}
