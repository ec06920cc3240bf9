use least_squares::BorderedProblem;

/// A bordered problem that says which of its rows are readings.
pub(crate) trait Readings: BorderedProblem {
    /// Rows of a block that are ranges: its first.
    fn range_count(&self, block: usize) -> usize;
}
