//! Quantities recorded beside the observations.

use super::Layout;

/// Name of the covariate that every data set has: the order in which it was measured.
pub(crate) const ORDER: &str = "order";

/// A quantity recorded beside the observations that the declared model does not use.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariate {
    /// Column name, unit suffix included.
    pub name: String,
    /// One value per observation; finite.
    pub values: Vec<f64>,
    /// Where it comes from.
    pub origin: Origin,
}

/// Where a covariate comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A column recorded by the user.
    Recorded,
    /// A position or setting at which the observation was made, from the model's own input.
    Coordinate,
}

/// The given covariates that vary, and the measured order.
pub(crate) fn with_order(layout: &Layout, covariates: &[Covariate]) -> Vec<Covariate> {
    let varies = |c: &&Covariate| c.values.iter().any(|v| v.total_cmp(&c.values[0]).is_ne());
    let mut all: Vec<_> = covariates.iter().filter(varies).cloned().collect();
    let n = layout.observations.len();
    all.push(Covariate {
        name: ORDER.to_owned(),
        values: (0..n).map(crate::count::count).collect(),
        origin: Origin::Coordinate,
    });
    all
}
