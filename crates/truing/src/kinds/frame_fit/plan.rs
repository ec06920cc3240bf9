//! Points that could be measured next.

use std::collections::HashSet;

use nalgebra::{Point, Point3, SVector, Vector3};

use super::settings::{FROM, FramePlanSettings, PAIRS, TO};
use crate::Error;
use crate::case::{Location, Positive, Problem};
use crate::kinds::touching::{MOST_PLACES, Place, PlanSettings, shuffled};
use crate::kinds::{Offer, Offered};

/// Points of the lattice along the diagonal of the region, where no spacing is declared.
const ACROSS: f64 = 6.0;

/// Points of a lattice over the region, and those that were measured already.
pub(super) fn offer<const D: usize>(
    (settings, document): (&FramePlanSettings, &Location),
    from_mm: &[Vec<f64>],
    target_from_source: impl Fn(&Point<f64, D>) -> Point<f64, D>,
) -> Result<Offer, Error> {
    let z_mm = settings.z_mm.filter(|_| D > 2);
    let region = PlanSettings::of_region([settings.x_mm, settings.y_mm, z_mm], settings.spacing_mm);
    let at = |from: &Vec<f64>| {
        Point3::from(Vector3::from_fn(|axis, _| from.get(axis).copied().unwrap_or(0.0)))
    };
    let measured: Vec<Point3<f64>> = from_mm.iter().map(at).collect();
    let anywhere = |at: &Point3<f64>| Some(Place { contact_mm: *at, normal: Vector3::z_axis() });
    let Some(places) = region.places(&measured, ACROSS, anywhere) else {
        let message = format!("[plan] makes more than {MOST_PLACES} places; widen `spacing_mm`");
        return Err(Error::case(document.clone(), Problem::WrongValue { message }));
    };
    let lattice = places.iter().map(|place| place.contact_mm);
    // A place that was visited twice is offered once.
    let mut seen = HashSet::new();
    let again = measured.iter().filter(|p| seen.insert(p.coords.map(f64::to_bits))).copied();
    let offered = lattice.chain(again).map(|place| {
        let from = Point::<f64, D>::from(SVector::from_fn(|axis, _| place[axis]));
        let to = target_from_source(&from);
        let pair = |names: [&'static str; 3], point: &Point<f64, D>| {
            let cell = |axis: usize| (names[axis], format!("{:.6}", point[axis]));
            (0..D).map(cell).collect::<Vec<_>>()
        };
        Offered::of_row("point", [pair(FROM, &from), pair(TO, &to)].concat())
    });
    Ok(Offer {
        table: PAIRS,
        readings: TO[..D].to_vec(),
        columns: Vec::new(),
        offered: shuffled(&offered.collect::<Vec<_>>()),
        noun: "point",
        is_record: false,
        is_new_session: true,
        controls: Vec::new(),
        undeclared: settings.undeclared(D),
        made: None,
        minutes: settings.minutes_per_measurement.map(|Positive(minutes)| minutes),
        reach: None,
    })
}
