//! Parts whose place the touches hardly show: a mirror that is a sphere to 7 µm.

use model_discrepancy::{Closure, Model, Options, Role, State, close_loop};
use nalgebra::{Point3, Vector3};
use pose_icp::{MeasuredTouch, PoseError, PoseModel, PoseOptions, PoseStart, Touch, fit_pose};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::pose_scene::{
    RADIUS_MM, TIP_MM, center_over, paraboloid, random_pose, tip, to_machine, touches,
};

const SIGMA_MM: f64 = 1e-3;

fn options() -> PoseOptions {
    PoseOptions { tip: tip(), ..PoseOptions::default() }
}

/// Sunflower of 46 points out to the rim but two millimetres.
fn spread() -> Vec<[f64; 2]> {
    (0..46)
        .map(|i| {
            let radius = 48.0 * ((f64::from(i) + 0.5) / 46.0).sqrt();
            let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
            [radius * cos, radius * sin]
        })
        .collect()
}

/// Touches of a mirror bent like a saddle, `rim_mm` high at its rim.
fn bent(pose: &PoseStart, rim_mm: f64, rng: &mut ChaCha8Rng) -> Vec<Touch> {
    let saddle = |[x, y]: [f64; 2]| rim_mm * (x * x - y * y + 2.0 * x * y) / 2500.0;
    let up = to_machine(pose, Vector3::z()) - to_machine(pose, Vector3::zeros());
    let at = spread();
    let mut touched = touches(pose, &at, SIGMA_MM, rng);
    for (touch, place) in touched.iter_mut().zip(at) {
        touch.center_mm += up * saddle(place);
    }
    touched
}

fn measured(touches: &[Touch]) -> Vec<MeasuredTouch> {
    let named = |(i, touch): (usize, &Touch)| MeasuredTouch {
        name: format!("P{i}"),
        group: format!("P{i}"),
        role: Role::Fit,
        touch: *touch,
    };
    touches.iter().enumerate().map(named).collect()
}

#[test]
fn a_touch_beyond_the_part_is_refused_wherever_the_part_may_lie() {
    let mut rng = ChaCha8Rng::seed_from_u64(472);
    let pose = random_pose(&mut rng);
    let mut touched = touches(&pose, &spread(), SIGMA_MM, &mut rng);
    touched.push(Touch::new(center_over(&pose, 70.0, 0.0, TIP_MM), SIGMA_MM));
    let error = fit_pose(&paraboloid(), &touched, &pose, &options()).unwrap_err();
    assert!(matches!(error, PoseError::OutsideAperture { index: 46, .. }), "{error}");
    assert!(error.to_string().contains("touch 47"), "{error}");
}

/// Readings of an axis that is 300 ppm long: the matrix says where the machine reads a point.
#[test]
fn the_matrix_takes_points_to_readings_of_a_long_axis() {
    const LONG: f64 = 3e-4;
    let mut rng = ChaCha8Rng::seed_from_u64(475);
    let pose = random_pose(&mut rng);
    let at = spread();
    let true_mm: Vec<Point3<f64>> =
        at.iter().map(|&[x, y]| center_over(&pose, x, y, TIP_MM)).collect();
    let fixed = true_mm.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / 46.0;
    let read = |p: &Point3<f64>| Point3::new(p.x + LONG * (p.x - fixed.x), p.y, p.z);
    let touched: Vec<Touch> = true_mm.iter().map(|p| Touch::new(read(p), 1e-4)).collect();
    let side = crate::pose_scene::edge(&pose, 1e-4, &mut rng).locate(tip(), pose.angles.gamma_rad);
    let options = PoseOptions { lateral: Some(side.unwrap().prior), ..options() };
    let model = PoseModel::new(paraboloid(), measured(&touched), &[], &pose, &options).unwrap();
    let effect = model
        .declared()
        .effects
        .iter()
        .position(|e| e.id == "axis-scale" && e.subject.as_deref() == Some("x"));
    let mut state = State::start(&model);
    // Of the reading, not of the place.
    state.amplitudes[effect.unwrap()][0] = LONG / (1.0 + LONG);
    let matrix = model.reading_from_workpiece(&state);
    let own = model.pose_at(&state).machine_from_workpiece();
    for [x, y] in at {
        let local = Point3::new(x, y, (x * x + y * y) / (2.0 * RADIUS_MM));
        let expected = own * local;
        let found = matrix.transform_point(&local);
        let reference = model.reference_mm();
        let long = expected.x + LONG * (expected.x - reference.x);
        assert!((found - Point3::new(long, expected.y, expected.z)).norm() < 1e-9, "{found}");
    }
    assert!(model.has_reference(&state));
}

/// The whole closure is plain data that estimates are made of.
#[test]
fn a_closure_says_what_its_covariance_is_about() {
    let mut rng = ChaCha8Rng::seed_from_u64(476);
    let pose = random_pose(&mut rng);
    let touched = bent(&pose, 8e-3, &mut rng);
    let model = PoseModel::new(paraboloid(), measured(&touched), &[], &pose, &options()).unwrap();
    let Closure { columns, covariance, jacobian, residuals_after, variance_factor, .. } =
        close_loop(&model, &[], &Options::default()).unwrap();
    assert_eq!(columns.len(), covariance.nrows());
    assert_eq!((jacobian.nrows(), jacobian.ncols()), (residuals_after.len(), columns.len()));
    assert!((0.3..3.0).contains(&variance_factor), "{variance_factor}");
}
