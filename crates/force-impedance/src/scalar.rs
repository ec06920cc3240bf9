//! The one function of the real-time path that `core` lacks.

use nalgebra::Vector3;

/// Square root: an instruction with `std`, `libm` without.
#[inline]
pub(crate) fn sqrt(x: f64) -> f64 {
    #[cfg(feature = "std")]
    {
        x.sqrt()
    }
    #[cfg(not(feature = "std"))]
    {
        libm::sqrt(x)
    }
}

/// Euclidean length.
#[inline]
pub(crate) fn norm(v: &Vector3<f64>) -> f64 {
    sqrt(v.dot(v))
}

/// The part of `v` across the unit vector `axis`.
#[inline]
pub(crate) fn across(v: &Vector3<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
    v - axis * axis.dot(v)
}

/// Whether all three components are finite.
#[inline]
pub(crate) fn is_finite(v: &Vector3<f64>) -> bool {
    v.x.is_finite() && v.y.is_finite() && v.z.is_finite()
}

/// `f64::clamp` without its panic; `high` wins where the two are crossed, `low` where `x` is NaN.
#[inline]
pub(crate) fn between(x: f64, low: f64, high: f64) -> f64 {
    let above = if x > low { x } else { low };
    if above < high { above } else { high }
}
