//! Numbers in single precision, rounded so that they are surely not above, or not below.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

/// Beyond the rounding of the cast and of this very addition.
const OUTWARDS: f32 = 2e-7;

#[expect(clippy::cast_possible_truncation, reason = "rounded away from the box")]
#[inline(always)]
pub(crate) fn below(x: f64) -> f32 {
    let x = x as f32;
    x - (x.abs() * OUTWARDS + f32::MIN_POSITIVE)
}

#[expect(clippy::cast_possible_truncation, reason = "rounded away from the box")]
#[inline(always)]
pub(crate) fn above(x: f64) -> f32 {
    let x = x as f32;
    x + (x.abs() * OUTWARDS + f32::MIN_POSITIVE)
}
