//! Problems that several tests share.

use least_squares::Problem;
use nalgebra::{DMatrix, DVector};

use crate::suites::dual::Dual;

type Residuals<'a> = Box<dyn Fn(&[Dual]) -> Vec<Dual> + 'a>;

/// A problem over a plain vector, written as one function with derivatives to rounding.
pub(crate) struct Written<'a> {
    names: Vec<&'static str>,
    rows: usize,
    residuals: Residuals<'a>,
}

impl<'a> Written<'a> {
    pub(crate) fn new(
        names: &[&'static str],
        rows: usize,
        residuals: impl Fn(&[Dual]) -> Vec<Dual> + 'a,
    ) -> Self {
        Self { names: names.to_vec(), rows, residuals: Box::new(residuals) }
    }
}

impl Problem for Written<'_> {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.rows
    }

    fn tangent_dim(&self) -> usize {
        self.names.len()
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        for (r, dual) in out.iter_mut().zip((self.residuals)(&Dual::parameters(at.as_slice()))) {
            *r = dual.value;
        }
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        let rows = (self.residuals)(&Dual::parameters(at.as_slice()));
        for (row, dual) in rows.into_iter().enumerate() {
            for column in 0..at.len() {
                out[(row, column)] = dual.slope[column];
            }
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }

    fn parameter_name(&self, index: usize) -> String {
        self.names[index].to_owned()
    }
}

/// `a exp(−b t) + c`, sampled at 12 times; parameters a, b, c.
pub(crate) fn decay(data: &[f64]) -> Written<'_> {
    Written::new(&["a", "b", "c"], data.len(), move |x| {
        let predict = |t: f64| x[0] * (-x[1] * t).exp() + x[2];
        data.iter().zip(times()).map(|(y, t)| predict(t) - *y).collect()
    })
}

/// Parameters that [`decay_data`] is made with.
pub(crate) const DECAY_TRUTH: [f64; 3] = [2.0, 0.7, 0.3];

/// Exact values of [`decay`] plus an error for each sample.
pub(crate) fn decay_data(error: impl FnMut(f64) -> f64) -> Vec<f64> {
    let [a, b, c] = DECAY_TRUTH;
    let mut error = error;
    times().map(|t| a * (-b * t).exp() + c + error(t)).collect()
}

fn times() -> impl Iterator<Item = f64> {
    (0..12).map(|i| 0.4 * f64::from(i))
}

/// A straight line through `(x, y)` with unit sigma; parameters offset and slope.
pub(crate) fn line(points: &[(f64, f64)]) -> Written<'_> {
    Written::new(&["offset", "slope"], points.len(), move |p| {
        points.iter().map(|(x, y)| p[0] + p[1] * *x - *y).collect()
    })
}
