//! How finely numbers are recorded.

/// Decimals beyond these are not looked for.
const MOST_DECIMALS: i32 = 9;

/// What doubles leave of a decimal number, relative to it.
const ROUND_OFF: f64 = 4e-15;

/// What they leave, in units of the last decimal, of a difference of larger ones.
const OF_DIFFERENCES: f64 = 1e-6;

/// The largest power of ten, at most 1, of which all numbers are whole multiples: the last decimal
/// that was recorded. 0 where there is none: the numbers are no rounded decimals, or there are none.
///
/// ```
/// assert_eq!(model_discrepancy::resolution_of([12.5, 0.031, -4.0]), 1e-3);
/// assert_eq!(model_discrepancy::resolution_of([1.0 / 3.0, 2.0]), 0.0);
/// ```
pub fn resolution_of(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut decimals = 0;
    let mut any = false;
    for value in values {
        any = true;
        while !is_whole(value, decimals) {
            decimals += 1;
            if decimals > MOST_DECIMALS {
                return 0.0;
            }
        }
    }
    if any { 10.0_f64.powi(decimals).recip() } else { 0.0 }
}

fn is_whole(value: f64, decimals: i32) -> bool {
    let scaled = value * 10.0_f64.powi(decimals);
    (scaled - scaled.round()).abs() <= OF_DIFFERENCES + ROUND_OFF * scaled.abs()
}
