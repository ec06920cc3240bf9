//! What must not change, or must change in a known way, when the problem is rewritten.

use least_squares::{Options, solve};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::problems::{Written, decay, decay_data};
use crate::suites::dual::Dual;

/// Two fits that stop within 1e-12 of a standard uncertainty of one minimum, conditioned by 10.
const SAME_MINIMUM_SIGMA: f64 = 1e-9;
/// Relative agreement of covariances at such points.
const SAME_COVARIANCE: f64 = 1e-9;

fn wavy_data() -> Vec<f64> {
    decay_data(|t| 0.02 * (5.0 * t).sin())
}

fn start() -> DVector<f64> {
    DVector::from_vec(vec![1.0, 0.2, 0.0])
}

fn assert_same(a: &DVector<f64>, b: &DVector<f64>, sigma: &DVector<f64>) {
    for i in 0..a.len() {
        let error = (a[i] - b[i]).abs() / sigma[i];
        assert!(error < SAME_MINIMUM_SIGMA, "component {i} off by {error} sigma");
    }
}

fn assert_same_matrix(a: &DMatrix<f64>, b: &DMatrix<f64>) {
    for i in 0..a.nrows() {
        for j in 0..a.ncols() {
            let scale = (a[(i, i)] * a[(j, j)]).sqrt();
            assert!((a[(i, j)] - b[(i, j)]).abs() <= SAME_COVARIANCE * scale, "entry {i}, {j}");
        }
    }
}

/// The decay with parameter `i` in units of `unit[i]`.
fn in_units(data: &[f64], unit: [f64; 3]) -> Written<'_> {
    Written::new(&["a", "b", "c"], data.len(), move |x| {
        let [a, b, c] = [x[0] * unit[0], x[1] * unit[1], x[2] * unit[2]];
        let times = (0..data.len()).map(|i| 0.4 * i as f64);
        data.iter().zip(times).map(|(y, t)| a * (-b * t).exp() + c - *y).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Powers of two change no digit of any step, so the whole search must be the same.
    #[test]
    fn units_of_parameters_do_not_matter(exponents in prop::array::uniform3(-40_i32..40)) {
        let data = wavy_data();
        let unit = exponents.map(|e| 2_f64.powi(e));
        let plain = solve(&decay(&data), start(), &Options::default()).unwrap();
        let scaled_start = DVector::from_fn(3, |i, _| start()[i] / unit[i]);
        let scaled = solve(&in_units(&data, unit), scaled_start, &Options::default()).unwrap();
        prop_assert_eq!(scaled.report.residual_evaluations, plain.report.residual_evaluations);
        for i in 0..3 {
            prop_assert_eq!(scaled.point[i] * unit[i], plain.point[i]);
            for j in 0..3 {
                let back = scaled.covariance[(i, j)] * unit[i] * unit[j];
                let scale = (plain.covariance[(i, i)] * plain.covariance[(j, j)]).sqrt();
                prop_assert!((back - plain.covariance[(i, j)]).abs() <= SAME_COVARIANCE * scale);
            }
        }
    }

    #[test]
    fn sigma_scales_the_covariance_and_nothing_else(factor in 1e-6_f64..1e6) {
        let data = wavy_data();
        let plain = solve(&decay(&data), start(), &Options::default()).unwrap();
        let rescaled = Written::new(&["a", "b", "c"], data.len(), |x: &[Dual]| {
            let predict = |t: f64| x[0] * (-x[1] * t).exp() + x[2];
            (0..data.len()).map(|i| (predict(0.4 * i as f64) - data[i]) * factor).collect()
        });
        let scaled = solve(&rescaled, start(), &Options::default()).unwrap();
        let posterior = plain.standard_uncertainties() * plain.variance_factor.unwrap().sqrt();
        assert_same(&scaled.point, &plain.point, &posterior);
        assert_same_matrix(&(&plain.covariance / factor.powi(2)), &scaled.covariance);
        let ratio = scaled.variance_factor.unwrap() / plain.variance_factor.unwrap();
        prop_assert!((ratio / factor.powi(2) - 1.0).abs() < SAME_COVARIANCE);
    }

    #[test]
    fn order_of_rows_does_not_matter(turn in 1_usize..12) {
        let data = wavy_data();
        let plain = solve(&decay(&data), start(), &Options::default()).unwrap();
        let turned = Written::new(&["a", "b", "c"], data.len(), |x: &[Dual]| {
            let predict = |t: f64| x[0] * (-x[1] * t).exp() + x[2];
            let row = |i: usize| (i + turn) % data.len();
            (0..data.len()).map(|i| predict(0.4 * row(i) as f64) - data[row(i)]).collect()
        });
        let other = solve(&turned, start(), &Options::default()).unwrap();
        let posterior = plain.standard_uncertainties() * plain.variance_factor.unwrap().sqrt();
        assert_same(&other.point, &plain.point, &posterior);
    }

    #[test]
    fn a_held_direction_is_a_removed_column(held in 0_usize..3, value in 0.1_f64..1.0) {
        let data = wavy_data();
        let options = Options { held: vec![held], ..Options::default() };
        let mut from = start();
        from[held] = value;
        let kept = solve(&decay(&data), from.clone(), &options).unwrap();

        let free: Vec<usize> = (0..3).filter(|&i| i != held).collect();
        let removed = Written::new(&["first", "second"], data.len(), |x: &[Dual]| {
            let mut full = [Dual::from(value); 3];
            (full[free[0]], full[free[1]]) = (x[0], x[1]);
            let predict = |t: f64| full[0] * (-full[1] * t).exp() + full[2];
            (0..data.len()).map(|i| predict(0.4 * i as f64) - data[i]).collect()
        });
        let two = DVector::from_vec(vec![from[free[0]], from[free[1]]]);
        let without = solve(&removed, two, &Options::default()).unwrap();

        prop_assert_eq!(kept.point[held], value);
        prop_assert_eq!(kept.degrees_of_freedom, without.degrees_of_freedom);
        let taken = DVector::from_fn(2, |i, _| kept.point[free[i]]);
        let factor = without.variance_factor.unwrap().sqrt();
        assert_same(&taken, &without.point, &(without.standard_uncertainties() * factor));
        let block = DMatrix::from_fn(2, 2, |i, j| kept.covariance[(free[i], free[j])]);
        assert_same_matrix(&block, &without.covariance);
        prop_assert_eq!(kept.covariance.column(held).amax(), 0.0);
    }
}
