//! A laser tracer at several stations and reflectors on a rotary axis, in millimetres.
//!
//! Everything is displaced and turned as the physics has it: the axis' own errors at every angle,
//! what is wrong with tracer, stand and reflectors, and the noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise, gaussian};
use crate::generators::vector::{add, norm, scale};
use crate::kinds::positioning::axis_curves::Curves;
use crate::kinds::tracker_lm::tracer_physics::{Instant, displaced_mm};
use crate::kinds::tracker_lm::tracer_run::{Defect, Measured, Reading};

/// A measurement to simulate.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent circumstances")]
pub(crate) struct Run {
    /// Stations, 4 to 8.
    pub n_stations: usize,
    /// Reflectors, 3 to 5.
    pub n_mounts: usize,
    /// Angles, over 180°.
    pub n_angles: usize,
    /// Whether the axis runs back through the same angles.
    pub both_ways: bool,
    /// Angles and ways, rising or not, to which the axis is sent afterwards; tracers at every station only.
    pub further: Vec<(f64, bool)>,
    /// Whether one tracer takes one lock after the other, or a tracer at every station all at once.
    pub one_tracer: bool,
    /// Whether all reflectors of a station share its dead path.
    pub station_dead_paths: bool,
    /// Standard uncertainty of a displacement, mm.
    pub noise_mm: f64,
    /// Dependence of successive readings of one lock.
    pub colour: Colour,
    /// How far the stations stand from their nominal places, per coordinate, mm.
    pub stations_off_mm: f64,
    /// Whether the case declares that.
    pub declare_stations: bool,
    /// Whether the case declares the noise.
    pub declare_noise: bool,
    /// Whether the air temperature is recorded.
    pub record_air: bool,
    /// Whether the axis has no errors but those that are wrong, and the case takes it for perfect.
    pub perfect: bool,
    /// Share of readings that are missing, at random.
    pub missing: f64,
    /// What is wrong.
    pub defect: Defect,
    /// What is wrong beside it.
    pub second: Defect,
    /// Seed of everything random.
    pub seed: u64,
}

impl Run {
    /// Six stations, four reflectors, 25 angles, 0.5 µm, stations 4 µm off and said so.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_stations: 6,
            n_mounts: 4,
            n_angles: 25,
            both_ways: false,
            further: Vec::new(),
            one_tracer: false,
            station_dead_paths: false,
            noise_mm: 5e-4,
            colour: Colour::White,
            stations_off_mm: 4e-3,
            declare_stations: true,
            declare_noise: true,
            record_air: false,
            perfect: false,
            missing: 0.0,
            defect: Defect::None,
            second: Defect::None,
            seed,
        }
    }
}

/// Corners of the working space in which the tracer stands, mm from the axis' origin.
const STATIONS_MM: [[f64; 3]; 8] = [
    [-360.0, -340.0, -725.0],
    [360.0, -320.0, -675.0],
    [-280.0, 340.0, -700.0],
    [305.0, 320.0, -350.0],
    [-320.0, -305.0, -275.0],
    [335.0, -280.0, -325.0],
    [-305.0, 305.0, -300.0],
    [40.0, -40.0, -740.0],
];
/// Radius, azimuth from the −z axis in degrees, height along the axis.
const MOUNTS: [[f64; 3]; 5] = [
    [150.0, 0.0, -60.0],
    [210.0, 55.0, 70.0],
    [180.0, -50.0, 40.0],
    [250.0, 15.0, -20.0],
    [190.0, -20.0, 90.0],
];
/// How far reflectors are from their nominal places, per coordinate.
const MOUNTS_OFF_MM: f64 = 0.3;
/// Seconds from one reading of a tracer to its next.
const INTERVAL_S: f64 = 6.0;
/// Height from which the first air temperature and its swing are taken, °C.
const AIR_C: f64 = 21.0;
const AIR_SWING_C: f64 = 1.5;

/// Simulates a run.
pub(crate) fn simulate(run: &Run) -> Measured {
    let mut rng = ChaCha8Rng::seed_from_u64(run.seed);
    let mut around =
        |half: f64| -> [f64; 3] { std::array::from_fn(|_| rng.random_range(-half..half)) };
    let tilt = add([0.0, 1.0, 0.0], around(2e-3));
    let direction = scale(1.0 / norm(&tilt), tilt);
    let origin_mm = add([420.0, 410.0, 760.0], around(10.0)).map(|v| (v * 1e3).round() / 1e3);
    let stations: Vec<[f64; 3]> = STATIONS_MM[..run.n_stations]
        .iter()
        .map(|s| add(origin_mm, add(*s, around(35.0))))
        .collect();
    let mounts: Vec<[f64; 3]> = MOUNTS[..run.n_mounts]
        .iter()
        .map(|[radius, azimuth, height]| {
            let (sin, cos) = azimuth.to_radians().sin_cos();
            add([radius * sin, *height, -radius * cos], around(5.0))
        })
        .collect();
    let steps = steps(run);
    let curves = Curves::random(&mut rng);
    let first = curves.at(steps[0].0);
    let errors: Vec<([f64; 3], [f64; 3])> = (steps.iter())
        .map(|(angle_deg, _)| {
            if run.perfect {
                return ([0.0; 3], [0.0; 3]);
            }
            let here = curves.at(*angle_deg);
            (add(here.0, scale(-1.0, first.0)), add(here.1, scale(-1.0, first.1)))
        })
        .collect();
    let mut nominal = |truth: &[f64; 3], off: f64| {
        let moved: [f64; 3] = std::array::from_fn(|i| truth[i] + off * gaussian(&mut rng));
        (*truth, moved.map(|v| (v * 1e4).round() / 1e4))
    };
    let stations_mm = stations.iter().map(|s| nominal(s, run.stations_off_mm)).collect();
    let mounts_mm = mounts.iter().map(|m| nominal(m, MOUNTS_OFF_MM)).collect();
    let mut measured = Measured {
        origin_mm,
        direction,
        stations_mm,
        mounts_mm,
        steps,
        errors,
        readings: Vec::new(),
    };
    take_readings(run, &mut measured, &mut rng);
    measured
}

/// Angles and ways of all steps.
fn steps(run: &Run) -> Vec<(f64, bool)> {
    let last = as_f64(run.n_angles - 1);
    let angle = |k: usize| ((-90.0 + 180.0 * as_f64(k) / last) * 1e6).round() / 1e6;
    let mut steps: Vec<(f64, bool)> = (0..run.n_angles).map(|k| (angle(k), true)).collect();
    if run.both_ways {
        steps.extend((0..run.n_angles).rev().map(|k| (angle(k), false)));
    }
    steps.extend(&run.further);
    steps
}

/// Order of the readings: of one tracer, lock by lock; of many, step by step.
fn order(run: &Run, n_steps: usize) -> Vec<(usize, usize, usize, f64)> {
    let mut order = Vec::new();
    if run.one_tracer {
        for station in 0..run.n_stations {
            for mount in 0..run.n_mounts {
                for step in 0..n_steps {
                    order.push((station, mount, step, INTERVAL_S * as_f64(order.len())));
                }
            }
        }
        return order;
    }
    for step in 0..n_steps {
        for mount in 0..run.n_mounts {
            let time_s = INTERVAL_S * as_f64(step * run.n_mounts + mount);
            order.extend((0..run.n_stations).map(|station| (station, mount, step, time_s)));
        }
    }
    order
}

fn take_readings(run: &Run, measured: &mut Measured, rng: &mut ChaCha8Rng) {
    let order = order(run, measured.steps.len());
    // What drifts goes on as it did, through what is measured afterwards.
    let n_first = measured.steps.len() - run.further.len();
    let mut of_run = order.iter().filter(|(_, _, step, _)| *step < n_first);
    let total_s = of_run.next_back().map_or(1.0, |last| last.3).max(1.0);
    let n_locks = run.n_stations * run.n_mounts;
    let mut noises: Vec<Noise> = (0..n_locks).map(|_| Noise::new(run.colour, rng)).collect();
    let dead_paths: Vec<f64> = (0..n_locks).map(|_| rng.random_range(60.0..140.0)).collect();
    let air_phase = rng.random_range(0.0..std::f64::consts::TAU);
    let mut locked: Vec<Option<f64>> = vec![None; n_locks];
    // A stand settles under the tracer from when that is put there.
    let mut put_s: Vec<Option<f64>> = vec![None; run.n_stations];
    let stand_s = if run.one_tracer { total_s / as_f64(run.n_stations) } else { total_s };
    let last_run_s = if run.one_tracer { total_s / as_f64(n_locks) } else { total_s };
    for (station, mount, step, time_s) in order {
        let lock = station * run.n_mounts + mount;
        let noise = run.noise_mm * noises[lock].next(rng);
        let air = AIR_C + AIR_SWING_C * (air_phase + 4.0 * time_s / total_s).sin();
        let air_c = ((air + 0.01 * gaussian(rng)) * 1e3).round() / 1e3;
        let since_put = time_s - *put_s[station].get_or_insert(time_s);
        let since_lock = time_s - *locked[lock].get_or_insert(time_s);
        if rng.random_range(0.0..1.0) < run.missing {
            continue;
        }
        let at = Instant {
            station,
            mount,
            step,
            share: time_s / total_s,
            stood: since_put / stand_s,
            locked: since_lock / last_run_s,
            air_c,
        };
        let dead_path =
            dead_paths[if run.station_dead_paths { station * run.n_mounts } else { lock }];
        let sound = displaced_mm(&[], measured, &at, dead_path);
        let disturbance_mm =
            displaced_mm(&[run.defect, run.second], measured, &at, dead_path) - sound;
        measured.readings.push(Reading {
            station,
            mount,
            step,
            time_s,
            air_c,
            displacement_mm: sound + disturbance_mm + noise,
            disturbance_mm,
        });
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
