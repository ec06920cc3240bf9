//! Numbers of the command line that are refused before anything is computed from them.

use std::ops::RangeInclusive;

use truing::PlanBudget;

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

/// Most measurements, and most minutes, that anybody plans at once.
const MOST_BUDGET: f64 = 1e6;

/// Measurements as `12`, minutes as `30min`.
pub(super) fn budget(text: &str) -> Result<PlanBudget, String> {
    let text = text.trim();
    let minutes = text.strip_suffix("minutes").or_else(|| text.strip_suffix("min"));
    let of_minutes = |minutes: &str| {
        let minutes = minutes.trim().parse::<f64>().ok();
        minutes.filter(|m| *m > 0.0 && *m <= MOST_BUDGET).map(PlanBudget::Minutes)
    };
    let of_count = || {
        let count = text.parse::<u32>().ok().filter(|n| *n > 0 && f64::from(*n) <= MOST_BUDGET)?;
        Some(PlanBudget::Measurements(usize::try_from(count).ok()?))
    };
    minutes.map_or_else(of_count, of_minutes).ok_or_else(|| {
        format!(
            "expected a number of measurements, as 12, or minutes, as 30min, up to {MOST_BUDGET:e}"
        )
    })
}

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

/// Two numbers with a comma between them.
pub(super) fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let both = text.split_once(',').and_then(|(a, b)| Some([number(a)?, number(b)?]));
    both.ok_or_else(|| "expected two numbers with a comma between them, as 0.02,0".to_owned())
}

/// A point: three lengths with commas between them.
pub(super) fn triple(text: &str) -> Result<[f64; 3], String> {
    let number = |text: &str| within(text, &(-MAX_LENGTH_MM..=MAX_LENGTH_MM)).ok();
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    three
        .ok_or_else(|| format!("expected three lengths in mm up to {MAX_LENGTH_MM:e}, as 0,0,-250"))
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
