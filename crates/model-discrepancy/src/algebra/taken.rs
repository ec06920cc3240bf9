//! What columns take off values beside others: for catalogues that depend on what the data show.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::count::count;

/// What some columns take off values, beside what others have taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// Sum of squares that they take.
    square: f64,
    /// Sum of squares that all of them leave.
    left: f64,
    /// Values less directions of all columns.
    dof: usize,
}

impl Taken {
    /// `columns`, one value per value each, beside `beside`; columns that the others hold take nothing.
    ///
    /// # Panics
    ///
    /// If a column is not as long as `values`.
    #[must_use]
    pub fn beside(beside: &[Vec<f64>], columns: &[Vec<f64>], values: &[f64]) -> Self {
        let n = values.len();
        let matrix = |of: &[Vec<f64>]| DMatrix::from_fn(n, of.len(), |i, j| of[j][i]);
        let before = Basis::of(&matrix(beside), NEW_DIRECTION);
        let all = before.with(&matrix(columns), NEW_DIRECTION);
        let values = DVector::from_column_slice(values);
        let left = all.reject(&values).norm_squared();
        let square = before.reject(&values).norm_squared() - left;
        Self { square: square.max(0.0), left, dof: n.saturating_sub(all.dim()) }
    }

    /// Share that they take of the sum of squares that the others leave.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.square / (self.square + self.left)
    }

    /// Root of the square in standard uncertainties of one value, as what is left has it; of one column the amplitude
    /// over its standard uncertainty.
    #[must_use]
    pub fn in_sigmas(&self) -> f64 {
        (self.square * count(self.dof) / self.left).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::Taken;

    /// Amplitude over its standard uncertainty of a straight line through five points, by hand.
    #[test]
    fn it_is_the_amplitude_over_its_standard_uncertainty() {
        let ones = vec![1.0; 5];
        let x = vec![-2.0, -1.0, 0.0, 1.0, 2.0];
        let values = [1.0, 2.0, 4.0, 4.0, 6.0];
        let taken = Taken::beside(std::slice::from_ref(&ones), std::slice::from_ref(&x), &values);
        // Slope 1.2, squares left 0.8 of three degrees of freedom, Σx² = 10.
        let expected = 1.2 / (0.8_f64 / 3.0 / 10.0).sqrt();
        assert!((taken.in_sigmas() - expected).abs() < 1e-12 * expected);
        assert_eq!(taken.dof, 3);
        let nothing = Taken::beside(&[ones, x.clone()], &[x], &values);
        assert!(nothing.share() < 1e-12 && nothing.dof == 3);
    }
}
