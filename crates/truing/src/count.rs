//! Counts as real numbers, and what is divided by them.

/// A count as a real number.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn count(n: usize) -> f64 {
    n as f64
}

/// Root mean square; zero of nothing.
pub(crate) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (n, squares) = values.fold((0, 0.0), |(n, sum), value| (n + 1, sum + value * value));
    (squares / count(n.max(1))).sqrt()
}
