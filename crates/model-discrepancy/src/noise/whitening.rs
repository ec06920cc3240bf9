//! Noise whose successive values depend on each other, and what turns it white.

use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::algebra::product::{lower_triangular_times, times, view};
use crate::count::count;

/// Turns noise of one model into white noise.
pub(crate) enum Whitening {
    /// Each value less what those before it predict, over the standard deviation of the prediction.
    Predicted {
        /// Lower triangular; a shorter series takes the leading part.
        rows: DMatrix<f64>,
        /// Logarithm of the variance of each prediction.
        log_variances: Vec<f64>,
    },
    /// The same where three coordinates are behind each value (Kalman 1960).
    Filtered {
        /// Correlation of successive positions.
        phi: f64,
        /// One per value of the series.
        readings: Vec<ReadAlong>,
    },
}

/// What one reading of a position says beside those before it.
pub(crate) struct ReadAlong {
    direction: Vector3<f64>,
    /// By what the position is corrected, per unit of what was not predicted.
    gain: Vector3<f64>,
    /// Standard deviation of the prediction.
    std: f64,
}

impl Whitening {
    /// Fractionally integrated noise of memory `d` (Hosking 1981), for series up to the given length:
    /// a spectrum `f^(−2d)`, which an autoregression of first order takes for flat at low
    /// frequencies. Durbin and Levinson's recursion on the partial correlations `d/(k − d)`.
    pub(crate) fn fractional(d: f64, longest: usize) -> Self {
        let mut rows = DMatrix::zeros(longest, longest);
        let mut log_variances = Vec::with_capacity(longest);
        // The latest value's weight first.
        let mut weights: Vec<f64> = Vec::with_capacity(longest);
        let mut variance = 1.0_f64;
        for k in 0..longest {
            if k > 0 {
                let partial = d / (count(k) - d);
                let reversed = weights.iter().rev();
                let next = weights.iter().zip(reversed).map(|(w, r)| w - partial * r);
                weights = next.chain([partial]).collect();
                variance *= 1.0 - partial * partial;
            }
            let scale = variance.sqrt().recip();
            rows[(k, k)] = scale;
            for (lag, weight) in weights.iter().enumerate() {
                rows[(k, k - 1 - lag)] = -weight * scale;
            }
            log_variances.push(variance.ln());
        }
        Self::Predicted { rows, log_variances }
    }

    /// Noise of a position, of which each coordinate is an autoregression with the correlation
    /// `phi`, read along the given unit vectors one after the other: `K_ij = φ^|i−j| dᵢ·dⱼ`.
    pub(crate) fn read_along(phi: f64, directions: &[Vector3<f64>]) -> Self {
        // What the readings before leave unknown of the position.
        let mut unknown = Matrix3::identity();
        let mut read = |direction: &Vector3<f64>| {
            let seen = unknown * direction;
            let variance = direction.dot(&seen);
            let gain = seen / variance;
            let left = unknown - gain * seen.transpose();
            unknown = left * (phi * phi) + Matrix3::identity() * (1.0 - phi * phi);
            ReadAlong { direction: *direction, gain, std: variance.sqrt() }
        };
        Self::Filtered { phi, readings: directions.iter().map(&mut read).collect() }
    }

    /// Logarithm of the determinant of the noise's covariance.
    pub(crate) fn log_determinant(&self, series: &[Vec<usize>]) -> f64 {
        match self {
            Self::Predicted { log_variances, .. } => {
                series.iter().map(|one| log_variances[..one.len()].iter().sum::<f64>()).sum()
            }
            Self::Filtered { readings, .. } => {
                let of = |one: &Vec<usize>| -> f64 {
                    readings[..one.len()].iter().map(|reading| 2.0 * reading.std.ln()).sum()
                };
                series.iter().map(of).sum()
            }
        }
    }

    /// Columns whitened series by series; rows outside any series stay as they are.
    pub(crate) fn apply(&self, series: &[Vec<usize>], columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = columns.clone();
        for one in series {
            match self {
                Self::Predicted { rows, .. } => {
                    let white = lower_triangular_times(rows, &columns.select_rows(one));
                    for (mut to, white) in out.column_iter_mut().zip(white.column_iter()) {
                        one.iter().zip(white.iter()).for_each(|(&row, white)| to[row] = *white);
                    }
                }
                Self::Filtered { phi, readings } => {
                    for (mut to, from) in out.column_iter_mut().zip(columns.column_iter()) {
                        let mut position = Vector3::zeros();
                        for (&row, reading) in one.iter().zip(readings) {
                            let innovation = from[row] - reading.direction.dot(&position);
                            to[row] = innovation / reading.std;
                            position = (position + reading.gain * innovation) * *phi;
                        }
                    }
                }
            }
        }
        out
    }

    /// The transpose of [`Whitening::apply`]: products of columns with what it gives are those of the whitened
    /// columns.
    pub(crate) fn transposed(&self, series: &[Vec<usize>], columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = columns.clone();
        for one in series {
            match self {
                Self::Predicted { rows, .. } => {
                    let n = one.len();
                    let rows = view(rows).submatrix(0, 0, n, n);
                    let before = times(rows.transpose(), view(&columns.select_rows(one)));
                    for (mut to, before) in out.column_iter_mut().zip(before.column_iter()) {
                        one.iter().zip(before.iter()).for_each(|(&row, before)| to[row] = *before);
                    }
                }
                Self::Filtered { phi, readings } => {
                    for (mut to, from) in out.column_iter_mut().zip(columns.column_iter()) {
                        let mut position = Vector3::zeros();
                        for (&row, reading) in one.iter().zip(readings).rev() {
                            let innovation =
                                from[row] / reading.std + reading.gain.dot(&position) * phi;
                            to[row] = innovation;
                            position = position * *phi - reading.direction * innovation;
                        }
                    }
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::neighbours::Autoregression;

    /// Round-off of sums over as many products as there are readings, of condition 100.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn readings_of_a_wandering_position_come_out_white() {
        const N: usize = 12;
        const PHI: f64 = 0.8;
        let wave = |i: usize, of: f64| (of * count(i)).sin();
        let directions: Vec<Vector3<f64>> = (0..N)
            .map(|i| Vector3::new(wave(i, 1.0), wave(i, 2.3), 1.0 + wave(i, 0.7)).normalize())
            .collect();
        // From the process itself: each coordinate is what is left of the first value and of every
        // innovation since.
        let share = |k: usize| if k == 0 { 1.0 } else { (1.0 - PHI * PHI).sqrt() };
        let readings = DMatrix::from_fn(N, 3 * N, |i, column| {
            let (k, axis) = (column / 3, column % 3);
            let faded = (k..i).fold(share(k), |left, _| PHI * left);
            if k <= i { faded * directions[i][axis] } else { 0.0 }
        });
        let whitening = Whitening::read_along(PHI, &directions);
        let white = whitening.apply(&[(0..N).collect()], &readings);
        let covariance = &white * white.transpose();
        assert!((covariance - DMatrix::identity(N, N)).amax() < ROUND_OFF);
        let of_process = (&readings * readings.transpose()).determinant().ln();
        assert!((whitening.log_determinant(&[(0..N).collect()]) - of_process).abs() < ROUND_OFF);
    }

    #[test]
    fn transposed_is_the_other_side_of_a_product() {
        let series = [vec![4, 0, 2, 7], vec![1, 3]];
        let columns = |of: f64| DMatrix::from_fn(8, 2, |i, j| (of * count(3 * i + 5 * j)).cos());
        let (a, b) = (columns(0.7), columns(1.9));
        let direction = |i: usize| Vector3::new(count(i).sin(), 0.3, count(i).cos()).normalize();
        let along = Whitening::read_along(0.6, &[0, 1, 2, 3].map(direction));
        for whitening in [Whitening::fractional(0.3, 4), along] {
            let whole = whitening.apply(&series, &a).tr_mul(&b);
            let difference = a.tr_mul(&whitening.transposed(&series, &b)) - whole;
            assert!(difference.amax() < ROUND_OFF);
        }
    }

    #[test]
    fn readings_that_all_look_one_way_are_an_autoregression() {
        let series = [(0..9).collect::<Vec<usize>>()];
        let columns = DMatrix::from_fn(9, 2, |i, j| count(3 * i + 5 * j).cos());
        let along = Whitening::read_along(0.6, &[Vector3::z(); 9]);
        let white = along.apply(&series, &columns);
        let neighbours = Autoregression::new(&series, columns);
        let difference = white.tr_mul(&white) - neighbours.own().at(0.6);
        assert!(difference.amax() < ROUND_OFF);
        let log_determinant = neighbours.log_determinant(0.6);
        assert!((along.log_determinant(&series) - log_determinant).abs() < ROUND_OFF);
    }
}
