//! How large an effect on measured points must be: the survey's design, from the geometry alone.

use crate::generators::vector::{add, cross, norm, rotate, scale};
use crate::kinds::tracker_lm::targets::{Fault, Measured, Survey, simulate};
use crate::power::detectable::{Design, smallest};

/// Rotations count at this arm, so that columns are of one size.
const ARM_MM: f64 = 500.0;

/// Scales the fault, given at a small size, to `times` its minimal detectable size.
pub(crate) fn survey_at(
    survey: &Survey,
    fault: impl Fn(f64) -> Fault,
    n_amplitudes: usize,
    n_candidates: usize,
    times: f64,
) -> Survey {
    // Large beside the round-off of coordinates of some metres, small beside the arms.
    const SMALL: f64 = 1e-3;
    // One seed, one noise: the difference is the fault's own.
    let sound = simulate(&Survey { fault: Fault::None, ..survey.clone() });
    let faulty = simulate(&Survey { fault: fault(SMALL), ..survey.clone() });
    let sights: Vec<Sight> = (0..sound.readings.len()).map(|i| Sight::of(&sound, i)).collect();
    let white = |of: &dyn Fn(usize) -> [f64; 3]| -> Vec<f64> {
        (0..sights.len()).flat_map(|i| sights[i].white(survey, of(i))).collect()
    };
    let signal = white(&|i| {
        let moved = add(faulty.readings[i].at_mm, scale(-1.0, sound.readings[i].at_mm));
        let pose = &sound.stations[sound.readings[i].station];
        rotate(pose.axis, pose.turn_rad, moved)
    });
    let mut base = Vec::new();
    for unit in UNITS {
        for station in 0..survey.n_stations {
            let own = |i: usize| sound.readings[i].station == station;
            base.push(white(&|i| if own(i) { unit } else { ZERO }));
            base.push(white(&|i| if own(i) { turned(unit, sights[i].along_mm) } else { ZERO }));
        }
        for mount in 0..survey.n_mounts {
            let own = |i: usize| sound.readings[i].mount == mount;
            let carried = |i: usize| rotate(sound.direction, sights[i].angle_rad, unit);
            base.push(white(&|i| if own(i) { carried(i) } else { ZERO }));
        }
        let free = if survey.perfect { 1..1 } else { 1..survey.n_angles };
        for angle in free {
            let here = |i: usize| sights[i].angle_rad.to_bits() == angle_of(&sound, angle);
            base.push(white(&|i| if here(i) { unit } else { ZERO }));
            base.push(white(&|i| if here(i) { turned(unit, sights[i].arm_mm) } else { ZERO }));
        }
    }
    let factor = smallest(&Design { signal, base, n_amplitudes, n_candidates });
    Survey { fault: fault(times * factor * SMALL), ..survey.clone() }
}

const ZERO: [f64; 3] = [0.0; 3];
const UNITS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn angle_of(measured: &Measured, angle: usize) -> u64 {
    measured.steps[angle].0.to_radians().to_bits()
}

/// Displacement of an arm by a small rotation, rad at [`ARM_MM`].
fn turned(about: [f64; 3], arm_mm: [f64; 3]) -> [f64; 3] {
    scale(1.0 / ARM_MM, cross(about, arm_mm))
}

/// Geometry of one reading, machine frame.
struct Sight {
    angle_rad: f64,
    /// From the axis' origin to the reflector.
    arm_mm: [f64; 3],
    /// From the tracker to the reflector.
    along_mm: [f64; 3],
}

impl Sight {
    fn of(measured: &Measured, reading: usize) -> Self {
        let reading = &measured.readings[reading];
        let angle_rad = measured.steps[reading.step].0.to_radians();
        let arm_mm = rotate(measured.direction, angle_rad, measured.mounts_mm[reading.mount].0);
        let station = measured.stations[reading.station].at_mm;
        let along_mm = add(add(measured.origin_mm, arm_mm), scale(-1.0, station));
        Self { angle_rad, arm_mm, along_mm }
    }

    /// A displacement along and across the beam, over the standard uncertainties.
    fn white(&self, survey: &Survey, moved: [f64; 3]) -> [f64; 3] {
        let distance = norm(&self.along_mm);
        let beam = scale(1.0 / distance, self.along_mm);
        let along: f64 = beam.iter().zip(moved).map(|(a, b)| a * b).sum();
        let across = add(moved, scale(-along, beam));
        let sideways = scale(1.0 / (survey.angle_rad * distance), across);
        add(sideways, scale(along / survey.range_mm, beam))
    }
}
