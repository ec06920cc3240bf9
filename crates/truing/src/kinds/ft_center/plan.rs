//! Presses and poses that could be made next.

use std::f64::consts::TAU;

use ft_center::{Contact, GravityCalibration, Located, Press, PressRole, SolvedPress, StaticPose};
use geometry::Wrench;
use nalgebra::{Point2, Point3, Unit, UnitQuaternion, Vector3};

use super::plan_settings::SensorPlanSettings;
use super::settings::{GRAVITY, PRESSES, WRENCH};
use crate::Error;
use crate::case::{Location, Positive, Problem};
use crate::count::count;
use crate::kinds::lean::Lean;
use crate::kinds::touching::{MOST_PLACES, Place, PlanSettings, shuffled};
use crate::kinds::{Beside, Cells, Offer, Offered, undeclared};

/// Places along the diagonal of the region where no spacing is declared.
const ACROSS: f64 = 5.0;
/// Samples of a record that stand for one that is planned, at most.
const MOST_SAMPLES: usize = 240;
/// Directions in which a head leans, and azimuths to which a sensor is tilted.
const WAYS: u8 = 4;
/// Steepest lean of a press: the force beside the load is then as large as the load.
const STEEPEST_DEG: f64 = 45.0;
/// Azimuths to which a sensor is tilted.
const AZIMUTHS: u8 = 8;
/// Between two presses, as a share of a record.
const PAUSE: f64 = 0.5;

/// Presses as the loop sees them, and the frame to place new ones by.
pub(super) struct Pressed<'c> {
    pub(super) presses: &'c [Press],
    pub(super) solved: &'c [SolvedPress],
    pub(super) located: &'c Located,
    pub(super) contact: &'c Contact,
    pub(super) times: bool,
}

/// Presses at known places, with the loads and leans that the head has.
pub(super) fn presses(
    (settings, document): (&SensorPlanSettings, &Location),
    of: &Pressed<'_>,
) -> Result<Offer, Error> {
    let known =
        || (of.presses.iter().zip(of.solved)).filter(|(press, _)| press.role == PressRole::Frame);
    let measured: Vec<Point3<f64>> =
        known().map(|(p, _)| Point3::new(p.machine_mm.x, p.machine_mm.y, 0.0)).collect();
    let region = PlanSettings::of_region([settings.x_mm, settings.y_mm, None], settings.spacing_mm);
    let anywhere = |at: &Point3<f64>| Some(Place { contact_mm: *at, normal: Vector3::z_axis() });
    let Some(places) = region.places(&measured, ACROSS, anywhere) else {
        let message = format!("[plan] makes more than {MOST_PLACES} places; widen `spacing_mm`");
        return Err(Error::case(document.clone(), Problem::WrongValue { message }));
    };
    let loads = loads(settings, known().map(|(_, solved)| solved.orbit.mean_wrench.force_n.z));
    let mut leans = vec![[0.0, 0.0]];
    for Lean(angle) in settings.leans_deg.iter().flatten().filter(|Lean(a)| *a > 0.0) {
        let tan = angle.min(STEEPEST_DEG).to_radians().tan();
        for way in 0..WAYS {
            let (sin, cos) = (TAU * f64::from(way) / f64::from(WAYS)).sin_cos();
            leans.push([tan * cos, tan * sin]);
        }
    }
    let Some((template, middle)) = template(known()) else {
        return Err(Error::case(document.clone(), Problem::NoRows));
    };
    let mut meant = Vec::new();
    for place in &places {
        for load_n in &loads {
            meant.extend(leans.iter().map(|lean| (place.contact_mm.xy(), *load_n, *lean)));
        }
    }
    let last_s = of.solved.iter().map(|p| p.orbit.span_s[1]).fold(f64::MIN, f64::max);
    let lasts_s = middle.orbit.span_s[1] - middle.orbit.span_s[0];
    let offered = shuffled(&meant).into_iter().enumerate().map(|(n, (at, load_n, lean))| {
        let sensor_mm = sensor_place(of.located, &at);
        let begins_s = (1.0 + PAUSE) * lasts_s * count(n) + PAUSE * lasts_s;
        let shift_s = if of.times { last_s + begins_s - middle.orbit.span_s[0] } else { 0.0 };
        let moved = Moved { sensor_mm, load_n, lean, shift_s, z0_mm: of.contact.z0_mm };
        let record = moved.record(template, middle);
        let number = |value: f64| format!("{value:.6}");
        let mut press: Cells = vec![("machine_x_mm", number(at.x)), ("machine_y_mm", number(at.y))];
        press.push(("use", "frame".to_owned()));
        let mut told = vec![("load_n", load_n)];
        if leans.len() > 1 {
            let [x, y] = lean.map(|tan| tan.atan().to_degrees());
            told.extend([("lean_x_deg", x), ("lean_y_deg", y)]);
        }
        let beside = vec![Beside { table: WRENCH, rows: record, are_readings: true }];
        Offered { beside, told, ..Offered::of_row("press", press) }
    });
    Ok(Offer {
        table: PRESSES,
        readings: Vec::new(),
        columns: Vec::new(),
        offered: offered.collect(),
        noun: "press",
        is_record: false,
        is_new_session: false,
        controls: Vec::new(),
        undeclared: settings.undeclared_of_presses(),
        made: Some(of.presses.iter().filter(|p| p.role != PressRole::Locate).count()),
        minutes: settings.minutes(),
        reach: None,
    })
}

/// Loads that are declared, or the range of those that there were and its middle: what goes with the load
/// is told from what does not by a third.
fn loads(settings: &SensorPlanSettings, measured: impl Iterator<Item = f64>) -> Vec<f64> {
    if let Some(loads) = &settings.loads_n {
        return loads.iter().map(|Positive(load)| *load).collect();
    }
    let mut all: Vec<f64> = measured.map(f64::abs).collect();
    all.sort_by(f64::total_cmp);
    match (all.first(), all.get(all.len() / 2), all.last()) {
        // One load, as well as it is kept.
        (Some(low), Some(middle), Some(high)) if high - low < 0.1 * middle => vec![*middle],
        (Some(low), _, Some(high)) => vec![*low, 0.5 * (low + high), *high],
        _ => Vec::new(),
    }
}

/// The press whose load is in the middle.
fn template<'c>(
    known: impl Iterator<Item = (&'c Press, &'c SolvedPress)>,
) -> Option<(&'c Press, &'c SolvedPress)> {
    let mut all: Vec<_> = known.collect();
    let load = |(_, solved): &(&Press, &SolvedPress)| solved.orbit.mean_wrench.force_n.z.abs();
    all.sort_by(|a, b| load(a).total_cmp(&load(b)));
    all.get(all.len() / 2).copied()
}

/// Where the sensor sees a head at a commanded place.
fn sensor_place(located: &Located, at: &Point2<f64>) -> Point2<f64> {
    let there = located.frame.sensor_from_machine();
    let arm = (at - located.frame.pivot_mm) * located.commanded.scale;
    located.commanded.image_mm + there.linear * arm
}

/// The record of a press, made elsewhere with another load.
struct Moved {
    sensor_mm: Point2<f64>,
    load_n: f64,
    /// Force beside the load over the load, sensor axes.
    lean: [f64; 2],
    shift_s: f64,
    z0_mm: f64,
}

impl Moved {
    /// As the declared model reads it: `M = p × F` with the same orbit and the same free moment.
    fn record(&self, press: &Press, solved: &SolvedPress) -> Vec<Cells> {
        let by = self.sensor_mm - solved.orbit.center_mm;
        let mean_n = solved.orbit.mean_wrench.force_n.z;
        let gain = self.load_n / mean_n.abs();
        let every = press.record.len().div_ceil(MOST_SAMPLES).max(1);
        let gate = 0.5 * mean_n.abs();
        let mut rows = Vec::new();
        for sample in press.record.iter().step_by(every) {
            let (force, moment) = (sample.wrench.force_n, sample.wrench.torque_nmm);
            if force.z.abs() < gate {
                continue;
            }
            let z0 = self.z0_mm;
            let at = Point3::new(
                (z0 * force.x - moment.y) / force.z,
                (moment.x + z0 * force.y) / force.z,
                z0,
            );
            let free_nmm = moment.z - (at.x * force.y - at.y * force.x);
            let lean = Vector3::new(self.lean[0], self.lean[1], 0.0) * force.z;
            let pressed = (force + lean) * gain;
            let moved = Point3::new(at.x + by.x, at.y + by.y, z0);
            let mut wrench = Wrench::of_force(pressed, &moved);
            wrench.torque_nmm.z += free_nmm * gain;
            let mut cells = wrench_cells(&wrench);
            cells.push(("time_s", format!("{:.6}", sample.time_s + self.shift_s)));
            rows.push(cells);
        }
        rows
    }
}

fn wrench_cells(wrench: &Wrench) -> Cells {
    let names = ["fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"];
    let six = wrench.to_vector();
    // A picometre of lever at a newton: readings have to be those of the model.
    names.into_iter().zip(six.iter()).map(|(name, v)| (name, format!("{v:.9}"))).collect()
}

/// Orientations of the sensor, as far from the first one as the others were.
pub(super) fn poses(
    settings: &SensorPlanSettings,
    poses: &[StaticPose],
    (found, gravity): (&GravityCalibration, &Unit<Vector3<f64>>),
) -> Offer {
    let first = poses.first().map_or_else(UnitQuaternion::identity, |p| p.base_from_sensor);
    let down = first.inverse() * gravity.into_inner();
    let tilt = |p: &StaticPose| (p.base_from_sensor.inverse() * gravity.into_inner()).angle(&down);
    let farthest = poses.iter().map(tilt).fold(0.0, f64::max);
    let tilts: Vec<f64> = match &settings.tilts_deg {
        Some(tilts) => tilts.iter().map(|Lean(angle)| angle.to_radians()).collect(),
        None => vec![0.0, 0.5 * farthest, farthest],
    };
    let helper = Vector3::ith(down.iamin(), 1.0);
    let across = down.cross(&helper).normalize();
    let mut offered = Vec::new();
    for tilt in tilts {
        for way in 0..AZIMUTHS {
            let azimuth = TAU * f64::from(way) / f64::from(AZIMUTHS);
            let about_down = UnitQuaternion::from_axis_angle(&Unit::new_normalize(down), azimuth);
            let axis = Unit::new_normalize(about_down * across);
            // The sensor turned about an axis across the weight.
            let base_from_sensor = first * UnitQuaternion::from_axis_angle(&axis, tilt);
            offered.push(pose(&base_from_sensor, found, gravity));
            if tilt == 0.0 {
                break;
            }
        }
    }
    Offer {
        table: GRAVITY,
        readings: vec!["fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"],
        columns: Vec::new(),
        offered: shuffled(&offered),
        noun: "pose",
        is_record: false,
        is_new_session: false,
        controls: Vec::new(),
        undeclared: undeclared(&[("tilts_deg", settings.tilts_deg.is_some())]),
        made: None,
        minutes: settings.minutes(),
        reach: None,
    }
}

fn pose(
    base_from_sensor: &UnitQuaternion<f64>,
    found: &GravityCalibration,
    gravity: &Unit<Vector3<f64>>,
) -> Offered {
    let down = base_from_sensor.inverse() * gravity.into_inner();
    let mut wrench = Wrench::of_force(down * found.weight_n, &found.center_of_gravity_mm);
    wrench.force_n += found.bias.force_n;
    wrench.torque_nmm += found.bias.torque_nmm;
    let mut cells = wrench_cells(&wrench);
    let names = ["qw", "qx", "qy", "qz"];
    let q = base_from_sensor;
    for (name, value) in names.into_iter().zip([q.w, q.i, q.j, q.k]) {
        cells.push((name, format!("{value:.9}")));
    }
    Offered::of_row("pose", cells)
}
