//! Guide points of a case of touches.

use nalgebra::{Point2, Point3};
use probe_comp::{GuidePoint, ProbeError, guide_point};

use super::case::ProbeCase;
use super::settings::error;
use crate::Error;
use crate::case::Problem;
use crate::guide::{GuidePlaces, GuidesOfCase};
use crate::kinds::touching::{ACROSS, MOST_PLACES, Place};

pub(super) fn guides(case: &ProbeCase, of: &GuidePlaces) -> Result<GuidesOfCase, Error> {
    let (touches, tip_radius_mm) = (&case.touches, case.tip_radius_mm);
    let at_touch = |index: usize, source: ProbeError| {
        let at = touches.file.clone();
        let line = touches.lines.get(index).filter(|_| matches!(of, GuidePlaces::Touches));
        error(line.map_or_else(|| at.clone(), |line| at.clone().line(*line)), source)
    };
    let guide = |index: usize, from: &Point3<f64>| {
        let nominal = &case.surface.nominal;
        guide_point(nominal, tip_radius_mm, Point2::new(from.x, from.y), from.z, index)
    };
    let named = |all: Vec<(String, Point3<f64>)>| -> Result<Vec<(String, GuidePoint)>, Error> {
        let one = |(index, (name, from)): (usize, (String, Point3<f64>))| {
            Ok((name, guide(index, &from).map_err(|source| at_touch(index, source))?))
        };
        all.into_iter().enumerate().map(one).collect()
    };
    let (points, beside) = match of {
        GuidePlaces::Touches => {
            // Where the ball was sent, if that is known.
            let from = touches.balls.iter().map(|ball| {
                let xy = ball.guide_mm.unwrap_or(ball.center_mm.xy());
                Point3::new(xy.x, xy.y, ball.center_mm.z)
            });
            (named(touches.names.iter().cloned().zip(from).collect())?, 0)
        }
        GuidePlaces::Named(all) => (named(all.clone())?, 0),
        GuidePlaces::Lattice => {
            let places = lattice(case)?;
            let mut found: Vec<GuidePoint> = places
                .iter()
                .enumerate()
                .filter_map(|(index, from)| guide(index, from).ok())
                .filter(|point| point.inside_aperture)
                .collect();
            // A ball that comes from above does not touch what faces down.
            if found.iter().any(|point| point.normal.z > 0.0) {
                found.retain(|point| point.normal.z > 0.0);
            }
            let beside = places.len() - found.len();
            let name = |n: usize| format!("G{}", n + 1);
            (found.into_iter().enumerate().map(|(n, point)| (name(n), point)).collect(), beside)
        }
    };
    Ok(GuidesOfCase { tip_radius_mm, points, beside })
}

/// Places of the lattice of `[plan]`, row by row.
fn lattice(case: &ProbeCase) -> Result<Vec<Point3<f64>>, Error> {
    let nominal = &case.surface.nominal;
    let foot = |at: &Point3<f64>| {
        let foot = nominal.foot(at).ok().filter(|foot| foot.inside_aperture)?;
        Some(Place { contact_mm: foot.point_mm, normal: foot.normal })
    };
    let contacts: Vec<Point3<f64>> = (case.touches.balls.iter())
        .filter_map(|ball| foot(&ball.center_mm))
        .map(|place| place.contact_mm)
        .collect();
    let Some(places) = case.plan.places(&contacts, ACROSS, foot) else {
        let message = format!("[plan] makes more than {MOST_PLACES} places; widen `spacing_mm`");
        return Err(Error::case(case.document.clone(), Problem::WrongValue { message }));
    };
    let mut balls: Vec<Point3<f64>> = (places.iter())
        .map(|place| place.contact_mm + place.normal.into_inner() * case.tip_radius_mm)
        .collect();
    balls.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    Ok(balls)
}
