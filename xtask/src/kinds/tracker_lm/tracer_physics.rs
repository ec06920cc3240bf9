//! Where tracer and reflector really are at one reading, and what the tracer makes of it.

use crate::generators::vector::{add, cross, norm, rotate, scale};
use crate::kinds::tracker_lm::tracer_run::{Defect, Measured};

/// When and of what a reading is.
pub(crate) struct Instant {
    pub(crate) station: usize,
    pub(crate) mount: usize,
    pub(crate) step: usize,
    /// Share of the whole measurement that is over.
    pub(crate) share: f64,
    /// Time since the tracer stands there, over that which it spends there.
    pub(crate) stood: f64,
    /// Share of a run since the tracer locked on.
    pub(crate) locked: f64,
    pub(crate) air_c: f64,
}

/// What the tracer reads from its dead path on, without noise.
pub(crate) fn displaced_mm(
    defects: &[Defect],
    measured: &Measured,
    at: &Instant,
    dead_path_mm: f64,
) -> f64 {
    let beam = beam(defects, measured, at);
    let displacement_mm = norm(&beam) - dead_path_mm;
    defects.iter().fold(displacement_mm, |l, defect| read_mm(*defect, measured, l, at, beam))
}

/// First-order settling whose time constant is as long as the whole: 0 to 1.
fn settling(share: f64) -> f64 {
    (1.0 - (-share).exp()) / (1.0 - (-1.0_f64).exp())
}

/// From the tracer to the reflector, where both really are.
fn beam(defects: &[Defect], measured: &Measured, at: &Instant) -> [f64; 3] {
    let (angle_deg, rising) = measured.steps[at.step];
    let mut body = measured.mounts_mm[at.mount].0;
    let (mut displacement, mut rotation) = measured.errors[at.step];
    let mut station = measured.stations_mm[at.station].0;
    for defect in defects {
        match *defect {
            Defect::MountSlip(mount, step, slip) if mount == at.mount && at.step >= step => {
                body = add(body, slip);
            }
            Defect::Backlash(play, give) => {
                let way = if rising { 0.5 } else { -0.5 };
                rotation = add(rotation, scale(-way * play, measured.direction));
                displacement = add(displacement, scale(way, give));
            }
            Defect::StandsDrift(total) => {
                // Directions a golden angle apart about the vertical.
                let (sin, cos) = (2.399_963
                    * f64::from(u32::try_from(at.station).expect("a dozen at most")))
                .sin_cos();
                let way =
                    [0.8 * cos, 0.8 * sin, if at.station.is_multiple_of(2) { 0.6 } else { -0.6 }];
                station = add(station, scale(settling(at.share) * total, way));
            }
            Defect::Knocked(knocked, step, by) if knocked == at.station && at.step >= step => {
                station = add(station, by);
            }
            Defect::StationDrift(warm, total) if warm == at.station => {
                station = add(station, scale(settling(at.stood), total));
            }
            _ => {}
        }
    }
    let (mut origin, mut direction) = (measured.origin_mm, measured.direction);
    for defect in defects {
        match *defect {
            Defect::AxisMoved(by, tilt) => {
                (origin, direction) = elsewhere(origin, direction, by, tilt);
            }
            Defect::AxisMotion(error, order, size, phase) => {
                let wave = size * (f64::from(order) * angle_deg.to_radians() + phase).cos();
                *component(error, &mut displacement, &mut rotation) += wave;
            }
            _ => {}
        }
    }
    let mut arm = rotate(direction, angle_deg.to_radians(), body);
    for defect in defects {
        if let Defect::Bending(mount, sag) = *defect
            && mount == at.mount
        {
            // A cantilever along the arm: it gives where gravity is across it.
            let horizontal = (arm[0] * arm[0] + arm[1] * arm[1]).sqrt() / norm(&arm);
            arm[2] -= sag * horizontal;
        }
    }
    let angle = norm(&rotation);
    if angle > 0.0 {
        arm = rotate(scale(1.0 / angle, rotation), angle, arm);
    }
    let mut target = add(add(origin, displacement), arm);
    for defect in defects {
        if let Defect::Moved(step, by, turned) = *defect
            && at.step >= step
        {
            let from = add(target, scale(-1.0, measured.origin_mm));
            let from = rotate(scale(1.0 / norm(&turned), turned), norm(&turned), from);
            target = add(add(measured.origin_mm, by), from);
        }
    }
    add(target, scale(-1.0, station))
}

/// What the tracer reads of a displacement.
fn read_mm(
    defect: Defect,
    measured: &Measured,
    displacement_mm: f64,
    at: &Instant,
    beam: [f64; 3],
) -> f64 {
    let l = displacement_mm;
    match defect {
        Defect::RangeScale(s) => l * (1.0 + s),
        // What was counted less at lock-on is of the dead path.
        Defect::Warming(total, constant) => {
            l + norm(&beam) * total * (1.0 - (-at.share / constant).exp())
        }
        Defect::RangeDrift(total) => l + total * settling(at.locked),
        Defect::Creep(station, total) if station == at.station => l + total * at.locked,
        Defect::Incidence(glass) => {
            let (angle_deg, _) = measured.steps[at.step];
            let body = measured.mounts_mm[at.mount].0;
            let arm = rotate(measured.direction, angle_deg.to_radians(), body);
            let radial = cross(cross(measured.direction, arm), measured.direction);
            let cosine =
                (0..3).map(|i| radial[i] * beam[i]).sum::<f64>() / norm(&radial) / norm(&beam);
            let sine2 = 1.0 - cosine * cosine;
            l + glass * sine2 * (1.0 + 0.1 * sine2)
        }
        Defect::BadStation(bad, s) if bad == at.station => l * (1.0 + s),
        Defect::DeadPathJump(station, mount, step, jump)
            if station == at.station && mount == at.mount && at.step >= step =>
        {
            l + jump
        }
        Defect::Temperature(per_k) => l * (1.0 + per_k * (at.air_c - 20.0)),
        Defect::Wavelength(per_k) => l + norm(&beam) * per_k * (at.air_c - 20.0),
        _ => l,
    }
}

/// Where an axis is that stands and leans elsewhere than it should: its origin and direction.
pub(crate) fn elsewhere(
    origin: [f64; 3],
    direction: [f64; 3],
    by: [f64; 3],
    tilt: [f64; 3],
) -> ([f64; 3], [f64; 3]) {
    let leaning = rotate(scale(1.0 / norm(&tilt), tilt), norm(&tilt), direction);
    (add(origin, by), leaning)
}

/// One of the six errors of an axis: three displacements, then three rotations.
pub(crate) fn component<'e>(
    error: usize,
    displacement: &'e mut [f64; 3],
    rotation: &'e mut [f64; 3],
) -> &'e mut f64 {
    if error < 3 { &mut displacement[error] } else { &mut rotation[error - 3] }
}
