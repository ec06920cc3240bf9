use nalgebra::{Matrix3, Point2, Point3, Unit, Vector3};
use rayon::prelude::*;

use crate::contact::PlannedContact;
use crate::foot::foot_of_ball;
use crate::guide::meet_along_z;
use crate::nearest::Nearest;
use crate::neighbours::{LocalShape, MeasuredNormal, measured_normal};
use crate::nominal::NominalFoot;
use crate::profile::profile_normals;
use crate::{BallTouch, Contact, InvalidTouch, Nominal, ProbeError};

/// The normal along which a ball is compensated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum NormalSource {
    /// Of the nominal surface at the ball's foot.
    ///
    /// Right to second order: a part whose slope is off by δ is misjudged by r δ²/2.
    #[default]
    Nominal,
    /// The direction of approach, reversed: right only where the machine probes along the normal.
    ///
    /// An approach at an angle θ to the normal costs r (1 − cos θ).
    Approach,
    /// Of the plane through the ball's centres around the touch: through three exactly, through
    /// more by least squares.
    ///
    /// Three points are off by r ρ |κ1 − κ2|/4 along the surface, four symmetric ones are not.
    MicroPlane,
    /// Of the quadric through the ball's centres at and around the touch, five or more around it.
    Quadric,
    /// Of the offset surface through all touches: at each, the quadric through it and the twelve
    /// nearest others. For scans, without touches of their own around each place.
    SurfaceFit,
    /// Of the profile on which all touches lie, in one row of the xy plane: at each, the parabola through it
    /// and its two neighbours (document \[E\], 2-D). For a part that does not change across the row.
    Profile,
}

/// Coordinates from this magnitude on are slips.
const MAX_COORDINATE_MM: f64 = 1e9;
/// Contacts of a ball of radius `tip_radius_mm`, in the order of `touches`.
///
/// # Errors
///
/// The first touch that cannot be compensated: [`ProbeError::InvalidTouch`],
/// [`ProbeError::NoFoot`], [`ProbeError::TipTooLarge`], [`ProbeError::FarFromSurface`],
/// [`ProbeError::NoGuide`], and those of the normal that is asked for.
pub fn compensate(
    nominal: &Nominal,
    tip_radius_mm: f64,
    touches: &[BallTouch],
    source: NormalSource,
) -> Result<Vec<Contact>, ProbeError> {
    if !(0.0..MAX_COORDINATE_MM).contains(&tip_radius_mm) {
        return Err(ProbeError::InvalidTip { radius_mm: tip_radius_mm });
    }
    for (index, touch) in touches.iter().enumerate() {
        check(index, touch)?;
    }
    let centers: Vec<Point3<f64>> = if source == NormalSource::SurfaceFit {
        touches.iter().map(|touch| touch.center_mm).collect()
    } else {
        Vec::new()
    };
    let profile = if source == NormalSource::Profile && !touches.is_empty() {
        let row: Vec<Point3<f64>> = touches.iter().map(|touch| touch.center_mm).collect();
        profile_normals(&row)?
    } else {
        Vec::new()
    };
    let task = Task { nominal, tip_radius_mm, source, nearest: Nearest::new(&centers), profile };
    // Which error comes first must not depend on threads.
    let each: Vec<_> =
        touches.par_iter().enumerate().map(|(index, touch)| task.one(index, touch)).collect();
    let is_far =
        |one: &&Result<Contact, ProbeError>| matches!(one, Err(ProbeError::FarFromSurface { .. }));
    let n_far = each.iter().filter(is_far).count();
    each.into_iter().collect::<Result<_, _>>().map_err(|error| among(error, n_far, touches.len()))
}

/// The error of one touch that lies far off, as one of so many.
fn among(error: ProbeError, n_far: usize, n_touches: usize) -> ProbeError {
    match error {
        ProbeError::FarFromSurface { index, gap_mm, limit_mm, .. } => {
            ProbeError::FarFromSurface { index, gap_mm, limit_mm, far: n_far, of: n_touches }
        }
        other => other,
    }
}

/// What is the same for every touch.
struct Task<'a> {
    nominal: &'a Nominal,
    tip_radius_mm: f64,
    source: NormalSource,
    nearest: Nearest<'a>,
    /// Normals of a profile, upwards, one per touch.
    profile: Vec<MeasuredNormal>,
}

/// Touches around one that a surface through all of them goes by.
const SURFACE_NEIGHBOURS: usize = 12;

impl Task<'_> {
    fn one(&self, index: usize, touch: &BallTouch) -> Result<Contact, ProbeError> {
        let foot = foot_of_ball(self.nominal, self.tip_radius_mm, index, &touch.center_mm)?;
        let away = |approach: &Unit<Vector3<f64>>| approach.dot(&foot.normal) >= 0.0;
        if let Some(approach) = touch.approach.as_ref().filter(|a| away(a)) {
            let angle_deg = approach.angle(&-foot.normal.into_inner()).to_degrees();
            let reason = InvalidTouch::LeadsAway { angle_deg };
            return Err(ProbeError::InvalidTouch { index, reason });
        }
        let mut contact = self.contact(index, touch, &foot)?;
        contact.planned = touch
            .guide_mm
            .map(|guide_mm| self.planned(index, touch, guide_mm, &contact.point_mm))
            .transpose()?;
        Ok(contact)
    }

    fn contact(
        &self,
        index: usize,
        touch: &BallTouch,
        foot: &NominalFoot,
    ) -> Result<Contact, ProbeError> {
        let measured = |neighbours: &[Point3<f64>], shape| {
            let found = measured_normal(index, &touch.center_mm, neighbours, &foot.normal, shape)?;
            let spread = found.spread_per_mm2 * self.tip_radius_mm.powi(2);
            along(self.nominal, index, touch, self.tip_radius_mm, found.normal, spread)
        };
        match self.source {
            NormalSource::Nominal => Ok(along_nominal(touch, foot, self.tip_radius_mm)),
            NormalSource::Approach => {
                let approach = touch.approach.ok_or(ProbeError::NoApproach { index })?;
                along(self.nominal, index, touch, self.tip_radius_mm, -approach, Matrix3::zeros())
            }
            NormalSource::MicroPlane => measured(&touch.micro_mm, LocalShape::Plane),
            NormalSource::Quadric => measured(&touch.micro_mm, LocalShape::Quadric),
            NormalSource::Profile => {
                let found = self.profile[index];
                let side = found.normal.dot(&foot.normal).signum();
                let normal = Unit::new_unchecked(found.normal.into_inner() * side);
                let spread = found.spread_per_mm2 * self.tip_radius_mm.powi(2);
                along(self.nominal, index, touch, self.tip_radius_mm, normal, spread)
            }
            NormalSource::SurfaceFit => {
                measured(&self.nearest.around(index, SURFACE_NEIGHBOURS), LocalShape::Quadric)
            }
        }
    }

    fn planned(
        &self,
        index: usize,
        touch: &BallTouch,
        guide_mm: Point2<f64>,
        contact_mm: &Point3<f64>,
    ) -> Result<PlannedContact, ProbeError> {
        let from_z_mm = touch.center_mm.z;
        let (center_mm, foot) = meet_along_z(self.nominal, self.tip_radius_mm, guide_mm, from_z_mm)
            .ok_or(ProbeError::NoGuide { index })?;
        let error_mm = contact_mm - foot.point_mm;
        Ok(PlannedContact {
            center_mm,
            point_mm: foot.point_mm,
            error_mm,
            normal_error_mm: foot.normal.dot(&error_mm),
        })
    }
}

pub(crate) fn check(index: usize, touch: &BallTouch) -> Result<(), ProbeError> {
    let coordinates = touch.center_mm.iter().chain(touch.micro_mm.iter().flat_map(|p| p.iter()));
    let guide = touch.guide_mm.iter().flat_map(|p| p.iter());
    if let Some(&value) = coordinates.chain(guide).find(|v| {
        let sane = v.abs() < MAX_COORDINATE_MM;
        !sane
    }) {
        let reason = InvalidTouch::Coordinate { value, limit: MAX_COORDINATE_MM };
        return Err(ProbeError::InvalidTouch { index, reason });
    }
    if !(touch.sigma_mm > 0.0 && touch.sigma_mm.is_finite()) {
        let reason = InvalidTouch::Sigma { sigma_mm: touch.sigma_mm };
        return Err(ProbeError::InvalidTouch { index, reason });
    }
    Ok(())
}

fn along_nominal(touch: &BallTouch, foot: &NominalFoot, tip_radius_mm: f64) -> Contact {
    Contact {
        center_mm: touch.center_mm,
        point_mm: touch.center_mm - foot.normal.into_inner() * tip_radius_mm,
        normal: foot.normal,
        nominal_mm: foot.point_mm,
        nominal_normal: foot.normal,
        deviation_mm: foot.distance_mm - tip_radius_mm,
        covariance_mm2: Matrix3::identity() * touch.sigma_mm.powi(2),
        inside_aperture: foot.inside_aperture,
        planned: None,
    }
}

/// Compensated along a normal whose covariance, times the radius squared, is `spread` times the
/// variance of a coordinate.
fn along(
    nominal: &Nominal,
    index: usize,
    touch: &BallTouch,
    tip_radius_mm: f64,
    normal: Unit<Vector3<f64>>,
    spread: Matrix3<f64>,
) -> Result<Contact, ProbeError> {
    let point_mm = touch.center_mm - normal.into_inner() * tip_radius_mm;
    let foot = nominal.foot(&point_mm).map_err(|source| ProbeError::NoFoot { index, source })?;
    Ok(Contact {
        center_mm: touch.center_mm,
        point_mm,
        normal,
        nominal_mm: foot.point_mm,
        nominal_normal: foot.normal,
        deviation_mm: foot.distance_mm,
        covariance_mm2: (Matrix3::identity() + spread) * touch.sigma_mm.powi(2),
        inside_aperture: foot.inside_aperture,
        planned: None,
    })
}
