//! Everything that is looked for along a covariate.

use crate::choice::interruption::{breaks, interrupted, interruption_name};
use crate::choice::shape::{Periods, Shape, apart, periods, shapes};
use crate::{Covariate, Layout};

/// All shapes along one covariate, which are the same whatever groups are left out.
#[derive(Clone, Debug)]
pub(crate) struct Shapes {
    /// One of each kind.
    pub(crate) single: Vec<Shape>,
    pub(crate) periods: Option<Periods>,
    /// One level apart from the others, in turn.
    pub(crate) apart: Vec<Shape>,
    /// Places at which a course along it may break off.
    pub(crate) breaks: Vec<f64>,
}

impl Shapes {
    /// Those along each of the covariates.
    pub(crate) fn of_all(layout: &Layout, covariates: &[Covariate]) -> Vec<Self> {
        let along = |covariate: &Covariate| Self {
            single: shapes(layout, covariate),
            periods: periods(layout, covariate, covariates),
            apart: apart(layout, covariate),
            breaks: breaks(layout, covariate),
        };
        covariates.iter().map(along).collect()
    }

    /// The one of this name along `covariate`.
    pub(crate) fn named(&self, covariate: &Covariate, name: &str) -> Option<Shape> {
        let periods = self.periods.iter();
        let periods = periods.flat_map(|p| p.parts.iter().map(|&part| p.shape(covariate, part)));
        let single = self.single.iter().chain(&self.apart).find(|s| s.name == name).cloned();
        let is_it = |at: &&f64| interruption_name(**at) == name;
        let interruption = || self.breaks.iter().find(is_it);
        single
            .or_else(|| Some(interrupted(covariate, *interruption()?, &self.breaks)))
            .or_else(|| periods.into_iter().find(|s| s.name == name))
    }
}
