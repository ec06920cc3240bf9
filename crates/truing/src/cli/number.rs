//! Numbers of the command line that are refused before anything is computed from them.

use std::ops::RangeInclusive;

/// Largest length, in mm: a kilometre is beyond any machine.
pub(super) const MAX_LENGTH_MM: f64 = 1e6;
/// Largest angle: what is turned further is a slip.
pub(super) const MAX_ANGLE_DEG: f64 = 360.0;
/// Beyond these a positive number is a slip, and its square or inverse near the end of an `f64`.
const POSITIVE: RangeInclusive<f64> = 1e-12..=1e12;
/// Chords closer than a nanometre to their arc are more than any program can hold.
const CHORD_MM: RangeInclusive<f64> = 1e-6..=1e3;
/// Decimals that a controller may read.
const DECIMALS: RangeInclusive<usize> = 0..=9;

/// A number within limits.
pub(super) fn within(text: &str, limits: &RangeInclusive<f64>) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|v| limits.contains(v));
    number
        .ok_or_else(|| format!("expected a number from {:e} to {:e}", limits.start(), limits.end()))
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    within(text, &POSITIVE)
        .map_err(|_| format!("expected a positive number up to {:e}", POSITIVE.end()))
}

pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    within(text, &(0.0..=*POSITIVE.end()))
        .map(f64::abs)
        .map_err(|_| format!("expected zero or a positive number up to {:e}", POSITIVE.end()))
}

pub(super) fn share(text: &str) -> Result<f64, String> {
    within(text, &(f64::MIN_POSITIVE..=1.0))
        .map_err(|_| "expected a share above 0, at most 1".to_owned())
}

pub(super) fn chord(text: &str) -> Result<f64, String> {
    within(text, &CHORD_MM)
}

pub(super) fn decimals(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok().filter(|n| DECIMALS.contains(n));
    number.ok_or_else(|| format!("expected a whole number up to {}", DECIMALS.end()))
}
