//! Whether the loop tells rivals apart once a plan is carried out, by loops on simulated data.

use model_discrepancy::{Foreseen, MOST_SIMULATED};

use super::linear::Origins;
use super::question::{Ask, Question};
use crate::{Case, Error};

/// Share of the simulated loops that may leave a rival: one in forty, so that all that a plan asks for
/// is answered in nineteen of twenty.
const MISSED: f64 = 0.025;

/// How often loops on simulated data tell the truth of each ask from its rivals.
#[derive(Clone, Debug)]
pub(super) struct ToldApart(Vec<Option<f64>>);

impl ToldApart {
    /// With the plan that is in `with_plan`. Of more rows than [`MOST_SIMULATED`], as in `truing check`,
    /// nothing is simulated.
    pub(super) fn of(
        question: &Question,
        case: &Case,
        with_plan: &Case,
        origins: &Origins<'_>,
    ) -> Result<Self, Error> {
        let nothing = Self(vec![None; question.asks.len()]);
        if !question.asks.iter().any(|ask| matches!(ask, Ask::Apart { .. })) {
            return Ok(nothing);
        }
        let prepared = with_plan.measured.prepare()?;
        let model = &*prepared.model;
        let layout = &model.declared().layout;
        if layout.rows.len() > MOST_SIMULATED {
            return Ok(nothing);
        }
        let planned: Vec<usize> = origins.of_plan(layout).map(|(row, _)| row).collect();
        let options = case.loop_settings.options();
        let covariates = &prepared.covariates;
        let foreseen = Foreseen { model, covariates, options: &options, planned: &planned };
        let told = |ask: &Ask| {
            let Ask::Apart { truth, rival, .. } = ask else { return Ok(None) };
            let effects = question.with_instead(truth, rival);
            let told = foreseen.told_apart(&effects, (truth, &[rival]), MISSED);
            told.map_err(|source| case.loop_error(source))
        };
        Ok(Self(question.asks.iter().map(told).collect::<Result<_, _>>()?))
    }

    /// How often, where it was simulated.
    pub(super) fn share(&self, ask: usize) -> Option<f64> {
        self.0[ask]
    }

    /// Whether it is often enough, as far as is known.
    pub(super) fn is_enough(&self, ask: usize) -> bool {
        self.share(ask).is_none_or(|share| share >= 1.0 - MISSED)
    }
}
