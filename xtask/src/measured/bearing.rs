//! SO LAT: a reflector that a bearing carries round, twice, tracked on the way.
//!
//! Its way is probed like the outside of a ring, in the plane of the circle. Each run is laid on
//! its own least-squares circle, with every sector weighing the same: the tracker stood and dwelt
//! differently in each. One run is fitted, the other never.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Result, ensure};

use super::photogrammetry::{LAT, LAT_LICENCE};
use super::readings::{Shot, shots};
use super::{Case, Set};

/// Radius of the 1.5-inch reflector, mm.
const REFLECTOR_MM: f64 = 19.05;
/// The correlation of a continuous track ends within one.
const SECTOR_RAD: f64 = TAU / 36.0;
const SECTORS: usize = 36;
/// The centre moves by less than a micrometre of the two metres after a few.
const ITERATIONS: usize = 50;

pub(super) const SET: Set = Set {
    name: "lat-bearing",
    source: LAT,
    licence: LAT_LICENCE,
    place: "so_lat_tracker/bearing_continuous",
    reference: "0.0796 mm circle, 0.0245 with its 2nd and 3rd harmonic",
    left_out: "run",
    convert,
};

/// One way round: places about the axis, mm, in the order measured.
struct Run {
    number: u8,
    places: Vec<[f64; 3]>,
    radius_mm: f64,
    dropped: usize,
}

fn convert(folder: &Path) -> Result<Vec<Case>> {
    let runs = [read(folder, 1)?, read(folder, 2)?];
    Ok(vec![case(&runs[0], &runs[1]), case(&runs[1], &runs[0])])
}

fn read(folder: &Path, number: u8) -> Result<Run> {
    let (mut shots, dropped) = shots(&folder.join(format!("Bearing_Circle_{number}.csv")))?;
    shots.sort_by_key(|shot| shot.id);
    ensure!(shots.len() > SECTORS, "run {number}: {} shots", shots.len());
    // The axis is y of the telescope; here it is z.
    let turned = |shot: &Shot| [shot.at_mm[0], -shot.at_mm[2], shot.at_mm[1]];
    let mut places: Vec<[f64; 3]> = shots.iter().map(turned).collect();
    let radius_mm = center(&mut places);
    Ok(Run { number, places, radius_mm, dropped })
}

/// Moves the places so that their least-squares circle is about the origin; its radius.
///
/// For sectors all round that weigh the same, the first harmonic of the radii is the way to the
/// centre.
fn center(places: &mut [[f64; 3]]) -> f64 {
    let mut radius_mm = 0.0;
    for _ in 0..ITERATIONS {
        let mut counts = [0.0; SECTORS];
        for place in &*places {
            counts[sector(place)] += 1.0;
        }
        let seen: f64 = counts.iter().map(|&n: &f64| n.min(1.0)).sum();
        let mean = |of: &dyn Fn(&[f64; 3]) -> f64| -> f64 {
            places.iter().map(|p| of(p) / (seen * counts[sector(p)])).sum()
        };
        radius_mm = mean(&|p| p[0].hypot(p[1]));
        let out = |p: &[f64; 3], axis: usize| {
            let radius = p[0].hypot(p[1]);
            2.0 * (radius - radius_mm) * p[axis] / radius
        };
        let shift = [mean(&|p| out(p, 0)), mean(&|p| out(p, 1)), mean(&|p| p[2])];
        for place in &mut *places {
            for (value, by) in place.iter_mut().zip(shift) {
                *value -= by;
            }
        }
    }
    radius_mm
}

fn angle(place: &[f64; 3]) -> f64 {
    place[1].atan2(place[0]).rem_euclid(TAU)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "an angle within one turn has a sector"
)]
fn sector(place: &[f64; 3]) -> usize {
    ((angle(place) / SECTOR_RAD) as usize).min(SECTORS - 1)
}

fn case(fitted: &Run, judged: &Run) -> Case {
    let mut table = "touch,x_mm,y_mm,z_mm,angle_deg,sector,use\n".to_owned();
    for (run, role) in [(fitted, "fit"), (judged, "check")] {
        let scale = fitted.radius_mm / run.radius_mm;
        for (k, place) in run.places.iter().enumerate() {
            let [x, y, z] = [place[0] * scale, place[1] * scale, place[2]];
            let (number, sector) = (run.number, sector(place));
            let degrees = angle(place).to_degrees();
            // A string takes every character.
            let _ = writeln!(
                table,
                "{number}-{k},{x:.6},{y:.6},{z:.6},{degrees:.4},{number}-{sector},{role}"
            );
        }
    }
    let ring_mm = fitted.radius_mm - REFLECTOR_MM;
    Case {
        name: format!("fitted-{}-judged-{}", fitted.number, judged.number),
        settings: format!(
            "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = {ring_mm:.6}\n\
             [probe]\ntip_radius_mm = {REFLECTOR_MM}\n[loop]\ngroup = \"sector\"\n"
        ),
        tables: vec![("touches.csv", table)],
        carry: None,
        notes: vec![format!(
            "radius {:.4} mm fitted, {:.4} mm judged, each run about its own circle; the heights \
             scatter by 0.3 µm, so they were projected on a plane before they were published; {} \
             rows not enabled or unreadable",
            fitted.radius_mm,
            judged.radius_mm,
            fitted.dropped + judged.dropped
        )],
    }
}
