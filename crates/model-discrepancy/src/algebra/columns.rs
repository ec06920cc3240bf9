//! What the columns of a system are about.

use nalgebra::{DMatrix, DVector};

/// One row and column of [`Closure::covariance`](crate::Closure::covariance).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Entry of [`State::base`](crate::State::base).
    Base(usize),
    /// A free amplitude: entry `parameter` of [`State::amplitudes`](crate::State::amplitudes) of `effect`.
    Amplitude {
        /// Index into the catalogue.
        effect: usize,
        /// Index into its amplitudes.
        parameter: usize,
    },
    /// A coefficient of an entry of [`Closure::empirical`](crate::Closure::empirical).
    Empirical {
        /// Index into [`Closure::empirical`](crate::Closure::empirical).
        correction: usize,
        /// Index into its coefficients.
        coefficient: usize,
    },
}

/// A correction along a covariate that knows no cause, as fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct EmpiricalCorrection {
    /// Column it follows.
    pub covariate: String,
    /// Its shape in words.
    pub shape: String,
    /// Coefficients of the final model.
    pub coefficients: DVector<f64>,
    /// What one unit of each coefficient adds to every row of the residual, in report units.
    pub columns: DMatrix<f64>,
}

impl EmpiricalCorrection {
    /// What it adds to every row of the residual, in report units.
    #[must_use]
    pub fn added(&self) -> DVector<f64> {
        &self.columns * &self.coefficients
    }
}
