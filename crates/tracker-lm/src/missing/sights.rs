//! Geometry of every range at a solution.

use least_squares::BorderedPoint;
use nalgebra::{Vector3, Vector6};

use crate::RotaryAxis;
use crate::joint::Joint;
use crate::shift::Shift;

/// Nearer to the axis than this a reflector has no side that faces outward.
const ON_AXIS_MM: f64 = 1.0;

/// Geometry of one range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// `|P − S| − (l + L)`.
    pub(crate) residual_mm: f64,
    /// From the station to the target.
    pub(crate) along_mm: Vector3<f64>,
    /// Its unit vector.
    pub(crate) beam: Vector3<f64>,
    /// Derivative by the six errors of its angle.
    pub(crate) by_error: Vector6<f64>,
    /// Derivative by the reflector's place in the turning frame.
    pub(crate) by_mount: Vector3<f64>,
    /// Cosine between the beam and the direction in which the reflector looks.
    pub(crate) cosine: f64,
}

/// Geometry of all ranges, in the order of the survey.
pub(crate) fn sights(joint: &Joint<'_>, at: &BorderedPoint) -> Vec<Sight> {
    let survey = joint.network.survey;
    let carrier = joint.network.carrier();
    let mut sights: Vec<Option<Sight>> = vec![None; survey.ranges.len()];
    for (angle, ranges) in joint.ranges_of.iter().enumerate() {
        let block = &at.blocks[6 * angle..6 * angle + 6];
        for &range in ranges {
            let range = range as usize;
            let slopes = joint.slopes_at(range, angle, &at.shared, block);
            let body = joint.body_mm(range, &at.shared);
            sights[range] = Some(Sight {
                residual_mm: slopes.residual_mm,
                along_mm: slopes.along_mm,
                beam: slopes.beam,
                by_error: Vector6::from_iterator(
                    slopes.beam.iter().chain(slopes.by_rotation.iter()).copied(),
                ),
                by_mount: slopes.by_mount,
                // `by_mount` is the beam seen from the turning frame.
                cosine: slopes.by_mount.dot(&outward(carrier, &body)),
            });
        }
    }
    sights
        .into_iter()
        .map(|s| s.expect("every range has a step, and every step an angle"))
        .collect()
}

/// Residuals of all ranges without what `shifts` move, as far as rows are linear, mm.
pub(crate) fn without(shifts: &[Shift], sights: &[Sight]) -> Vec<f64> {
    let mut residuals: Vec<f64> = sights.iter().map(|s| s.residual_mm).collect();
    for ((residual, sight), shift) in residuals.iter_mut().zip(sights).zip(shifts) {
        *residual -= sight.by_error.dot(&shift.error) - sight.beam.dot(&shift.station_mm)
            + sight.by_mount.dot(&shift.mount_mm);
    }
    residuals
}

/// Direction in which a reflector is taken to look, in the turning frame.
pub(crate) fn outward(axis: &RotaryAxis, body_mm: &Vector3<f64>) -> Vector3<f64> {
    let axis = axis.direction.into_inner();
    let radial = body_mm - axis * axis.dot(body_mm);
    if radial.norm() > ON_AXIS_MM { radial.normalize() } else { axis }
}
