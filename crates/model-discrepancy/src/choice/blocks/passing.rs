//! What of the catalogue the F test lets pass without a block.

/// What may be significant.
pub(crate) enum Passing {
    /// Nothing.
    Nothing,
    /// These effects at most, which move many observations; no test of another could be significant.
    These(Vec<One>),
    /// Sums do not say: any effect, or two of them.
    Any,
}

/// An effect that may be.
pub(crate) struct One {
    /// Index into the catalogue.
    pub(crate) effect: usize,
    pub(crate) class: usize,
    /// By how much its p-value counts more for how much else is looked at.
    pub(crate) trials: f64,
}
