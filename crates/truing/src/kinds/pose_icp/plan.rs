//! Touches that could be made next.

use nalgebra::{Isometry3, Point3};
use pose_icp::{Tip, TipSide};

use super::case::PoseCase;
use super::settings::{POINTS, error};
use super::tables::XYZ;
use crate::Error;
use crate::case::Problem;
use crate::kinds::touching::{ACROSS, MOST_PLACES, Place};
use crate::kinds::{Offer, Offered, PlannedTouch};

/// Share of an aperture's radius that is touched where no region is declared: the ball stays on
/// the part.
const OF_APERTURE: f64 = 0.98;

/// Touches of the part where it lies, along its normal; a part with an aperture is touched all
/// over it.
pub(super) fn offer(
    case: &PoseCase,
    machine_from_part: &Isometry3<f64>,
    tip: Tip,
) -> Result<Offer, Error> {
    let (part, points) = (&case.surface.part, &case.points);
    let sign = match tip.side {
        TipSide::Above => 1.0,
        TipSide::Below => -1.0,
    };
    let aperture =
        part.shape().map(|shape| (shape.aperture_center_mm, 0.5 * OF_APERTURE * shape.diameter_mm));
    let place = |at: &Point3<f64>| {
        let foot = part.surface().closest_point(at).ok()?;
        let (contact_mm, normal) = (foot.point_mm, foot.normal);
        let inside = match aperture {
            Some((center, reach_mm)) => (contact_mm.xy() - center).norm() <= reach_mm,
            None => foot.inside_aperture,
        };
        let normal = nalgebra::Unit::new_unchecked(normal.into_inner() * sign);
        inside.then_some(Place { contact_mm, normal })
    };
    let mut contacts = Vec::with_capacity(points.centers_mm.len());
    for (index, at) in points.centers_mm.iter().enumerate() {
        let local = machine_from_part.inverse_transform_point(at);
        let foot = part.surface().closest_point(&local);
        let foot = foot.map_err(|source| {
            error(points.file.clone(), pose_icp::PoseError::NoFoot { index, source })
        })?;
        contacts.push(foot.point_mm);
    }
    contacts
        .extend(aperture.into_iter().flat_map(|(center, reach_mm)| rim(case, center, reach_mm)));
    let Some(places) = case.plan.places(&contacts, ACROSS, place) else {
        let message = format!("[plan] makes more than {MOST_PLACES} places; widen `spacing_mm`");
        return Err(Error::case(case.document.clone(), Problem::WrongValue { message }));
    };
    let offered: Vec<Offered> = places
        .iter()
        .map(|place| {
            let normal = machine_from_part * place.normal;
            let contact_mm = machine_from_part * place.contact_mm;
            let ball_mm = contact_mm + normal.into_inner() * tip.radius_mm;
            let touch = PlannedTouch {
                contact_mm: place.contact_mm,
                normal: place.normal,
                ball_mm,
                approach: -normal,
                feed_mm_per_min: case.plan.feed(),
                spindle_deg: None,
            };
            let cell =
                |(axis, name): (usize, &'static str)| (name, format!("{:.6}", ball_mm[axis]));
            let cells = XYZ.into_iter().enumerate().map(cell).collect();
            Offered { touch: Some(touch), ..Offered::of_row("point", cells) }
        })
        .collect();
    let balls = offered.iter().filter_map(|o| o.touch).map(|touch| touch.ball_mm.z);
    let highest = balls.chain(points.centers_mm.iter().map(|p| p.z)).fold(f64::MIN, f64::max);
    Ok(Offer {
        table: POINTS,
        readings: XYZ.to_vec(),
        columns: Vec::new(),
        offered,
        noun: "touch",
        is_record: false,
        is_new_session: false,
        controls: Vec::new(),
        undeclared: match aperture {
            // All of it is on offer.
            Some(_) => Vec::new(),
            None => case.plan.undeclared(),
        },
        made: None,
        minutes: case.plan.minutes(),
        reach: (tip.side == TipSide::Above).then(|| case.plan.reach(highest)),
    })
}

/// Points of the rim that the region reaches to.
fn rim(case: &PoseCase, center: nalgebra::Point2<f64>, reach_mm: f64) -> Vec<Point3<f64>> {
    let around = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let at = |[x, y]: [f64; 2]| Point3::new(center.x + reach_mm * x, center.y + reach_mm * y, 0.0);
    let foot = |p: Point3<f64>| case.surface.part.surface().closest_point(&p).ok();
    // The corners of the region in x and y; the height of the rim as the surface has it.
    around
        .into_iter()
        .map(at)
        .map(|p| foot(p).map_or(p, |foot| Point3::new(p.x, p.y, foot.point_mm.z)))
        .collect()
}
