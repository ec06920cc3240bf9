//! What the columns of a system are about.

use nalgebra::{DMatrix, DVector};

use crate::{Model, State};

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
    /// A coordinate of the place, or a time constant, at which an effect was found by looking: the sum
    /// over its amplitudes of each times its column of [`Effect::by_place`](crate::Effect::by_place).
    /// The place itself is no part of a state.
    Place {
        /// Index into the catalogue.
        effect: usize,
        /// Index into its coordinates.
        coordinate: usize,
    },
    /// A coefficient of an entry of [`Closure::empirical`](crate::Closure::empirical).
    Empirical {
        /// Index into [`Closure::empirical`](crate::Closure::empirical).
        correction: usize,
        /// Index into its coefficients.
        coefficient: usize,
    },
}

impl Column {
    /// What a unit of a coordinate of a place adds to every row of the residual; `None` of others.
    #[must_use]
    pub fn of_place(&self, model: &dyn Model, at: &State) -> Option<DVector<f64>> {
        let Self::Place { effect, coordinate } = *self else { return None };
        let by_place = &model.declared().effects[effect].by_place;
        let amplitudes = at.amplitudes[effect].iter();
        let each = by_place.iter().zip(amplitudes).map(|(by, a)| by.column(coordinate) * *a);
        each.reduce(|sum, column| sum + column)
    }
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
