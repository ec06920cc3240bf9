//! Interval of a probability from counts.

/// 97.5 % point of the normal distribution.
const Z: f64 = 1.959_964;

/// Wilson's score interval with 95 % coverage (1927).
pub(crate) fn interval(hits: usize, trials: usize) -> (f64, f64) {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let (n, p) = (trials as f64, hits as f64 / trials as f64);
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    ((middle - half) / scale, (middle + half) / scale)
}

#[cfg(test)]
mod tests {
    use super::interval;

    /// No event in 200 trials: the upper end is z²/(n + z²).
    #[test]
    fn no_event_still_has_an_upper_end() {
        let (low, high) = interval(0, 200);
        assert!(low.abs() < 1e-12);
        assert!((high - 3.8415 / 203.8415).abs() < 1e-6);
    }
}
