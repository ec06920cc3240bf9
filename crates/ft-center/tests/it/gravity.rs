//! Free-hanging tools: exactness, uncertainty and what poses cannot tell.

use ft_center::{
    FtCenterError, GravityModel, GravityOptions, Noise, StaticPose, Table, calibrate_gravity,
};
use geometry::Wrench;
use model_discrepancy::{Covariate, Effect, Model, Options, Quantity, State, Step, close_loop};
use nalgebra::{Point3, SVector, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::simulator::normal;

/// Round-off of a fit over 12 N: 12 N · 2⁻⁵² · 100.
const EXACT_TOL_N: f64 = 1e-12;

const WEIGHT_N: f64 = 12.0;
const BIAS_N: Vector3<f64> = Vector3::new(1.5, -2.0, 4.0);
const BIAS_NMM: Vector3<f64> = Vector3::new(30.0, -12.0, 55.0);

fn arm() -> Point3<f64> {
    Point3::new(3.0, -5.0, 48.0)
}

pub(crate) fn orientation(rng: &mut ChaCha8Rng) -> UnitQuaternion<f64> {
    let axis = Vector3::from_fn(|_, _| rng.random_range(-1.8..1.8));
    UnitQuaternion::from_scaled_axis(axis)
}

/// Poses of a tool under gravity along −z; `fault` spoils the reading.
pub(crate) fn poses(
    n: usize,
    noise: &Noise,
    rng: &mut ChaCha8Rng,
    fault: impl Fn(usize, &mut Wrench),
) -> Vec<StaticPose> {
    (0..n)
        .map(|i| {
            let base_from_sensor = orientation(rng);
            // The weight hangs from the tool's centre of gravity, in sensor axes.
            let weight = base_from_sensor.inverse() * Vector3::new(0.0, 0.0, -WEIGHT_N);
            let moment = Vector3::new(
                arm().y * weight.z - arm().z * weight.y,
                arm().z * weight.x - arm().x * weight.z,
                arm().x * weight.y - arm().y * weight.x,
            );
            let mut wrench = Wrench { force_n: weight, torque_nmm: moment };
            fault(i, &mut wrench);
            wrench.force_n += BIAS_N + Vector3::from_fn(|_, _| noise.force_n * normal(rng));
            wrench.torque_nmm += BIAS_NMM + Vector3::from_fn(|_, _| noise.moment_nmm * normal(rng));
            StaticPose { name: format!("pose {i}"), base_from_sensor, wrench }
        })
        .collect()
}

const SILENT: Noise = Noise { force_n: 0.0, moment_nmm: 0.0 };
const NOISE: Noise = Noise { force_n: 0.05, moment_nmm: 2.0 };

#[test]
fn without_noise_it_is_exact() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let poses = poses(6, &SILENT, &mut rng, |_, _| {});
    let found = calibrate_gravity(&poses, &GravityOptions::default()).unwrap();
    assert!((found.weight_n - WEIGHT_N).abs() < EXACT_TOL_N);
    assert!((found.bias.force_n - BIAS_N).norm() < EXACT_TOL_N);
    // Moments are 50 times as large, lengths are moments over 12 N.
    assert!((found.bias.torque_nmm - BIAS_NMM).norm() < 50.0 * EXACT_TOL_N);
    assert!((found.center_of_gravity_mm - arm()).norm() < 50.0 * EXACT_TOL_N);
    assert!(found.line_miss_mm.iter().all(|d| *d < 50.0 * EXACT_TOL_N));
    assert_eq!(found.degrees_of_freedom, 26);
}

#[test]
fn covariance_predicts_the_scatter() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let trials = 1000;
    let mut sum = 0.0;
    for _ in 0..trials {
        let poses = poses(12, &NOISE, &mut rng, |_, _| {});
        let options = GravityOptions { noise: Some(NOISE), ..GravityOptions::default() };
        let found = calibrate_gravity(&poses, &options).unwrap();
        let mut error = SVector::<f64, 10>::zeros();
        error.fixed_rows_mut::<3>(0).copy_from(&(found.bias.force_n - BIAS_N));
        error.fixed_rows_mut::<3>(3).copy_from(&(found.bias.torque_nmm - BIAS_NMM));
        error[6] = found.weight_n - WEIGHT_N;
        error.fixed_rows_mut::<3>(7).copy_from(&(found.center_of_gravity_mm - arm()));
        sum += error.dot(&found.covariance.cholesky().unwrap().solve(&error));
    }
    let mean = sum / f64::from(trials);
    // χ² of 10 degrees of freedom over 1000 trials: standard deviation √(20/1000) = 0.14; 4 of
    // them, and 1 % for the curvature of r = u/W.
    assert!((mean - 10.0).abs() < 0.66, "mean normalised squared error {mean}");
}

#[test]
fn estimated_noise_is_that_of_the_readings() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let poses = poses(400, &NOISE, &mut rng, |_, _| {});
    let found = calibrate_gravity(&poses, &GravityOptions::default()).unwrap();
    // 1200 readings: 2 % standard deviation; 4 of them.
    assert!((found.noise.force_n / NOISE.force_n - 1.0).abs() < 0.08);
    assert!((found.noise.moment_nmm / NOISE.moment_nmm - 1.0).abs() < 0.08);
    let miss = found.line_miss_mm.iter().map(|d| d * d).sum::<f64>() / 400.0;
    // Moment noise over the weight, two components across it, and force noise times the arm.
    let expected =
        2.0 * (NOISE.moment_nmm.powi(2) + (NOISE.force_n * 48.0).powi(2)) / WEIGHT_N.powi(2);
    assert!((miss / expected - 1.0).abs() < 0.25, "{miss} {expected}");
}

#[test]
fn poses_that_do_not_tell_are_errors() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut list = poses(5, &SILENT, &mut rng, |_, _| {});
    let one = list[0].clone();
    let free =
        |poses: &[StaticPose]| calibrate_gravity(poses, &GravityOptions::default()).unwrap_err();
    assert_eq!(free(&[]), FtCenterError::Empty { of: Table::Poses });
    assert!(matches!(
        free(&vec![one.clone(); 9]),
        FtCenterError::PosesNotEnough { parameter: "the weight", .. }
    ));
    // Turned about gravity only: the direction of gravity never changes.
    let turned: Vec<_> = (0..9)
        .map(|i| {
            let about = UnitQuaternion::from_scaled_axis(Vector3::z() * f64::from(i));
            StaticPose { base_from_sensor: about, ..one.clone() }
        })
        .collect();
    assert!(matches!(free(&turned), FtCenterError::PosesNotEnough { .. }));
    // Two directions of gravity leave the centre of gravity free along the line they span.
    let tipped: Vec<_> = (0..9)
        .map(|i| {
            let about = UnitQuaternion::from_scaled_axis(Vector3::x() * f64::from(i % 2));
            StaticPose { base_from_sensor: about, ..one.clone() }
        })
        .collect();
    assert!(matches!(
        free(&tipped),
        FtCenterError::PosesNotEnough { parameter: "the centre of gravity", .. }
    ));
    list[3].wrench.force_n.y = f64::NAN;
    assert_eq!(free(&list), FtCenterError::NotFinite { index: 3 });
    for p in &mut list {
        p.wrench = Wrench { force_n: BIAS_N, torque_nmm: BIAS_NMM };
    }
    assert!(matches!(free(&list), FtCenterError::NoWeight { .. }));
}

#[test]
fn the_loop_names_a_drifting_zero() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let poses = poses(40, &NOISE, &mut rng, |i, w| {
        w.force_n += Vector3::new(0.0, 0.3, -0.8) * (i as f64 / 39.0);
    });
    let model = GravityModel::new(&poses, &GravityOptions::default(), &[]).unwrap();
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    let step = &closure.steps[0];
    assert_eq!((step.effect.as_str(), step.subject.as_deref()), ("bias-drift", Some("force")));
    assert_eq!(closure.steps.len(), 1);
    assert!((step.parameters[2].value + 0.8).abs() < 4.0 * step.parameters[2].std);
    assert!(closure.after.held_out_rms < 0.6 * closure.before.held_out_rms);
    let calibration = model.calibration(&closure.state, &closure.covariance);
    assert!((calibration.weight_n - WEIGHT_N).abs() < 0.05);
    let declared = calibrate_gravity(&poses, &GravityOptions::default()).unwrap();
    let rms = |r: &[Wrench]| r.iter().map(|w| w.force_n.norm_squared()).sum::<f64>();
    assert!(rms(&calibration.residuals) < 0.3 * rms(&declared.residuals));
}

/// Names of the steps of a loop on forty poses whose zero moves by a force and a moment at each share
/// of the series, and the error on unseen poses before and after.
fn steps_of(zero: impl Fn(f64) -> Wrench) -> (Vec<String>, [f64; 2]) {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let poses = poses(40, &NOISE, &mut rng, |i, w| *w += zero(i as f64 / 39.0));
    let options = GravityOptions { noise: Some(NOISE), ..GravityOptions::default() };
    let model = GravityModel::new(&poses, &options, &[]).unwrap();
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    let name = |s: &Step| format!("{} [{}]", s.effect, s.subject.as_deref().unwrap_or_default());
    let errors = [closure.before.held_out_rms, closure.after.held_out_rms];
    (closure.steps.iter().map(name).collect(), errors)
}

#[test]
fn a_zero_that_comes_to_rest_is_a_settling_drift() {
    let force_n = Vector3::new(0.4, 0.0, -1.2);
    let (names, [before, after]) = steps_of(|share| {
        Wrench { force_n, torque_nmm: Vector3::zeros() } * (1.0 - (-share / 0.12).exp())
    });
    assert_eq!(names, ["bias-drift [force, settling]"]);
    assert!(after < 0.5 * before);
}

#[test]
fn a_zero_that_moved_in_a_pause_is_an_interrupted_drift() {
    let (rate, jump) = (Vector3::new(0.0, 0.2, -1.5), Vector3::new(0.3, 0.0, 0.7));
    let (names, [before, after]) = steps_of(|share| {
        let force_n = if share < 0.55 { rate * share } else { rate * 0.55 + jump };
        Wrench { force_n, torque_nmm: Vector3::zeros() }
    });
    assert_eq!(names, ["bias-drift [force, interrupted]"]);
    assert!(after < 0.5 * before);
}

#[test]
fn the_loop_names_unequal_gains() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let poses = poses(40, &NOISE, &mut rng, |_, w| w.force_n.x *= 1.04);
    let model = GravityModel::new(&poses, &GravityOptions::default(), &[]).unwrap();
    let closure = close_loop(&model, &model.covariates(), &Options::default()).unwrap();
    let named: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    assert_eq!(named, ["force-gain"], "{:#?}", closure.steps);
    assert_eq!(model.declared().layout.unit, "N");
}

/// Bias, weight and centre of gravity are told with what they leave out.
#[test]
fn an_answer_says_when_it_holds() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let poses = poses(12, &NOISE, &mut rng, |_, _| {});
    let warm = (0..12).map(|i| 20.0 + f64::from(i)).collect();
    let columns = [Covariate::recorded("cell_c", Quantity::Temperature, warm)];
    let model = GravityModel::new(&poses, &GravityOptions::default(), &columns).unwrap();
    assert!(model.conditions(&State::start(&model)).is_empty());
    let names = &model.declared().effects;
    let said = |id: &str, driver: Option<&str>| {
        let is_it = |e: &Effect| e.id == id && (driver.is_none() || e.driver.as_deref() == driver);
        let effect = names.iter().position(is_it).unwrap();
        let mut at = State::start(&model);
        at.amplitudes[effect][0] = 1.0;
        model.conditions(&at)
    };
    let rest = "is in the corrections of the poses";
    assert_eq!(
        said("temperature", Some("cell_c")),
        [format!("the bias holds at cell_c = 20 °C; its change beyond {rest}")]
    );
    assert_eq!(
        said("bias-drift", None),
        [format!("the bias is that of the first pose; its drift {rest}")]
    );
    assert_eq!(
        said("crosstalk", None),
        [format!("weight and centre of gravity are those without crosstalk, whose part {rest}")]
    );
}
