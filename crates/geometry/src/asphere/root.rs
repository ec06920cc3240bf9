/// Root of a monotone function whose sign differs at `lo` and `hi`, to the last bit or two.
///
/// Newton steps, replaced by bisection where they leave the bracket or shrink too slowly.
/// `value_and_slope` gives the function and its derivative.
pub(super) fn bracketed(
    value_and_slope: impl Fn(f64) -> (f64, f64),
    mut lo: f64,
    mut hi: f64,
    start: f64,
) -> f64 {
    let rising = value_and_slope(lo).0 < value_and_slope(hi).0;
    let mut at = start.clamp(lo, hi);
    let mut last_step = hi - lo;
    // Halving alone needs 53 steps for the bits of one binade, and some more to reach a small root.
    for _ in 0..128 {
        let (value, slope) = value_and_slope(at);
        if (value < 0.0) == rising {
            lo = at;
        } else {
            hi = at;
        }
        let newton = at - value / slope;
        let good = newton >= lo && newton <= hi && (newton - at).abs() <= 0.5 * last_step.abs();
        let next = if good { newton } else { 0.5 * (lo + hi) };
        last_step = next - at;
        at = next;
        if last_step.abs() <= f64::EPSILON * at.abs() || value == 0.0 {
            break;
        }
    }
    at
}
