//! What readings scatter inside the observations that are means of them.

/// Scatter of readings about what their observations, means of them, read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// Sum of squares in units of the declared standard uncertainty of a reading.
    pub chi2: f64,
    /// Readings minus observations.
    pub dof: f64,
    /// Share of the readings that are independent of each other, see
    /// [`GlobalTest::share`](crate::GlobalTest::share).
    pub share: f64,
}
