//! The exact pose: recovery, convergence, uncertainty, weak directions.

use nalgebra::{Isometry3, Point2, Vector3};
use pose_icp::{
    LateralPrior, Noise, PoseOptions, PoseParameter, PoseStart, Tip, TipSide, Touch, fit_pose,
    height_at, start_from_touches,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::pose_scene::{
    DIAMETER_MM, TIP_MM, center_over, edge, nine_points, paraboloid, random_pose, tip, touches,
};

/// Coordinates of 1e3 mm carry 1e-13 mm; the weakest direction magnifies by some 3e3, and the
/// search stops when a step is worth less than 1e-12 mm of distance.
const EXACT_MM: f64 = 1e-7;

fn apart(a: &PoseStart, b: &PoseStart) -> (f64, f64) {
    let between: Isometry3<f64> = a.machine_from_workpiece().inverse() * b.machine_from_workpiece();
    (between.translation.vector.norm(), between.rotation.angle())
}

/// A start off by up to 5 mm in each coordinate and 10 mrad in each tilt.
fn displaced(pose: &PoseStart, rng: &mut ChaCha8Rng) -> PoseStart {
    let mut start = *pose;
    start.position_mm += Vector3::from_fn(|_, _| rng.random_range(-5.0..5.0));
    start.angles.alpha_rad += rng.random_range(-10e-3..10e-3);
    start.angles.beta_rad += rng.random_range(-10e-3..10e-3);
    start
}

#[test]
fn nine_exact_touches_give_the_pose_from_every_start() {
    let mut rng = ChaCha8Rng::seed_from_u64(401);
    let part = paraboloid();
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    for _ in 0..10_000 {
        let pose = random_pose(&mut rng);
        let touches: Vec<Touch> = nine_points()
            .iter()
            .map(|&[x, y]| Touch::new(center_over(&pose, x, y, TIP_MM), 1e-3))
            .collect();
        let fit = fit_pose(&part, &touches, &displaced(&pose, &mut rng), &options).unwrap();
        let (mm, rad) = apart(&fit.pose, &pose);
        assert!(mm < EXACT_MM && rad * DIAMETER_MM < EXACT_MM, "off by {mm:e} mm, {rad:e} rad");
    }
}

#[test]
fn noisy_touches_with_side_touches_converge_from_every_start_to_one_pose() {
    let mut rng = ChaCha8Rng::seed_from_u64(402);
    let part = paraboloid();
    for _ in 0..2_000 {
        let pose = random_pose(&mut rng);
        let touches = touches(&pose, &nine_points(), 1e-3, &mut rng);
        let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
        let lateral = Some(side.prior);
        let options = PoseOptions { tip: tip(), lateral, ..PoseOptions::default() };
        let near = fit_pose(&part, &touches, &pose, &options).unwrap();
        let far = fit_pose(&part, &touches, &displaced(&pose, &mut rng), &options).unwrap();
        // Each search ends within 1e-6 of a standard uncertainty, here some micrometres.
        let (mm, _) = apart(&near.pose, &far.pose);
        assert!(mm < EXACT_MM, "two minima, {mm:e} mm apart");
    }
}

/// Without side touches the noise makes several minima along the weak directions; every one is
/// a pose that the touches cannot tell from the true one.
#[test]
fn noisy_touches_alone_converge_from_every_start_to_a_pose_as_good_as_the_true_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(409);
    let part = paraboloid();
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    for _ in 0..2_000 {
        let pose = random_pose(&mut rng);
        let touches = touches(&pose, &nine_points(), 1e-3, &mut rng);
        let fit = fit_pose(&part, &touches, &displaced(&pose, &mut rng), &options).unwrap();
        let squares: f64 = fit.residuals_mm.iter().map(|r| (r / 1e-3).powi(2)).sum();
        // χ² of 9 values at the true pose exceeds 40 once in 1e5.
        assert!(squares < 40.0, "{squares}");
    }
}

/// Share of standardised errors inside ±1.96, of `n`; three standard errors of a binomial 0.95.
fn covers(hits: usize, n: usize) -> bool {
    (93 * n..=97 * n).contains(&(100 * hits))
}

#[test]
fn the_stated_uncertainty_covers_heights_and_pose_with_side_touches() {
    let mut rng = ChaCha8Rng::seed_from_u64(403);
    let part = paraboloid();
    let n = 1_000;
    let (mut heights, mut inside, mut worst) = (0, [0; 5], Vec::new());
    for _ in 0..n {
        let pose = random_pose(&mut rng);
        let touches = touches(&pose, &nine_points(), 1e-3, &mut rng);
        let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
        let options =
            PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
        let fit = fit_pose(&part, &touches, &side.start, &options).unwrap();
        assert!(fit.weak_directions.is_empty(), "{:?}", fit.weak_directions);
        let sigmas = fit.standard_uncertainties().unwrap();
        let errors = [
            fit.pose.position_mm.x - pose.position_mm.x,
            fit.pose.position_mm.y - pose.position_mm.y,
            fit.pose.position_mm.z - pose.position_mm.z,
            fit.pose.angles.alpha_rad - pose.angles.alpha_rad,
            fit.pose.angles.beta_rad - pose.angles.beta_rad,
        ];
        for (k, error) in errors.iter().enumerate() {
            inside[k] += usize::from(error.abs() < 1.96 * sigmas[k]);
        }
        // A check point between the rings.
        let at = center_over(&pose, 21.0, 24.0, TIP_MM);
        let height = height_at(&part, &fit, tip(), at.x, at.y, at.z + 0.1).unwrap();
        let error = (height.z_mm - at.z).abs();
        heights += usize::from(error < 1.96 * height.sigma_mm.unwrap());
        worst.push(error);
    }
    assert!(covers(heights, n), "heights {heights} of {n}");
    assert!(inside.iter().all(|&hits| covers(hits, n)), "{inside:?} of {n}");
    worst.sort_by(f64::total_cmp);
    assert!(worst[n * 99 / 100] < 2e-3, "99 % of heights within {} mm", worst[n * 99 / 100]);
}

#[test]
fn without_side_touches_tilt_and_decentre_are_named_while_heights_stay_good() {
    let mut rng = ChaCha8Rng::seed_from_u64(404);
    let part = paraboloid();
    let mut pose = random_pose(&mut rng);
    pose.angles.gamma_rad = 0.0;
    let touches = touches(&pose, &nine_points(), 1e-3, &mut rng);
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    let fit = fit_pose(&part, &touches, &pose, &options).unwrap();
    assert_eq!(fit.weak_directions.len(), 2);
    let mut tilts = Vec::new();
    for weak in &fit.weak_directions {
        let parameters: Vec<_> = weak.components.iter().map(|c| c.parameter).collect();
        assert!(parameters.iter().any(|p| p.is_angle()), "{parameters:?}");
        assert!(
            parameters.iter().any(|p| matches!(p, PoseParameter::X | PoseParameter::Y)),
            "{parameters:?}"
        );
        tilts.extend(parameters);
    }
    assert!(tilts.contains(&PoseParameter::Alpha) && tilts.contains(&PoseParameter::Beta));
    // The figures of the specification: 12 mrad and 6 mm.
    let sigmas = fit.standard_uncertainties().unwrap();
    assert!((3.0..9.0).contains(&sigmas[0]) && (6e-3..18e-3).contains(&sigmas[4]), "{sigmas}");
    let correlation = fit.covariance[(0, 4)] / (sigmas[0] * sigmas[4]);
    assert!(correlation.abs() > 0.999_99, "{correlation}");
    let at = center_over(&pose, 20.0, 20.0, TIP_MM);
    let height = height_at(&part, &fit, tip(), at.x, at.y, at.z).unwrap();
    assert!(height.sigma_mm.unwrap() < 1e-3 && (height.z_mm - at.z).abs() < 4e-3);
}

#[test]
fn held_parameters_keep_their_values_exactly() {
    let mut rng = ChaCha8Rng::seed_from_u64(405);
    let pose = random_pose(&mut rng);
    let touches = touches(&pose, &nine_points(), 1e-3, &mut rng);
    let held = vec![PoseParameter::X, PoseParameter::Y, PoseParameter::Gamma];
    let options = PoseOptions { tip: tip(), held, ..PoseOptions::default() };
    let fit = fit_pose(&paraboloid(), &touches, &pose, &options).unwrap();
    assert_eq!(fit.pose.position_mm.xy(), pose.position_mm.xy());
    assert_eq!(fit.pose.angles.gamma_rad.to_bits(), pose.angles.gamma_rad.to_bits());
    let sigmas = fit.standard_uncertainties().unwrap();
    assert!([0, 1, 5].iter().all(|&k| sigmas[k] == 0.0));
    assert!(sigmas[3] > 0.0 && fit.degrees_of_freedom == 6);
}

#[test]
fn uncertainties_follow_the_declared_noise_and_the_residual_where_it_is_estimated() {
    let mut rng = ChaCha8Rng::seed_from_u64(406);
    let pose = random_pose(&mut rng);
    let mut touches = touches(&pose, &nine_points(), 1e-3, &mut rng);
    let side = edge(&pose, 1e-3, &mut rng).locate(tip(), pose.angles.gamma_rad).unwrap();
    let held = vec![PoseParameter::X, PoseParameter::Y, PoseParameter::Gamma];
    let options = PoseOptions { tip: tip(), held, ..PoseOptions::default() };
    let small = fit_pose(&paraboloid(), &touches, &side.start, &options).unwrap();
    for touch in &mut touches {
        touch.sigma_mm = 1.0;
    }
    let options = PoseOptions { noise: Noise::Estimated, ..options };
    let unit = fit_pose(&paraboloid(), &touches, &side.start, &options).unwrap();
    let expected = small.standard_uncertainties().unwrap() * small.variance_factor.unwrap().sqrt();
    let got = unit.standard_uncertainties().unwrap();
    assert!((expected - got).amax() < 1e-6 * expected.amax());
}

#[test]
fn a_dome_is_touched_from_above_and_a_bowl_from_below() {
    let mut rng = ChaCha8Rng::seed_from_u64(407);
    let pose = random_pose(&mut rng);
    let shape = geometry::AsphereShape::on_axis(-RADIUS, 0.4, vec![2e-8], 60.0);
    let sag = |x: f64, y: f64| {
        let s = x * x + y * y;
        let c = -1.0 / RADIUS;
        c * s / (1.0 + (1.0 - 1.4 * c * c * s).sqrt()) + 2e-8 * s * s
    };
    let part = pose_icp::Part::asphere(shape).unwrap();
    for (side, sign) in [(TipSide::Above, 1.0), (TipSide::Below, -1.0)] {
        let tip = Tip { radius_mm: 2.0, side };
        let touches: Vec<Touch> = (0..24)
            .map(|i| {
                let angle = 2.4 * f64::from(i);
                let radius = 28.0 * (f64::from(i) / 24.0).sqrt();
                let (x, y) = (radius * angle.cos(), radius * angle.sin());
                // The normal by central differences, good to 1e-9.
                let step = 1e-4;
                let slope_x = (sag(x + step, y) - sag(x - step, y)) / (2.0 * step);
                let slope_y = (sag(x, y + step) - sag(x, y - step)) / (2.0 * step);
                let normal = Vector3::new(-slope_x, -slope_y, 1.0).normalize();
                let local = Vector3::new(x, y, sag(x, y)) + normal * (sign * 2.0);
                Touch::new(crate::pose_scene::to_machine(&pose, local), 1e-3)
            })
            .collect();
        let options = PoseOptions { tip, ..PoseOptions::default() };
        let start = start_from_touches(&part, &touches, tip, pose.angles.gamma_rad).unwrap();
        let fit = fit_pose(&part, &touches, &start, &options).unwrap();
        let (mm, rad) = apart(&fit.pose, &pose);
        // Normals good to 1e-9 over 2 mm, magnified by the tilt/decentre pair.
        assert!(mm < 1e-5 && rad < 1e-6, "{side:?}: {mm:e} mm, {rad:e} rad");
    }
}

const RADIUS: f64 = 80.0;

#[test]
fn a_prior_moves_the_axis_where_it_passes_the_height_of_the_side_touches() {
    let mut rng = ChaCha8Rng::seed_from_u64(408);
    let pose = random_pose(&mut rng);
    let touches = touches(&pose, &nine_points(), 0.0, &mut rng);
    let axis = pose.machine_from_workpiece().rotation * Vector3::z();
    let at_z_mm = pose.position_mm.z - 50.0;
    let along = (at_z_mm - pose.position_mm.z) / axis.z;
    let passes = pose.position_mm + axis * along;
    let prior = LateralPrior {
        at_z_mm,
        center_mm: Point2::new(passes.x, passes.y),
        covariance_mm2: nalgebra::Matrix2::new(1e-8, 3e-9, 3e-9, 2e-8),
    };
    let options = PoseOptions { tip: tip(), lateral: Some(prior), ..PoseOptions::default() };
    let fit = fit_pose(&paraboloid(), &touches, &displaced(&pose, &mut rng), &options).unwrap();
    let (mm, _) = apart(&fit.pose, &pose);
    assert!(mm < EXACT_MM, "{mm:e}");
    assert!(fit.standard_uncertainties().unwrap()[0] < 1e-3);
}
