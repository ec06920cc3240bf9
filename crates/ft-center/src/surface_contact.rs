//! Contact on a curved workpiece that stands on the sensor: the live monitoring of \[A\].

use geometry::{Line, Surface, Wrench};
use nalgebra::{Isometry3, Point3, Unit, Vector3};

use crate::FtCenterError;
use crate::error::require_positive;

/// Start of the ray towards the workpiece, from the point of the line of action closest to the
/// workpiece's origin.
const START_MM: f64 = 1e4;

/// Force along the couple's axis over the force, under which the couple cannot be told.
const MIN_ALONG: f64 = 1e-3;

/// The point has settled when it moves by less than this share of its distance from the origin.
const SETTLED: f64 = 1e-13;

const MAX_ITERATIONS: usize = 50;

/// Which way the couple of a spinning pad points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CoupleAxis {
    /// Along the surface normal at the contact: a pad that lies on the surface. On a plane this
    /// is (1.11).
    Normal,
    /// Along an axis of the sensor frame: a spindle that is not normal to the surface.
    Axis(Unit<Vector3<f64>>),
    /// Along the force: the plain line of action. Friction then drags the point aside by
    /// couple × lateral force / force².
    Force,
}

/// Where a wrench acts on a workpiece.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceContact {
    /// Contact point, workpiece frame.
    pub point_mm: Point3<f64>,
    /// Unit normal of the surface there, workpiece frame, as the surface directs it.
    pub normal: Unit<Vector3<f64>>,
    /// Force into the surface.
    pub normal_force_n: f64,
    /// Force along the surface.
    pub tangential_force_n: f64,
    /// Couple about its axis.
    pub couple_nmm: f64,
}

/// Point of a workpiece's surface through which a wrench acts.
///
/// Solves `p × F + m a = M` for the point `p` of the surface and the couple `m` about the axis
/// `a`: three equations, exactly determined, where (1.11) of \[A\] is the case of a plane. The wrench
/// is that *on* the sensor, so that its force points into the workpiece; of several crossings
/// the one that the force enters first counts. Does not allocate.
///
/// # Errors
///
/// [`FtCenterError::NoContact`] when the force is under `min_force_n` or does not press into the
/// surface, [`FtCenterError::Surface`] when the line of action misses, and
/// [`FtCenterError::ContactNotConverged`].
pub fn contact_on_surface(
    wrench: &Wrench,
    surface: &dyn Surface,
    workpiece_from_sensor: &Isometry3<f64>,
    couple_axis: CoupleAxis,
    min_force_n: f64,
) -> Result<SurfaceContact, FtCenterError> {
    require_positive(min_force_n, "min_force_n")?;
    if let Some(index) = wrench.to_vector().iter().position(|v| !v.is_finite()) {
        return Err(FtCenterError::NotFinite { index });
    }
    let size_n = wrench.force_n.norm();
    if size_n < min_force_n {
        return Err(FtCenterError::NoContact { fz_n: size_n, min_fz_n: min_force_n });
    }
    let wrench = wrench.in_frame(workpiece_from_sensor);
    let mut axis = match couple_axis {
        CoupleAxis::Axis(axis) => workpiece_from_sensor.rotation * axis,
        CoupleAxis::Normal | CoupleAxis::Force => Unit::new_normalize(wrench.force_n),
    };
    let mut last = None;
    let mut step_mm = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let (line, couple_nmm) = line_without_couple(&wrench, &axis)?;
        let hit = surface.first_hit(&line)?;
        let into_n = -wrench.force_n.dot(&hit.normal);
        if into_n < MIN_ALONG * size_n {
            return Err(FtCenterError::NoContact { fz_n: into_n, min_fz_n: min_force_n });
        }
        step_mm = last.map_or(f64::INFINITY, |p: Point3<f64>| (hit.point_mm - p).norm());
        if couple_axis != CoupleAxis::Normal
            || step_mm <= SETTLED * (1.0 + hit.point_mm.coords.norm())
        {
            let along = hit.normal.into_inner() * into_n;
            return Ok(SurfaceContact {
                point_mm: hit.point_mm,
                normal: hit.normal,
                normal_force_n: into_n,
                tangential_force_n: (wrench.force_n + along).norm(),
                couple_nmm,
            });
        }
        last = Some(hit.point_mm);
        axis = hit.normal;
    }
    Err(FtCenterError::ContactNotConverged { step_mm, iterations: MAX_ITERATIONS })
}

/// Ray along the force through where it acts once the couple about `axis` is taken off.
fn line_without_couple(
    wrench: &Wrench,
    axis: &Unit<Vector3<f64>>,
) -> Result<(Line, f64), FtCenterError> {
    let along_n = axis.dot(&wrench.force_n);
    let size_n = wrench.force_n.norm();
    if along_n.abs() < MIN_ALONG * size_n {
        return Err(FtCenterError::NoContact { fz_n: along_n, min_fz_n: MIN_ALONG * size_n });
    }
    // What is left has no moment along the force: m = (M·F)/(a·F).
    let couple_nmm = wrench.torque_nmm.dot(&wrench.force_n) / along_n;
    let torque_nmm = wrench.torque_nmm - axis.into_inner() * couple_nmm;
    let mut line = Wrench { torque_nmm, ..*wrench }.line_of_action()?.line;
    line.point_mm = line.at(-START_MM);
    Ok((line, couple_nmm))
}
