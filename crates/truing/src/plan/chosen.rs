//! The measurements of a plan: chosen by the tests of the linearised model, tried by loops.

use model_discrepancy::{Assessment, Model, assess_those};

use super::design::{Design, Goal, HOPELESS};
use super::figures;
use super::foreseen::ToldApart;
use super::linear::{self, Linear, Origins};
use super::question::{self, Ask, Question};
use super::rows::Rows;
use crate::kinds::Offer;
use crate::{Case, Error};

/// Times that more is asked of the tests where loops name an effect too seldom.
const HARDER: f64 = 2.0;
/// The same of tests of rivals, for which loops ask little more than the tests.
const HARDER_APART: f64 = 1.35;
/// Rounds of asking more; the last asks for eight times the first.
const MOST_ROUNDS: usize = 4;

/// What measurements are chosen by.
pub(super) struct Setting<'a> {
    pub(super) case: &'a Case,
    pub(super) offer: &'a Offer,
    pub(super) question: &'a Question,
    pub(super) design: &'a Design,
    /// Of the model with every measurement on offer.
    pub(super) linear: &'a Linear,
}

/// The measurements of a plan, and what is known of it.
pub(super) struct Chosen {
    /// By their place in the offer.
    pub(super) sorted: Vec<usize>,
    pub(super) rows: Rows,
    pub(super) with_plan: Case,
    /// What the design sees with the plan.
    pub(super) after: Vec<Assessment>,
    pub(super) told_apart: ToldApart,
    /// Whether loops name what is asked for often enough.
    pub(super) named: bool,
    /// Asks that loops never answer although the tests are met.
    pub(super) never: Vec<usize>,
    /// What was asked of the tests in the end.
    pub(super) asked: Vec<(usize, Goal)>,
}

impl Chosen {
    /// At most so many. What the tests of the linearised model promise is held against loops on simulated
    /// data of the same design; where they name an effect too seldom, more is asked of the tests, and what
    /// they never tell from its rivals is not asked any more, as long as anything else is.
    pub(super) fn of(
        setting: &Setting<'_>,
        model: &dyn Model,
        (n_rows, most): (usize, usize),
        mut asked: Vec<(usize, Goal)>,
    ) -> Result<Self, Error> {
        let Setting { case, offer, question, design, linear } = *setting;
        let folder = &case.files.folder;
        let mut never: Vec<usize> = Vec::new();
        let mut round = 0;
        loop {
            round += 1;
            let (served, hopeful) = hopeful(design, question, &asked);
            let mut sorted = design.chosen(&hopeful, most);
            add_controls(&mut sorted, &offer.controls, most);
            // The order of the offer, in which place and time do not run together.
            sorted.sort_unstable();
            let rows = Rows::of(folder, offer, &sorted)?;
            let with_plan = case.with(&rows.edits())?;
            let after = assessed(question, case, &with_plan)?;
            let of_plan = with_plan.measured.rows();
            let new_session = offer.is_new_session;
            let origins = Origins { rows: of_plan, n_rows, sizes: &rows.sizes, new_session };
            let told_apart =
                ToldApart::of((question, &served), case, &with_plan, &origins)?.never(&never);
            let is_answered = |ask| {
                told_apart.is_enough(ask)
                    && named_by_loops(&question.asks[ask], &after, (model, linear))
            };
            let answered: Vec<bool> = (0..question.asks.len()).map(is_answered).collect();
            let mut asks = answered.iter().enumerate();
            let is_done = asks.all(|(ask, answered)| *answered || never.contains(&ask));
            let with_chosen = design.with(&sorted);
            let is_vain = |(ask, goal): &&(usize, Goal)| {
                told_apart.is_never(*ask) && design.is_met(goal, &with_chosen)
            };
            let vain: Vec<usize> = asked.iter().filter(is_vain).map(|(ask, _)| *ask).collect();
            let is_all = vain.is_empty() && sorted.len() >= most.min(offer.offered.len());
            let is_over = is_done || is_all || round == MOST_ROUNDS;
            never.extend(&vain);
            let named = is_done && never.is_empty();
            if is_over || vain.len() == asked.len() {
                return Ok(Self {
                    sorted,
                    rows,
                    with_plan,
                    after,
                    told_apart,
                    named,
                    never,
                    asked,
                });
            }
            asked.retain(|(ask, _)| !vain.contains(ask));
            harder(question, &answered, &mut asked);
        }
    }
}

/// Repeats of what was measured, beside a plan that has anything else.
fn add_controls(chosen: &mut Vec<usize>, controls: &[usize], most: usize) {
    let has_any = !chosen.is_empty();
    for &control in controls.iter().filter(|_| has_any) {
        if chosen.len() < most && !chosen.contains(&control) {
            chosen.push(control);
        }
    }
}

/// Whether loops on simulated data name an effect that is asked for, from the size on that matters.
fn named_by_loops(ask: &Ask, after: &[Assessment], (model, linear): (&dyn Model, &Linear)) -> bool {
    let Ask::Visible { effect } = ask else { return true };
    let Some(own) = model.declared().effects.iter().find(|e| linear::label(e) == *effect) else {
        return false;
    };
    let matter = question::sizes_that_matter(model, linear, effect);
    let found = figures::sizes(effect, after);
    own.parameters.iter().zip(matter).all(|(parameter, matters)| {
        let size = found.iter().find(|(name, ..)| *name == parameter.name);
        let matters = matters * parameter.report_factor.abs();
        size.is_some_and(|(_, size, _)| *size <= matters)
    })
}

/// Asks more of the tests of what is not answered.
fn harder(question: &Question, answered: &[bool], asked: &mut [(usize, Goal)]) {
    for (ask, goal) in asked.iter_mut().filter(|(ask, _)| !answered[*ask]) {
        if let Goal::Seen { needed, .. } = goal {
            let is_apart = matches!(question.asks[*ask], Ask::Apart { .. });
            *needed *= if is_apart { HARDER_APART } else { HARDER };
        }
    }
}

/// Goals that measurements can serve, and the ask of each.
fn hopeful(
    design: &Design,
    question: &Question,
    goals: &[(usize, Goal)],
) -> (Vec<usize>, Vec<Goal>) {
    let every: Vec<usize> = (0..design.n_offered()).collect();
    let all = design.with(&every);
    let is_hopeful = |(ask, goal): &&(usize, Goal)| {
        !matches!(question.asks[*ask], Ask::Apart { .. } | Ask::Visible { .. })
            || design.value(goal, &all) > HOPELESS
    };
    goals.iter().filter(is_hopeful).cloned().unzip()
}

/// What the design of a case sees of the effects asked for.
pub(super) fn assessed(
    question: &Question,
    case: &Case,
    of: &Case,
) -> Result<Vec<Assessment>, Error> {
    let asked = |label: &str| {
        question.asks.iter().any(|ask| matches!(ask, Ask::Visible { effect } if effect == label))
    };
    if !question.asks.iter().any(|ask| matches!(ask, Ask::Visible { .. })) {
        return Ok(Vec::new());
    }
    let prepared = of.measured.prepare()?;
    let assessed = assess_those(&*prepared.model, &case.loop_settings.options(), asked);
    assessed.map_err(|source| case.loop_error(source))
}
