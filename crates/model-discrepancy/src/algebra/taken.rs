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

/// Values from which some columns have taken what they hold.
#[derive(Clone, Debug)]
pub struct Left {
    before: Basis,
    values: DVector<f64>,
}

impl Left {
    /// What columns leave of `values`, one value per value each.
    ///
    /// # Panics
    ///
    /// If a column is not as long as `values`.
    #[must_use]
    pub fn by(columns: &[Vec<f64>], values: &[f64]) -> Self {
        let before = Basis::of(&matrix(columns, values.len()), NEW_DIRECTION);
        let values = before.reject(&DVector::from_column_slice(values));
        Self { before, values }
    }

    /// What is left, value by value.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        self.values.as_slice()
    }

    /// What further columns take of them; those that the first hold take nothing.
    ///
    /// # Panics
    ///
    /// If a column is not as long as the values.
    #[must_use]
    pub fn taken_by(&self, columns: &[Vec<f64>]) -> Taken {
        let n = self.values.len();
        let all = self.before.with(&matrix(columns, n), NEW_DIRECTION);
        let left = all.reject(&self.values).norm_squared();
        let square = (self.values.norm_squared() - left).max(0.0);
        Taken { square, left, dof: n.saturating_sub(all.dim()) }
    }
}

fn matrix(columns: &[Vec<f64>], rows: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i])
}

impl Taken {
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
    use super::Left;

    /// Amplitude over its standard uncertainty of a straight line through five points, by hand.
    #[test]
    fn it_is_the_amplitude_over_its_standard_uncertainty() {
        let ones = vec![1.0; 5];
        let x = vec![-2.0, -1.0, 0.0, 1.0, 2.0];
        let values = [1.0, 2.0, 4.0, 4.0, 6.0];
        let taken =
            Left::by(std::slice::from_ref(&ones), &values).taken_by(std::slice::from_ref(&x));
        // Slope 1.2, squares left 0.8 of three degrees of freedom, Σx² = 10.
        let expected = 1.2 / (0.8_f64 / 3.0 / 10.0).sqrt();
        assert!((taken.in_sigmas() - expected).abs() < 1e-12 * expected);
        assert_eq!(taken.dof, 3);
        let nothing = Left::by(&[ones, x.clone()], &values).taken_by(&[x]);
        assert!(nothing.share() < 1e-12 && nothing.dof == 3);
    }
}
