//! Whether the touches can lie on the part.
//!
//! Where the touches hardly show how far the part lies to the side, an error that the model does not
//! know of moves the estimate by many of its standard uncertainties. A touch is then not refused
//! for where the estimate happens to put it, but only where no place of the part that the touches
//! allow has all of them on its surface.

use geometry::Foot;
use nalgebra::{Point3, Vector2, Vector3};

use crate::{Part, PoseError, PoseFit};

/// A contact may lie outside the aperture by this many of its lateral standard uncertainties.
const OUTSIDE_SIGMAS: f64 = 4.0;
/// Root mean square of an error that all touches have in common, in their standard uncertainties,
/// up to which it is looked for: two digits of noise, what a machine out of adjustment shows.
const SYSTEMATIC_SIGMAS: f64 = 20.0;
/// Share of the part's radius by which touches that are moved together may still lie outside: a tilt
/// that is as uncertain moves them by less.
const RAGGED: f64 = 0.02;
/// Rounds of moving the touches together; a hundred bring them within a micrometre of the edge.
const MAX_ROUNDS: usize = 1000;

/// Refuses the touch that lies farthest outside, where the part cannot lie under all of them.
pub(crate) fn check(part: &Part, fit: &PoseFit) -> Result<(), PoseError> {
    let outside = |contact: &Foot| !contact.inside_aperture;
    if !fit.contacts.iter().any(outside) {
        return Ok(());
    }
    let leeway = Leeway::of(fit);
    let refuses = |contact: &Foot| outside(contact) && !leeway.reaches_inside(part, fit, contact);
    let stuck = if let Some(shape) = part.shape() {
        let center_mm = shape.aperture_center_mm.coords;
        let at_mm: Vec<Vector2<f64>> =
            fit.contacts.iter().map(|c| c.point_mm.coords.xy() - center_mm).collect();
        let edge_mm = 0.5 * shape.diameter_mm;
        let radius_mm = edge_mm + leeway.random_mm.min(RAGGED * edge_mm);
        let beside_map = |contact: &Foot| {
            let off_mm = (contact.point_mm.coords.xy() - center_mm).norm();
            part.has_form_map() && off_mm <= edge_mm && refuses(contact)
        };
        together(&at_mm, radius_mm, leeway.systematic_mm)
            .or_else(|| fit.contacts.iter().position(beside_map))
    } else {
        fit.contacts.iter().position(refuses)
    };
    stuck.map_or(Ok(()), |index| Err(refused(fit, index)))
}

fn refused(fit: &PoseFit, index: usize) -> PoseError {
    let at = fit.contacts[index].point_mm;
    PoseError::OutsideAperture { index, x_mm: at.x, y_mm: at.y }
}

/// How far the part may lie from where it was found, sideways.
struct Leeway {
    /// By the noise alone.
    random_mm: f64,
    /// By an error that the model does not know of.
    systematic_mm: f64,
}

impl Leeway {
    fn of(fit: &PoseFit) -> Self {
        let sigmas = fit.standard_uncertainties();
        let sigma_mm = sigmas.map_or(0.0, |s| s.rows(0, 2).norm());
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = fit.contacts.len() as f64;
        // n touches that are off alike move an estimate by √n times what one of them does, in
        // standard uncertainties.
        let systematic_mm = SYSTEMATIC_SIGMAS * n.sqrt() * sigma_mm;
        Self { random_mm: OUTSIDE_SIGMAS * sigma_mm, systematic_mm }
    }

    /// Whether the noise could place a contact of a part without a round edge inside.
    fn reaches_inside(&self, part: &Part, fit: &PoseFit, contact: &Foot) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = fit.contacts.len() as f64;
        let sum = fit.contacts.iter().fold(Vector3::zeros(), |sum, c| sum + c.point_mm.coords);
        let mut inwards = sum / n - contact.point_mm.coords;
        inwards.z = 0.0;
        let distance_mm = inwards.norm();
        if distance_mm == 0.0 {
            return false;
        }
        let share = self.random_mm.min(distance_mm) / distance_mm;
        let moved = Point3::from(contact.point_mm.coords + inwards * share);
        part.surface().closest_point(&moved).is_ok_and(|foot| part.contains(&foot))
    }
}

/// The point farthest outside, where no common shift of at most `reach_mm` takes all points into a
/// circle about the origin.
///
/// The farthest point is moved to the circle, and all others with it, until all are inside; the
/// shift is then the shortest but for what turns the way costs.
fn together(at_mm: &[Vector2<f64>], radius_mm: f64, reach_mm: f64) -> Option<usize> {
    let mut shift_mm = Vector2::zeros();
    for _ in 0..MAX_ROUNDS {
        let off = |i: &usize| (at_mm[*i] + shift_mm).norm();
        let farthest = (0..at_mm.len()).max_by(|a, b| off(a).total_cmp(&off(b)))?;
        let excess_mm = off(&farthest) - radius_mm * (1.0 + EDGE_SHARE);
        if excess_mm <= 0.0 {
            return None;
        }
        shift_mm -= (at_mm[farthest] + shift_mm).normalize() * (off(&farthest) - radius_mm);
        if shift_mm.norm() > reach_mm {
            break;
        }
    }
    (0..at_mm.len()).max_by(|&a, &b| at_mm[a].norm().total_cmp(&at_mm[b].norm()))
}

/// A point this near the circle, as a share of its radius, is on it: 5 µm of a mirror of 100 mm.
const EDGE_SHARE: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(radius_mm: f64, x_mm: f64) -> Vec<Vector2<f64>> {
        (0..12)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 12.0).sin_cos();
                Vector2::new(x_mm + radius_mm * cos, radius_mm * sin)
            })
            .collect()
    }

    #[test]
    fn a_ring_beside_the_circle_is_moved_into_it() {
        assert_eq!(together(&ring(45.0, 20.0), 50.0, 15.1), None);
        assert_eq!(together(&ring(45.0, 20.0), 50.0, 14.9), Some(0));
        // As large as the circle itself: only one place fits.
        assert_eq!(together(&ring(50.0, 20.0), 50.0, 20.1), None);
    }

    #[test]
    fn a_ring_larger_than_the_circle_is_not() {
        assert_eq!(together(&ring(51.0, 20.0), 50.0, 1e6), Some(0));
        let mut touches = ring(45.0, 0.0);
        touches.push(Vector2::new(0.0, 60.0));
        assert_eq!(together(&touches, 50.0, 1e6), Some(12));
    }
}
