//! A tracer and a rotary axis, simulated without the crate's own geometry.

use nalgebra::{Matrix3, Point3, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use tracker_lm::{Approach, AxisLetter, Mount, Range, RotaryAxis, Station, Step, Survey};

/// What to simulate; lengths in mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub letter: AxisLetter,
    pub stations: usize,
    pub mounts: usize,
    pub angles: usize,
    /// Half of the arc, degrees.
    pub half_arc_deg: f64,
    /// Standard deviation of a displacement.
    pub noise_mm: f64,
    /// How far stations stand from their nominal places, per coordinate.
    pub stations_off_mm: f64,
    /// How far reflectors are from theirs.
    pub mounts_off_mm: f64,
    /// Size of the errors of the axis, displacement.
    pub error_mm: f64,
    /// Size of the errors of the axis, rotation.
    pub error_rad: f64,
    /// Whether every angle is met from both sides.
    pub both_ways: bool,
    /// Whether the axis goes through its angles once more after that.
    pub once_more: bool,
    /// Whether each lock has a dead path of its own.
    pub per_lock: bool,
    /// Share of readings that are missing.
    pub missing: f64,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            letter: AxisLetter::B,
            stations: 6,
            mounts: 4,
            angles: 25,
            half_arc_deg: 90.0,
            noise_mm: 5e-4,
            stations_off_mm: 4e-3,
            mounts_off_mm: 0.3,
            error_mm: 5e-3,
            error_rad: 20e-6,
            both_ways: false,
            once_more: false,
            per_lock: true,
            missing: 0.0,
        }
    }
}

/// A survey and what is true of it.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub survey: Survey,
    pub stations_mm: Vec<Vector3<f64>>,
    pub mounts_mm: Vec<Vector3<f64>>,
    /// Per angle, `[x y z a b c]`, relative to the first.
    pub errors: Vec<Vector6<f64>>,
}

/// Rotation about a unit vector, by Rodrigues' formula.
pub(crate) fn rodrigues(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let cross = Matrix3::new(0.0, -axis.z, axis.y, axis.z, 0.0, -axis.x, -axis.y, axis.x, 0.0);
    Matrix3::identity() + cross * angle.sin() + cross * cross * (2.0 * (angle / 2.0).sin().powi(2))
}

fn small_rotation(vector: &Vector3<f64>) -> Matrix3<f64> {
    let angle = vector.norm();
    if angle == 0.0 { Matrix3::identity() } else { rodrigues(&(vector / angle), angle) }
}

pub(crate) fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn random_vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| gaussian(rng))
}

/// Places of the tracer over 0.8 × 0.8 × 0.5 m, about the middle of which the axis turns.
const STATIONS: [[f64; 3]; 8] = [
    [0.05, 0.08, 0.05],
    [0.95, 0.10, 0.15],
    [0.15, 0.92, 0.10],
    [0.88, 0.90, 0.80],
    [0.10, 0.12, 0.95],
    [0.92, 0.15, 0.85],
    [0.12, 0.88, 0.90],
    [0.55, 0.45, 0.02],
];
/// Reflectors: azimuth in degrees, radius and height in mm.
const MOUNTS: [[f64; 3]; 4] =
    [[-90.0, 150.0, -60.0], [-35.0, 210.0, 70.0], [-140.0, 180.0, 40.0], [-75.0, 250.0, -20.0]];

pub(crate) fn simulate(plan: &Plan, seed: u64) -> Scene {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let unit = match plan.letter {
        AxisLetter::A => Vector3::x(),
        AxisLetter::B => Vector3::y(),
        AxisLetter::C => Vector3::z(),
    };
    let direction = (unit + random_vector(&mut rng) * 1e-3).normalize();
    let origin = Vector3::new(400.0, 400.0, 750.0) + random_vector(&mut rng) * 5.0;
    let stations_mm: Vec<_> = STATIONS[..plan.stations]
        .iter()
        .map(|s| {
            let place = Vector3::from(*s) + Vector3::from_fn(|_, _| rng.random_range(-0.05..0.05));
            place.component_mul(&Vector3::new(800.0, 800.0, 500.0))
        })
        .collect();
    let across = unit.yzx();
    let up = unit.cross(&across);
    let mounts_mm: Vec<_> = MOUNTS[..plan.mounts]
        .iter()
        .map(|[azimuth, radius, height]| {
            let azimuth = azimuth.to_radians() + rng.random_range(-0.1..0.1);
            let radius = radius + rng.random_range(-5.0..5.0);
            let height = height + rng.random_range(-5.0..5.0);
            across * (radius * azimuth.cos()) + up * (radius * azimuth.sin()) + unit * height
        })
        .collect();
    let angles = angles(plan);
    let errors = errors(plan, &angles, &mut rng);

    let mut order: Vec<(usize, Option<Approach>)> =
        (0..plan.angles).map(|k| (k, plan.both_ways.then_some(Approach::Positive))).collect();
    if plan.both_ways {
        order.extend((0..plan.angles).rev().map(|k| (k, Some(Approach::Negative))));
    }
    if plan.once_more {
        order.extend((0..plan.angles).map(|k| (k, Some(Approach::Positive))));
    }
    let dead: Vec<Vec<f64>> = (0..plan.stations)
        .map(|_| {
            let one = rng.random_range(50.0..150.0);
            let own = |rng: &mut ChaCha8Rng| rng.random_range(50.0..150.0);
            (0..plan.mounts).map(|_| if plan.per_lock { own(&mut rng) } else { one }).collect()
        })
        .collect();
    let mut ranges = Vec::new();
    for (step, (k, _)) in order.iter().enumerate() {
        let rotation = rodrigues(&direction, angles[*k]);
        let error = &errors[*k];
        let tilt = small_rotation(&error.fixed_rows::<3>(3).into_owned());
        for (mount, body) in mounts_mm.iter().enumerate() {
            let target = origin + error.fixed_rows::<3>(0) + tilt * (rotation * body);
            for (station, place) in stations_mm.iter().enumerate() {
                let noise = plan.noise_mm * gaussian(&mut rng);
                if rng.random_range(0.0..1.0) < plan.missing {
                    continue;
                }
                let displacement_mm = (target - place).norm() - dead[station][mount] + noise;
                ranges.push(Range { station, mount, step, displacement_mm });
            }
        }
    }
    let mut nominal =
        |truth: &Vector3<f64>, off: f64| Point3::from(truth + random_vector(&mut rng) * off);
    let survey = Survey {
        axis: RotaryAxis::new(plan.letter, Point3::from(origin), direction).unwrap(),
        second: None,
        stations: (stations_mm.iter().enumerate())
            .map(|(i, s)| Station {
                name: format!("S{}", i + 1),
                nominal_mm: nominal(s, plan.stations_off_mm),
            })
            .collect(),
        mounts: (mounts_mm.iter().enumerate())
            .map(|(j, m)| Mount {
                name: format!("R{}", j + 1),
                nominal_mm: nominal(m, plan.mounts_off_mm),
            })
            .collect(),
        steps: (order.iter().enumerate())
            .map(|(n, &(k, approach))| Step {
                name: format!("{}", n + 1),
                angle_rad: angles[k],
                approach,
            })
            .collect(),
        ranges,
    };
    Scene { survey, stations_mm, mounts_mm, errors }
}

fn angles(plan: &Plan) -> Vec<f64> {
    let half = plan.half_arc_deg.to_radians();
    let last = (plan.angles - 1).max(1) as f64;
    (0..plan.angles).map(|k| half * (2.0 * k as f64 / last - 1.0)).collect()
}

/// Three harmonics each, less their values at the first angle.
fn errors(plan: &Plan, angles: &[f64], rng: &mut ChaCha8Rng) -> Vec<Vector6<f64>> {
    let mut errors = vec![Vector6::zeros(); angles.len()];
    for component in 0..6 {
        let size = if component < 3 { plan.error_mm } else { plan.error_rad };
        for harmonic in 1..=3 {
            let amplitude = size * rng.random_range(0.3..1.0);
            let phase = rng.random_range(0.0..std::f64::consts::TAU);
            let at = |angle: f64| amplitude * (f64::from(harmonic) * angle + phase).cos();
            for (error, angle) in errors.iter_mut().zip(angles) {
                error[component] += at(*angle) - at(angles[0]);
            }
        }
    }
    errors
}
