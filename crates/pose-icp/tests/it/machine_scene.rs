//! The experiment of document [D] with the errors of its machine as it states them.

use nalgebra::{Point3, Vector3};
use pose_icp::{PoseStart, SideTouches, Touch};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::pose_scene::{TIP_MM, center_over, edge, nine_points, random_pose, tip};

/// Positioning accuracy of x, y and z: 6, 6 and 3 µm, by ISO 230-2 the width that holds ±2 σ.
const AXES_MM: [f64; 3] = [6e-3 / 4.0, 6e-3 / 4.0, 3e-3 / 4.0];
/// Repeatability of the probe, ±1 µm: a band, taken as uniform.
const PROBE_MM: f64 = 1e-3;
/// Resolution of every axis.
const STEP_MM: f64 = 1e-3;
/// Each touch is the mean of two readings.
const READINGS: u32 = 2;

/// One experiment.
pub(crate) struct Experiment {
    pub(crate) pose: PoseStart,
    pub(crate) touches: Vec<Touch>,
    pub(crate) side: SideTouches,
}

pub(crate) fn experiment(rng: &mut ChaCha8Rng) -> Experiment {
    let mut pose = random_pose(rng);
    pose.angles.gamma_rad = 0.0;
    let touches = nine_points()
        .iter()
        .map(|&[x, y]| {
            let center_mm = read(&center_over(&pose, x, y, TIP_MM), rng);
            let slope = f64::hypot(x, y) / crate::pose_scene::RADIUS_MM;
            Touch::new(center_mm, sigma_mm(slope))
        })
        .collect();
    let mut edge = edge(&pose, 0.0, rng);
    for side in &mut edge.sides_mm {
        *side = read(side, rng);
    }
    edge.center_mm = read(&edge.center_mm, rng);
    edge.sigma_mm = axis_sigma_mm(0);
    let side = edge.locate(tip(), 0.0).expect("the side touches surround the part");
    Experiment { pose, touches, side }
}

/// Where the eight check points of Table 4 are, in the workpiece frame: on the diagonals, as far
/// out as the touches.
pub(crate) fn check_points() -> Vec<[f64; 2]> {
    let on_diagonal = |radius: f64| {
        let a = radius * std::f64::consts::FRAC_1_SQRT_2;
        [[a, a], [-a, a], [-a, -a], [a, -a]]
    };
    [on_diagonal(20.0), on_diagonal(40.0)].concat()
}

/// A point as the machine shows it: its position is off in the same way at every reading.
fn read(point_mm: &Point3<f64>, rng: &mut ChaCha8Rng) -> Point3<f64> {
    let off: Vector3<f64> = Vector3::from_fn(|k, _| {
        let unit: f64 = StandardNormal.sample(rng);
        AXES_MM[k] * unit
    });
    let mut sum = Vector3::zeros();
    for _ in 0..READINGS {
        let probe = Vector3::from_fn(|_, _| rng.random_range(-PROBE_MM..PROBE_MM));
        sum += (point_mm.coords + off + probe).map(|v| (v / STEP_MM).round() * STEP_MM);
    }
    Point3::from(sum / f64::from(READINGS))
}

fn axis_sigma_mm(axis: usize) -> f64 {
    let uniform = |half_width: f64| half_width * half_width / 3.0;
    let reading = uniform(PROBE_MM) + uniform(0.5 * STEP_MM);
    (AXES_MM[axis].powi(2) + reading / f64::from(READINGS)).sqrt()
}

/// Standard uncertainty of a touch along the normal of a surface of that slope.
fn sigma_mm(slope: f64) -> f64 {
    let stretch = 1.0 + slope * slope;
    ((axis_sigma_mm(2).powi(2) + (slope * axis_sigma_mm(0)).powi(2)) / stretch).sqrt()
}
