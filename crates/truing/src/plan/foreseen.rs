//! Whether the loop tells rivals apart once a plan is carried out, by loops on simulated data.

use model_discrepancy::{Foreseen, MOST_SIMULATED};

use super::linear::Origins;
use super::question::{Ask, Question};
use crate::{Case, Error};

/// Share of the simulated loops that may leave a rival: one in forty, so that all that a plan asks for
/// is answered in nineteen of twenty.
const MISSED: f64 = 0.025;

/// How often loops on simulated data tell the truth of each ask from its rival.
#[derive(Clone, Debug)]
pub(super) struct ToldApart(Vec<Option<f64>>);

impl ToldApart {
    /// With the plan that is in `with_plan`, for the asks of `served` that measurements can serve. Of more
    /// rows than [`MOST_SIMULATED`], as in `truing check`, nothing is simulated.
    pub(super) fn of(
        (question, served): (&Question, &[usize]),
        case: &Case,
        with_plan: &Case,
        origins: &Origins<'_>,
    ) -> Result<Self, Error> {
        let mut told = Self(vec![None; question.asks.len()]);
        let truths = truths(question, served);
        if truths.is_empty() {
            return Ok(told);
        }
        let prepared = with_plan.measured.prepare_planned(origins.n_rows)?;
        let model = &*prepared.model;
        let layout = &model.declared().layout;
        if layout.rows.len() > MOST_SIMULATED {
            return Ok(told);
        }
        let planned: Vec<usize> = origins.of_plan(layout).map(|(row, _)| row).collect();
        let options = case.loop_settings.options();
        let covariates = &prepared.covariates;
        let foreseen = Foreseen { model, covariates, options: &options, planned: &planned };
        for Truth { name, accepted, rivals, asks } in truths {
            let effects = question.with_instead(name, accepted);
            let shares = foreseen
                .told_apart(&effects, (name, &rivals), MISSED)
                .map_err(|source| case.loop_error(source))?;
            for (ask, share) in asks.into_iter().zip(shares.into_iter().flatten()) {
                told.0[ask] = Some(share);
            }
        }
        Ok(told)
    }

    /// The same, with asks that earlier loops never told from their rivals.
    pub(super) fn never(mut self, asks: &[usize]) -> Self {
        for &ask in asks {
            self.0[ask] = Some(0.0);
        }
        self
    }

    /// Whether no loop told the truth of an ask from its rivals.
    pub(super) fn is_never(&self, ask: usize) -> bool {
        self.share(ask) == Some(0.0)
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

/// A name that may be right, and what it is to be told from.
struct Truth<'a> {
    name: &'a str,
    accepted: &'a str,
    rivals: Vec<&'a str>,
    asks: Vec<usize>,
}

fn truths<'a>(question: &'a Question, served: &[usize]) -> Vec<Truth<'a>> {
    let mut truths: Vec<Truth<'_>> = Vec::new();
    for &index in served {
        let Ask::Apart { truth, rival, accepted, .. } = &question.asks[index] else { continue };
        let is_it = |t: &&mut Truth<'_>| t.name == truth && t.accepted == accepted;
        if let Some(known) = truths.iter_mut().find(is_it) {
            known.rivals.push(rival);
            known.asks.push(index);
        } else {
            let (rivals, asks) = (vec![rival.as_str()], vec![index]);
            truths.push(Truth { name: truth, accepted, rivals, asks });
        }
    }
    truths
}
