//! Robust losses on whitened residuals.

use std::ops::Range;

/// Loss `ρ(s)` of a squared whitened residual `s`, in place of `s` itself.
///
/// `scale` is in standard uncertainties: residuals well below it count as their squares.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Loss {
    /// Linear beyond `scale`; convex, so it adds no local minima.
    Huber {
        /// Where the loss turns linear.
        scale: f64,
    },
    /// Logarithmic: large residuals fade without ever vanishing.
    Cauchy {
        /// Where the weight is one half.
        scale: f64,
    },
    /// Biweight: no influence at all beyond `scale`.
    Tukey {
        /// Where the weight reaches zero.
        scale: f64,
    },
    /// Geman-McClure: bounded and smooth; influence falls with the cube of the residual.
    GemanMcClure {
        /// Where the weight is one quarter.
        scale: f64,
    },
}

impl Loss {
    /// Huber's loss at the scale that keeps 95 % efficiency on scalar Gaussian residuals.
    #[must_use]
    pub const fn huber_95() -> Self {
        Self::Huber { scale: 1.345 }
    }

    /// Cauchy's loss at the scale that keeps 95 % efficiency on scalar Gaussian residuals.
    #[must_use]
    pub const fn cauchy_95() -> Self {
        Self::Cauchy { scale: 2.385 }
    }

    /// Tukey's loss at the scale that keeps 95 % efficiency on scalar Gaussian residuals.
    #[must_use]
    pub const fn tukey_95() -> Self {
        Self::Tukey { scale: 4.685 }
    }

    /// `(ρ(s), ρ'(s))` at the squared norm `s` of a block; `ρ'` is the block's weight.
    #[must_use]
    pub fn evaluate(self, s: f64) -> (f64, f64) {
        let k2 = self.scale().powi(2);
        match self {
            Self::Huber { .. } if s <= k2 => (s, 1.0),
            Self::Huber { scale } => {
                let norm = s.sqrt();
                (2.0 * scale * norm - k2, scale / norm)
            }
            Self::Cauchy { .. } => (k2 * (s / k2).ln_1p(), 1.0 / (1.0 + s / k2)),
            Self::Tukey { .. } if s >= k2 => (k2 / 3.0, 0.0),
            Self::Tukey { .. } => {
                let u = s / k2;
                (s * (1.0 - u + u * u / 3.0), (1.0 - u).powi(2))
            }
            Self::GemanMcClure { .. } => {
                let shrink = 1.0 / (1.0 + s / k2);
                (s * shrink, shrink.powi(2))
            }
        }
    }

    pub(crate) fn scale(self) -> f64 {
        match self {
            Self::Huber { scale }
            | Self::Cauchy { scale }
            | Self::Tukey { scale }
            | Self::GemanMcClure { scale } => scale,
        }
    }
}

/// Residual rows under a robust loss. Several of them have no row in common.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RobustRows {
    /// Rows concerned; an end past the last residual means the last residual.
    pub rows: Range<usize>,
    /// Rows that are judged by their common norm: 3 where a point gives three rows.
    pub block_rows: usize,
    /// What the squared norm of a block costs.
    pub loss: Loss,
}

impl RobustRows {
    /// Every residual of the problem, in blocks of `block_rows`.
    #[must_use]
    pub fn all(block_rows: usize, loss: Loss) -> Self {
        Self { rows: 0..usize::MAX, block_rows, loss }
    }
}
