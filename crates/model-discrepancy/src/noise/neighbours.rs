//! Noise of which neighbours agree: an autoregression of first order, by three products for any
//! correlation.

use nalgebra::DMatrix;

use crate::algebra::product::tr_times;

/// Products of columns with each other once the noise is white, for any correlation.
///
/// Each value less what the one before predicts, over the standard deviation of the prediction
/// (Prais and Winsten 1954): of columns X and Y that is `(XᵀY + φ·L + φ²·S)/(1 − φ²)`, where `L` takes
/// neighbours together and `S` leaves out the ends of the series, twice what is in no series.
pub(crate) struct Autoregression {
    /// Whose products with others are asked for.
    columns: DMatrix<f64>,
    /// Sum of both neighbours of every value in its series.
    beside: DMatrix<f64>,
    /// Rows that are ends of series, and how many; of a row in no series two.
    ends: Vec<(usize, f64)>,
    /// Values that have one before them.
    predicted: usize,
    own: Quadratic,
}

/// A matrix for any correlation.
pub(crate) struct Quadratic {
    constant: DMatrix<f64>,
    linear: DMatrix<f64>,
    square: DMatrix<f64>,
}

impl Quadratic {
    /// The matrix at one correlation.
    pub(crate) fn at(&self, phi: f64) -> DMatrix<f64> {
        let mut sum = &self.square * (phi * phi);
        sum += &self.linear * phi;
        sum += &self.constant;
        sum / (1.0 - phi * phi)
    }

    fn of(
        columns: &DMatrix<f64>,
        beside: &DMatrix<f64>,
        others: &DMatrix<f64>,
        ends: &[(usize, f64)],
    ) -> Self {
        let constant = tr_times(columns, others);
        let linear = -tr_times(beside, others);
        let mut square = constant.clone();
        for &(row, times) in ends {
            square.ger(-times, &columns.row(row).transpose(), &others.row(row).transpose(), 1.0);
        }
        Self { constant, linear, square }
    }
}

impl Autoregression {
    pub(crate) fn new(series: &[Vec<usize>], columns: DMatrix<f64>) -> Self {
        let ends = ends(series, columns.nrows());
        let beside = neighbours(series, &columns);
        let own = Quadratic::of(&columns, &beside, &columns, &ends);
        let predicted = series.iter().map(|one| one.len().saturating_sub(1)).sum();
        Self { columns, beside, ends, predicted, own }
    }

    /// Products of the columns with each other.
    pub(crate) fn own(&self) -> &Quadratic {
        &self.own
    }

    /// Products of the columns with others, and of these with each other.
    pub(crate) fn with(&self, series: &[Vec<usize>], others: &DMatrix<f64>) -> [Quadratic; 2] {
        let own = Quadratic::of(others, &neighbours(series, others), others, &self.ends);
        [Quadratic::of(&self.columns, &self.beside, others, &self.ends), own]
    }

    /// Logarithm of the determinant of the noise's covariance.
    pub(crate) fn log_determinant(&self, phi: f64) -> f64 {
        crate::count::count(self.predicted) * (1.0 - phi * phi).ln()
    }
}

fn neighbours(series: &[Vec<usize>], columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(columns.nrows(), columns.ncols());
    for (mut sum, column) in sum.column_iter_mut().zip(columns.column_iter()) {
        for pair in series.iter().flat_map(|one| one.windows(2)) {
            sum[pair[0]] += column[pair[1]];
            sum[pair[1]] += column[pair[0]];
        }
    }
    sum
}

fn ends(series: &[Vec<usize>], rows: usize) -> Vec<(usize, f64)> {
    let mut times = vec![2.0_f64; rows];
    for one in series {
        for &row in one {
            times[row] = 0.0;
        }
        if let (Some(&first), Some(&last)) = (one.first(), one.last()) {
            times[first] += 1.0;
            times[last] += 1.0;
        }
    }
    times.into_iter().enumerate().filter(|(_, times)| *times > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::count::count;

    /// Of products of numbers near one, over `1 − φ²`.
    const ROUND_OFF: f64 = 1e-12;

    /// Two series, one of a single value, and two rows in none; against the inverse of the
    /// covariance itself.
    #[test]
    fn three_products_give_what_the_covariance_gives() {
        const ROWS: usize = 12;
        let series = [vec![0, 3, 4, 7, 8, 11], vec![1, 2, 9], vec![5]];
        let wave = |of: f64| move |i: usize, j: usize| (of * count(3 * i + 7 * j * j + 1)).sin();
        let (columns, others) =
            (DMatrix::from_fn(ROWS, 3, wave(0.7)), DMatrix::from_fn(ROWS, 2, wave(1.9)));
        let whole = Autoregression::new(&series, columns.clone());
        for phi in [0.0, 0.3, 0.95] {
            let mut covariance = DMatrix::<f64>::identity(ROWS, ROWS);
            for one in &series {
                for (a, &i) in one.iter().enumerate() {
                    for (b, &j) in one.iter().enumerate() {
                        covariance[(i, j)] = (0..a.abs_diff(b)).fold(1.0, |power, _| power * phi);
                    }
                }
            }
            let inverse = covariance.clone().try_inverse().unwrap();
            let [across, own] = whole.with(&series, &others);
            let off = |a: DMatrix<f64>, b: DMatrix<f64>| (a - b).amax();
            assert!(
                off(whole.own().at(phi), columns.transpose() * &inverse * &columns) < ROUND_OFF
            );
            assert!(off(across.at(phi), columns.transpose() * &inverse * &others) < ROUND_OFF);
            assert!(off(own.at(phi), others.transpose() * &inverse * &others) < ROUND_OFF);
            let log_determinant = covariance.determinant().ln();
            assert!((whole.log_determinant(phi) - log_determinant).abs() < ROUND_OFF);
        }
    }
}
