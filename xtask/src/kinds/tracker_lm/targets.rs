//! Trackers that measure points on a rotary axis, each in a frame of its own, in millimetres.

use std::fmt::Write as _;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::gaussian;
use crate::generators::vector::{add, cross, norm, rotate, scale};
use crate::kinds::positioning::axis_curves::Curves;
use crate::kinds::tracker_lm::tracer_physics::{component, elsewhere};

/// What is wrong with the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// Nothing.
    None,
    /// Play of the drive: the axis stops short by half of this either way, rad, and its bearing
    /// gives by the displacement, mm.
    Backlash(f64, [f64; 3]),
    /// The second body hangs on a flexure that gives along x of the turning frame: mm under its
    /// whole weight.
    Flexure(f64),
    /// The axis is not where it is declared: displacement of its origin, mm, and tilt, rad.
    AxisMoved([f64; 3], [f64; 3]),
    /// One of the six errors of the axis: which, how often per turn, mm or rad, phase.
    AxisMotion(usize, u8, f64, f64),
    /// The machine is moved against all trackers before a step: which, mm, and rad about the axis' origin.
    Moved(usize, [f64; 3], [f64; 3]),
    /// A tracker's stand is knocked before a step: which, at which, mm, rad.
    Knocked(usize, usize, [f64; 3], [f64; 3]),
    /// A tracker's stand gives way: which, and total over the measurement, mm, rad.
    Stand(usize, [f64; 3], [f64; 3]),
}

/// A measurement to simulate.
#[derive(Clone, Debug)]
pub(crate) struct Survey {
    /// Trackers, 1 or 2.
    pub n_stations: usize,
    /// Reflectors, half of them on a second body.
    pub n_mounts: usize,
    /// Angles, over 180°.
    pub n_angles: usize,
    /// Whether the axis runs back through the same angles.
    pub both_ways: bool,
    /// Angles that are measured afterwards, degrees, and whether each is reached with rising angles.
    pub further: Vec<(f64, bool)>,
    /// Standard uncertainty of a distance, mm, and of an angle of the beam, rad.
    pub range_mm: f64,
    pub angle_rad: f64,
    /// Whether the axis has no errors but those that are wrong, and the case takes it for perfect.
    pub perfect: bool,
    /// How far reflectors are from their nominal places, per coordinate.
    pub mounts_off_mm: f64,
    /// What is wrong.
    pub fault: Fault,
    /// Seed of everything random.
    pub seed: u64,
}

impl Survey {
    /// Two trackers, six reflectors on two bodies, thirteen angles; nothing wrong.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_stations: 2,
            n_mounts: 6,
            n_angles: 13,
            both_ways: false,
            further: Vec::new(),
            range_mm: 0.004,
            angle_rad: 4e-6,
            perfect: false,
            mounts_off_mm: 0.3,
            fault: Fault::None,
            seed,
        }
    }
}

/// One reading.
pub(crate) struct Reading {
    pub station: usize,
    pub mount: usize,
    pub step: usize,
    time_s: f64,
    /// In the tracker's own frame.
    pub at_mm: [f64; 3],
}

/// What a survey gave.
pub(crate) struct Measured {
    pub origin_mm: [f64; 3],
    pub direction: [f64; 3],
    pub stations: Vec<Pose>,
    /// True and nominal places, turning frame.
    pub mounts_mm: Vec<([f64; 3], [f64; 3])>,
    /// Angle of every step, degrees, and whether it was reached with rising angles.
    pub steps: Vec<(f64, bool)>,
    pub readings: Vec<Reading>,
    /// Root mean square of a reading's distance from the truth that the noise makes.
    pub noise_mm: f64,
}

/// Where a tracker stands, and how it is turned.
pub(crate) struct Pose {
    pub at_mm: [f64; 3],
    pub axis: [f64; 3],
    pub turn_rad: f64,
}

/// Two sides of the machine, mm from the axis' origin.
const STATIONS_MM: [[f64; 3]; 2] = [[-2600.0, 900.0, -1900.0], [2300.0, -1100.0, -2400.0]];
/// Radius, azimuth from the −z axis in degrees, height along the axis; bodies in turn.
const MOUNTS: [[f64; 3]; 8] = [
    [600.0, 0.0, -400.0],
    [550.0, 30.0, 420.0],
    [620.0, 55.0, -380.0],
    [580.0, -60.0, 400.0],
    [640.0, -40.0, -360.0],
    [600.0, 80.0, 380.0],
    [560.0, 110.0, -420.0],
    [650.0, -95.0, 360.0],
];
/// Seconds from one reading to the next.
const INTERVAL_S: f64 = 8.0;

/// Simulates a survey.
pub(crate) fn simulate(survey: &Survey) -> Measured {
    let mut rng = ChaCha8Rng::seed_from_u64(survey.seed);
    let mut around =
        |half: f64| -> [f64; 3] { std::array::from_fn(|_| rng.random_range(-half..half)) };
    let tilt = add([0.0, 1.0, 0.0], around(2e-3));
    let direction = scale(1.0 / norm(&tilt), tilt);
    let origin_mm = add([1200.0, 800.0, 900.0], around(10.0)).map(|v| (v * 1e3).round() / 1e3);
    let stations = STATIONS_MM[..survey.n_stations]
        .iter()
        .map(|place| {
            let at_mm = add(origin_mm, add(*place, around(60.0)));
            let axis = around(1.0);
            let axis = scale(1.0 / norm(&axis), axis);
            Pose { at_mm, axis, turn_rad: 2.0 * around(1.0)[0] }
        })
        .collect();
    let mounts: Vec<[f64; 3]> = MOUNTS[..survey.n_mounts]
        .iter()
        .map(|[radius, azimuth, height]| {
            let (sin, cos) = azimuth.to_radians().sin_cos();
            add([radius * sin, *height, -radius * cos], around(5.0))
        })
        .collect();
    let curves = Curves::random(&mut rng);
    let mut nominal = |truth: &[f64; 3]| {
        let moved = truth.map(|v| v + survey.mounts_off_mm * gaussian(&mut rng));
        (*truth, moved.map(|v| (v * 1e4).round() / 1e4))
    };
    let mounts_mm = mounts.iter().map(&mut nominal).collect();
    let mut measured = Measured {
        origin_mm,
        direction,
        stations,
        mounts_mm,
        steps: steps(survey),
        readings: Vec::new(),
        noise_mm: 0.0,
    };
    take_readings(survey, &mut measured, &curves, &mut rng);
    measured
}

/// Angles and ways of all steps.
fn steps(survey: &Survey) -> Vec<(f64, bool)> {
    let last = as_f64(survey.n_angles - 1);
    let angle = |k: usize| ((-90.0 + 180.0 * as_f64(k) / last) * 1e6).round() / 1e6;
    let mut steps: Vec<(f64, bool)> = (0..survey.n_angles).map(|k| (angle(k), true)).collect();
    if survey.both_ways {
        steps.extend((0..survey.n_angles).rev().map(|k| (angle(k), false)));
    }
    steps.extend(&survey.further);
    steps
}

fn take_readings(survey: &Survey, measured: &mut Measured, curves: &Curves, rng: &mut ChaCha8Rng) {
    let at_a_step = survey.n_mounts * survey.n_stations;
    // What drifts goes on as it did, through what is measured afterwards.
    let n_first = (measured.steps.len() - survey.further.len()) * at_a_step;
    let mut squares = 0.0;
    for step in 0..measured.steps.len() {
        for mount in 0..survey.n_mounts {
            for station in 0..survey.n_stations {
                let number = as_f64(measured.readings.len());
                let point = point_mm(survey, measured, curves, step, mount);
                let share = number / as_f64(n_first - 1);
                let seen =
                    seen_mm(survey, &measured.stations[station], (station, step), point, share);
                let noise = noise_mm(survey, seen, rng);
                squares += noise.iter().map(|v| v * v).sum::<f64>();
                let (time_s, at_mm) = (INTERVAL_S * number, add(seen, noise));
                measured.readings.push(Reading { station, mount, step, time_s, at_mm });
            }
        }
    }
    measured.noise_mm = (squares / as_f64(measured.readings.len())).sqrt();
}

/// Where the reflector really is, machine frame.
fn point_mm(
    survey: &Survey,
    measured: &Measured,
    curves: &Curves,
    step: usize,
    mount: usize,
) -> [f64; 3] {
    let (angle_deg, rising) = measured.steps[step];
    let (mut displacement, mut rotation) =
        if survey.perfect { ([0.0; 3], [0.0; 3]) } else { curves.at(angle_deg) };
    let (mut origin, mut direction) = (measured.origin_mm, measured.direction);
    match survey.fault {
        Fault::AxisMoved(by, tilt) => {
            (origin, direction) = elsewhere(origin, direction, by, tilt);
        }
        Fault::AxisMotion(error, order, size, phase) => {
            let wave = size * (f64::from(order) * angle_deg.to_radians() + phase).cos();
            *component(error, &mut displacement, &mut rotation) += wave;
        }
        _ => {}
    }
    if let Fault::Backlash(play, give) = survey.fault {
        let way = if rising { 0.5 } else { -0.5 };
        rotation = add(rotation, scale(-way * play, measured.direction));
        displacement = add(displacement, scale(way, give));
    }
    let angle = angle_deg.to_radians();
    let mut body = measured.mounts_mm[mount].0;
    if let Fault::AxisMoved(by, _) = survey.fault {
        // The reflectors are where the drawing has them; it is the axis that is not.
        body = add(body, scale(-1.0, by));
    }
    if let Fault::Flexure(give) = survey.fault
        && mount % 2 == 1
    {
        let weight = rotate(measured.direction, -angle, [0.0, 0.0, -1.0]);
        body[0] += give * weight[0];
    }
    let mut arm = rotate(direction, angle, body);
    let turn = norm(&rotation);
    if turn > 0.0 {
        arm = rotate(scale(1.0 / turn, rotation), turn, arm);
    }
    let target = add(add(origin, displacement), arm);
    match survey.fault {
        Fault::Moved(from, by, turned) if step >= from => {
            let arm = add(target, scale(-1.0, measured.origin_mm));
            let arm = rotate(scale(1.0 / norm(&turned), turned), norm(&turned), arm);
            add(add(measured.origin_mm, by), arm)
        }
        _ => target,
    }
}

/// The point in the tracker's own frame.
fn seen_mm(
    survey: &Survey,
    pose: &Pose,
    (station, step): (usize, usize),
    point_mm: [f64; 3],
    share: f64,
) -> [f64; 3] {
    let mut from = add(point_mm, scale(-1.0, pose.at_mm));
    if let Fault::Stand(moving, displacement, rotation) = survey.fault
        && moving == station
    {
        let turn = norm(&rotation);
        from = add(from, scale(-share, displacement));
        from = rotate(scale(1.0 / turn, rotation), -share * turn, from);
    }
    if let Fault::Knocked(knocked, first, displacement, rotation) = survey.fault
        && knocked == station
        && step >= first
    {
        let turn = norm(&rotation);
        from = add(from, scale(-1.0, displacement));
        from = rotate(scale(1.0 / turn, rotation), -turn, from);
    }
    rotate(pose.axis, -pose.turn_rad, from)
}

/// Noise along the beam and across it.
fn noise_mm(survey: &Survey, seen: [f64; 3], rng: &mut ChaCha8Rng) -> [f64; 3] {
    let distance = norm(&seen);
    let beam = scale(1.0 / distance, seen);
    let across = cross(beam, if beam[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
    let across = scale(1.0 / norm(&across), across);
    let sideways = survey.angle_rad * distance;
    let along = scale(survey.range_mm * gaussian(rng), beam);
    let first = scale(sideways * gaussian(rng), across);
    add(along, add(first, scale(sideways * gaussian(rng), cross(beam, across))))
}

/// Files of a case folder, in the order of its page.
pub(crate) fn tables(survey: &Survey, measured: &Measured) -> Vec<(&'static str, String)> {
    let list = |v: [f64; 3], decimals: usize| {
        format!("[{:.decimals$}, {:.decimals$}, {:.decimals$}]", v[0], v[1], v[2])
    };
    let case = format!(
        "kind = \"tracker-lm\"\n\n[axis]\nletter = \"B\"\norigin_mm = {}\ndirection = {}\n\n\
         {}[noise]\nrange_mm = {}\nangle_rad = {}\n",
        list(measured.origin_mm, 3),
        list(measured.direction, 15),
        if survey.perfect { "[model]\naxis = \"fixed\"\n\n" } else { "" },
        survey.range_mm,
        survey.angle_rad,
    );
    let mut stations = String::from("station,x_mm,y_mm,z_mm\n");
    for (i, pose) in measured.stations.iter().enumerate() {
        let [x, y, z] = pose.at_mm;
        let _ = writeln!(stations, "S{},{x:.0},{y:.0},{z:.0}", i + 1);
    }
    let mut mounts = String::from("mount,x_mm,y_mm,z_mm,body\n");
    for (i, (_, [x, y, z])) in measured.mounts_mm.iter().enumerate() {
        let body = if i % 2 == 0 { "table" } else { "frame" };
        let _ = writeln!(mounts, "R{},{x:.4},{y:.4},{z:.4},{body}", i + 1);
    }
    vec![
        ("case.toml", case),
        ("stations.csv", stations),
        ("mounts.csv", mounts),
        ("targets.csv", targets_csv(survey, measured)),
    ]
}

fn targets_csv(survey: &Survey, measured: &Measured) -> String {
    let mut text = String::from("station,mount,step,angle_deg,x_mm,y_mm,z_mm,time_s");
    text.push_str(if survey.both_ways { ",direction\n" } else { "\n" });
    for reading in &measured.readings {
        let (angle_deg, rising) = measured.steps[reading.step];
        let [x, y, z] = reading.at_mm;
        let _ = write!(
            text,
            "S{},R{},{},{angle_deg},{x:.5},{y:.5},{z:.5},{:.0}",
            reading.station + 1,
            reading.mount + 1,
            reading.step + 1,
            reading.time_s,
        );
        if survey.both_ways {
            text.push_str(if rising { ",1" } else { ",-1" });
        }
        text.push('\n');
    }
    text
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
