//! How large an effect on a tracer run must be: the run's design, from the geometry alone.

use crate::generators::vector::{add, cross, norm, rotate, scale};
use crate::kinds::tracker_lm::tracer::{Run, simulate};
use crate::kinds::tracker_lm::tracer_run::{Defect, Measured, Reading};
use crate::power::detectable::{Design, smallest};

/// Scales the defect, given at a small size, to `times` its minimal detectable size.
pub(crate) fn run_at(
    run: &Run,
    defect: impl Fn(f64) -> Defect,
    n_amplitudes: usize,
    n_candidates: usize,
    times: f64,
) -> Run {
    const SMALL: f64 = 1e-6;
    let measured = simulate(&Run { defect: defect(SMALL), ..run.clone() });
    let mut signal: Vec<f64> =
        measured.readings.iter().map(|r| r.disturbance_mm / run.noise_mm).collect();
    signal.extend(vec![0.0; 3 * run.n_stations]);
    let base = columns(run, &measured);
    let factor = smallest(&Design { signal, base, n_amplitudes, n_candidates });
    Run { defect: defect(times * factor * SMALL), ..run.clone() }
}

/// Whitened columns of stations, dead paths, reflectors, and the six errors of every angle but the
/// first; what is known of the stations beforehand comes last.
fn columns(run: &Run, measured: &Measured) -> Vec<Vec<f64>> {
    let sights: Vec<Sight> = measured.readings.iter().map(|r| Sight::of(measured, r)).collect();
    let column = |of: &dyn Fn(usize) -> f64, prior: Option<usize>| -> Vec<f64> {
        let mut column: Vec<f64> = (0..sights.len()).map(|i| of(i) / run.noise_mm).collect();
        let known = |row: usize| if prior == Some(row) { 1.0 / run.stations_off_mm } else { 0.0 };
        column.extend((0..3 * run.n_stations).map(known));
        column
    };
    let reading = |i: usize| &measured.readings[i];
    let mut columns = Vec::new();
    for station in 0..run.n_stations {
        for axis in 0..3 {
            let of =
                |i: usize| if reading(i).station == station { -sights[i].beam[axis] } else { 0.0 };
            columns.push(column(&of, Some(3 * station + axis)));
        }
        for mount in 0..run.n_mounts {
            let own = |i: usize| reading(i).station == station && reading(i).mount == mount;
            columns.push(column(&|i| if own(i) { -1.0 } else { 0.0 }, None));
        }
    }
    for mount in 0..run.n_mounts {
        for axis in 0..3 {
            let of = |i: usize| if reading(i).mount == mount { sights[i].body[axis] } else { 0.0 };
            columns.push(column(&of, None));
        }
    }
    let free = if run.perfect { 1..1 } else { 1..run.n_angles };
    for k in free {
        let angle = measured.steps[k].0.to_bits();
        let here = |i: usize| measured.steps[reading(i).step].0.to_bits() == angle;
        for axis in 0..3 {
            columns.push(column(&|i| if here(i) { sights[i].beam[axis] } else { 0.0 }, None));
            columns.push(column(&|i| if here(i) { sights[i].turn[axis] } else { 0.0 }, None));
        }
    }
    columns
}

/// Derivatives of one path.
struct Sight {
    /// Unit vector from the tracer to the reflector.
    beam: [f64; 3],
    /// The same by the reflector's place in the turning frame.
    body: [f64; 3],
    /// By a small rotation about the axis' origin, rad at 200 mm.
    turn: [f64; 3],
}

impl Sight {
    fn of(measured: &Measured, reading: &Reading) -> Self {
        /// Rotations count at this arm, so that columns are of one size.
        const ARM_MM: f64 = 200.0;
        let angle = measured.steps[reading.step].0.to_radians();
        let arm = rotate(measured.direction, angle, measured.mounts_mm[reading.mount].0);
        let station = measured.stations_mm[reading.station].0;
        let along = add(add(measured.origin_mm, arm), scale(-1.0, station));
        let beam = scale(1.0 / norm(&along), along);
        Self {
            beam,
            body: rotate(measured.direction, -angle, beam),
            turn: scale(1.0 / ARM_MM, cross(arm, beam)),
        }
    }
}
