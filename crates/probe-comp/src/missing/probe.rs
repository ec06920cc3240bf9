//! What a qualification leaves uncertain of the probe, as parameters of the declared model.

use model_discrepancy::Parameter;
use nalgebra::DMatrix;

use super::columns::as_f64;
use super::term::Situation;
use crate::qualify::{ProbeUncertainty, shifts};
use crate::{BallTouch, ProbeError};

/// Corrections of the effective radius and of the probe's amplitudes, which the qualification knows to
/// be zero within its covariance.
#[derive(Clone, Debug)]
pub(crate) struct Probe {
    known: ProbeUncertainty,
    /// Inverse of the covariance's lower Cholesky factor: rows of prior knowledge.
    prior: DMatrix<f64>,
}

impl Probe {
    pub(crate) fn new(known: ProbeUncertainty) -> Result<Self, ProbeError> {
        let n = names(&known).len();
        let refused = || ProbeError::InvalidOption {
            name: "qualification",
            needed: "a positive definite covariance of effective radius, lobes and bending",
            value: as_f64(known.covariance_mm2.nrows()),
        };
        let is_square = known.covariance_mm2.shape() == (n, n);
        let factor = known.covariance_mm2.clone().cholesky().filter(|_| is_square);
        let root = factor.ok_or_else(refused)?.l();
        let inverse = root.solve_lower_triangular(&DMatrix::identity(n, n));
        let prior = inverse.ok_or_else(refused)?;
        Ok(Self { known, prior })
    }

    pub(crate) fn parameters(&self) -> Vec<Parameter> {
        let parameter = |name| Parameter { name, unit: "µm".to_owned(), report_factor: 1e3 };
        names(&self.known).into_iter().map(parameter).collect()
    }

    /// `∂ deviation / ∂ parameter` of a touch.
    pub(crate) fn row(&self, at: &Situation<'_>, touch: &BallTouch) -> Vec<f64> {
        let shifts = shifts(&self.known.terms, at.approach, touch.spindle_rad);
        let along = shifts.iter().map(|shift| -at.normal.dot(shift));
        std::iter::once(-1.0).chain(along).collect()
    }

    /// Rows of prior knowledge, each of standard uncertainty one.
    pub(crate) fn prior(&self) -> &DMatrix<f64> {
        &self.prior
    }
}

fn names(known: &ProbeUncertainty) -> Vec<String> {
    let mut names = vec!["effective radius by the qualification".to_owned()];
    for order in &known.terms.lobes {
        names
            .extend(["cos", "sin"].map(|part| format!("lobe {order} {part} by the qualification")));
    }
    names.extend(known.terms.bending.then(|| "bending by the qualification".to_owned()));
    names
}
