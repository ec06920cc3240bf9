//! The lateral force that effects of a press follow.

use nalgebra::{Matrix2, Vector2};

use crate::SolvedPress;
use crate::missing::press_design::load_of;

/// Times by which what is known of a lateral force exceeds its noise, at least.
///
/// The noise of Fx is in the centre too, times z0/Fz. A height that follows forces of which a share
/// 1/T² is noise is wrong by z0/T², −z0 where they are nothing else: 1 % of z0.
pub(crate) const CLEAR: f64 = 10.0;

/// Lever by which the noise of a lateral force is in the centre, at least, mm: over a lower plane it is
/// lost in the noise of the moments, and no centre says how large it is.
pub(crate) const LEAST_LEVER_MM: f64 = 10.0;

/// Lateral force of each press, sensor frame, N, as effects follow it: as read along an axis along
/// which presses differ by clearly more than noise, else the mean of all, or nothing where noise
/// alone makes such a mean.
///
/// `covariances_mm2` are those of the centres: the noise of a lateral force is no larger than theirs
/// times Fz/z0, of which it is a part.
pub(crate) fn drags(
    presses: &[SolvedPress],
    covariances_mm2: &[Matrix2<f64>],
    z0_mm: f64,
) -> Vec<Vector2<f64>> {
    let read: Vec<Vector2<f64>> =
        presses.iter().map(|p| p.orbit.mean_wrench.force_n.xy()).collect();
    let n = crate::count(read.len());
    let mean = read.iter().sum::<Vector2<f64>>() / n;
    let squares = |v: Vector2<f64>| v.component_mul(&v);
    let spread = read.iter().map(|f| squares(f - mean)).sum::<Vector2<f64>>() / n;
    let lever_mm = z0_mm.abs().max(LEAST_LEVER_MM);
    let noise = |(p, c): (&SolvedPress, &Matrix2<f64>)| {
        c.diagonal() * (load_of(&p.orbit.mean_wrench) / lever_mm).powi(2)
    };
    let noise = presses.iter().zip(covariances_mm2).map(noise).sum::<Vector2<f64>>() / n;
    let clear = |axis: usize, square: f64| square > CLEAR * CLEAR * noise[axis];
    let drag = |f: &Vector2<f64>| {
        Vector2::from_fn(|axis, _| match () {
            () if clear(axis, spread[axis]) => f[axis],
            () if clear(axis, n * mean[axis].powi(2)) => mean[axis],
            () => 0.0,
        })
    };
    read.iter().map(drag).collect()
}
