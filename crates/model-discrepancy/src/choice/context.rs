//! What stays the same while effects are chosen.

use crate::algebra::system::{Estimate, System};
use crate::choice::blocks::WithoutBlock;
use crate::choice::shapes::Shapes;
use crate::noise::linear::Linear;
use crate::{Covariate, Model, Options};

/// What stays the same while effects are chosen.
pub(crate) struct Context<'a> {
    pub(crate) model: &'a dyn Model,
    /// Recorded and coordinate covariates, and the measured order.
    pub(crate) covariates: &'a [Covariate],
    /// What is looked for along each of them.
    pub(crate) shapes: &'a [Shapes],
    pub(crate) options: &'a Options,
    /// Components whose residual is zero throughout: not measured, and left out of inference.
    pub(crate) silent: &'a [bool],
    /// Effects that are out of the question.
    pub(crate) banned: &'a [usize],
    /// Whether to score hopeless candidates too, for the report.
    pub(crate) thorough: bool,
    /// Where the choice is repeated without a block of groups: what of it is known from sums over them.
    pub(crate) without_block: Option<WithoutBlock<'a, 'a>>,
    /// Where the choice is repeated with readings moved by next to nothing: systems as linearised on the
    /// same groups before, which serve there too.
    pub(crate) linearised: &'a [(&'a System<'a>, &'a Linear<'a>)],
}

impl<'a> Context<'a> {
    /// With nothing banned, on all groups.
    pub(crate) fn open(
        model: &'a dyn Model,
        (covariates, shapes): (&'a [Covariate], &'a [Shapes]),
        options: &'a Options,
        silent: &'a [bool],
    ) -> Self {
        Self {
            model,
            covariates,
            shapes,
            options,
            silent,
            banned: &[],
            thorough: true,
            without_block: None,
            linearised: &[],
        }
    }

    /// `system` linearised at `at`, on the groups of `keep`.
    pub(crate) fn linear(&self, system: &System<'a>, at: &Estimate, keep: &[bool]) -> Linear<'a> {
        match self.linearised.iter().find(|(known, _)| known.is_same(system)) {
            Some((_, lin)) => lin.with_data(system, at),
            None => Linear::of(system, at, keep, self.silent),
        }
    }

    /// Every covariate with what is looked for along it.
    pub(crate) fn along(&self) -> impl Iterator<Item = (&'a Covariate, &'a Shapes)> + use<'a> {
        self.covariates.iter().zip(self.shapes)
    }
}
