//! The measurements of a plan: chosen by the tests of the linearised model, tried by loops.

use model_discrepancy::{Assessment, Model, assess_those};

use super::design::{Design, Goal, HOPELESS, Number};
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
/// The same of what no loop answers: as much as all rounds ask together.
const HARDEST: f64 = 8.0;
/// Rounds of asking more; the last asks for eight times the first.
const MOST_ROUNDS: usize = 4;

/// What measurements are chosen by.
pub(super) struct Setting<'a> {
    pub(super) case: &'a Case,
    pub(super) offer: &'a Offer,
    pub(super) question: &'a Question,
    pub(super) design: &'a Design,
    /// With every measurement on offer.
    pub(super) model: &'a dyn Model,
    /// Of that model.
    pub(super) linear: &'a Linear,
    /// Rows of the table of the case.
    pub(super) n_rows: usize,
    /// Measurements that a plan may have.
    pub(super) most: usize,
}

/// Measurements, and the case with them.
pub(super) struct Extended {
    /// By their place in the offer, in its order.
    pub(super) sorted: Vec<usize>,
    pub(super) rows: Rows,
    pub(super) case: Case,
}

/// The measurements of a plan, and what is known of it.
pub(super) struct Chosen {
    pub(super) extended: Extended,
    /// What the design sees with the plan.
    pub(super) after: Vec<Assessment>,
    pub(super) told_apart: ToldApart,
    /// Whether loops answer each ask often enough.
    answered: Vec<bool>,
    /// Asks that loops never answer although the tests are met.
    pub(super) never: Vec<usize>,
    /// What was asked of the tests.
    pub(super) asked: Vec<(usize, Goal)>,
}

impl Extended {
    fn of(case: &Case, offer: &Offer, mut chosen: Vec<usize>) -> Result<Self, Error> {
        // The order of the offer, in which place and time do not run together.
        chosen.sort_unstable();
        let rows = Rows::of(&case.files.folder, offer, &chosen)?;
        let case = case.with(&rows.edits())?;
        Ok(Self { sorted: chosen, rows, case })
    }
}

impl Chosen {
    /// What the tests of the linearised model promise is held against loops on simulated data of the same
    /// design; where they name an effect too seldom, more is asked of the tests, and what they never tell
    /// from its rivals, though eight times as much shows it, is not asked any more. Where loops answer nothing at
    /// all, nothing is to be measured.
    pub(super) fn of(setting: &Setting<'_>, mut asked: Vec<(usize, Goal)>) -> Result<Self, Error> {
        let mut never: Vec<usize> = Vec::new();
        let mut doubted: Vec<usize> = Vec::new();
        let mut round = 0;
        loop {
            round += 1;
            let mut tried = Self::tried(setting, asked, never)?;
            let (vain, newly): (Vec<usize>, Vec<usize>) =
                tried.vain(setting.design).into_iter().partition(|ask| doubted.contains(ask));
            let is_all = vain.is_empty()
                && newly.is_empty()
                && tried.extended.sorted.len() >= setting.most.min(setting.offer.offered.len());
            let is_over = tried.is_done() || is_all || round == MOST_ROUNDS;
            tried.never.extend(&vain);
            if is_over || vain.len() == tried.asked.len() {
                if tried.answers_nothing() {
                    tried.extended = Extended::of(setting.case, setting.offer, Vec::new())?;
                }
                return Ok(tried);
            }
            (asked, never) = (tried.asked, tried.never);
            asked.retain(|(ask, _)| !vain.contains(ask));
            harder(setting.question, &tried.answered, &newly, &mut asked);
            doubted.extend(newly);
        }
    }

    /// Measurements that meet the tests, and what loops on simulated data make of them.
    fn tried(
        setting: &Setting<'_>,
        asked: Vec<(usize, Goal)>,
        never: Vec<usize>,
    ) -> Result<Self, Error> {
        let Setting { case, offer, question, design, model, linear, n_rows, most } = *setting;
        let (served, hopeful) = hopeful(design, question, &asked);
        let mut chosen = design.chosen(&hopeful, Number::of(offer, most));
        add_controls(&mut chosen, &offer.controls, most);
        let extended = Extended::of(case, offer, chosen)?;
        let after = assessed(question, case, (&extended.case, n_rows))?;
        let origins = Origins {
            rows: extended.case.measured.rows(),
            n_rows,
            sizes: &extended.rows.sizes,
            new_session: offer.is_new_session,
        };
        let told_apart =
            ToldApart::of((question, &served), case, &extended.case, &origins)?.never(&never);
        let is_answered = |(index, ask): (usize, &Ask)| {
            told_apart.is_enough(index) && named_by_loops(ask, &after, (model, linear))
        };
        let answered = question.asks.iter().enumerate().map(is_answered).collect();
        Ok(Self { extended, after, told_apart, answered, never, asked })
    }

    /// Asks whose tests are met and that no loop answers.
    fn vain(&self, design: &Design) -> Vec<usize> {
        let with_chosen = design.with(&self.extended.sorted);
        let is_vain = |(ask, goal): &&(usize, Goal)| {
            self.told_apart.is_never(*ask) && design.is_met(goal, &with_chosen)
        };
        self.asked.iter().filter(is_vain).map(|(ask, _)| *ask).collect()
    }

    fn is_done(&self) -> bool {
        let mut asks = self.answered.iter().enumerate();
        asks.all(|(ask, answered)| *answered || self.never.contains(&ask))
    }

    /// Whether loops told no truth from any rival of it.
    fn answers_nothing(&self) -> bool {
        (0..self.answered.len())
            .all(|ask| self.told_apart.is_never(ask) || self.never.contains(&ask))
    }

    /// Whether loops answer all that is asked for often enough.
    pub(super) fn is_answered(&self) -> bool {
        self.never.is_empty() && self.is_done()
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

/// Asks more of the tests of what is not answered, and most of what no loop has answered so far.
fn harder(question: &Question, answered: &[bool], never: &[usize], asked: &mut [(usize, Goal)]) {
    for (ask, goal) in asked.iter_mut().filter(|(ask, _)| !answered[*ask]) {
        if let Goal::Seen { needed, .. } = goal {
            *needed *= match question.asks[*ask] {
                _ if never.contains(ask) => HARDEST,
                Ask::Apart { .. } => HARDER_APART,
                _ => HARDER,
            };
        }
    }
}

/// Goals that measurements can serve, and the ask of each.
pub(super) fn hopeful(
    design: &Design,
    question: &Question,
    goals: &[(usize, Goal)],
) -> (Vec<usize>, Vec<Goal>) {
    let is_hopeful = |(ask, goal): &&(usize, Goal)| {
        !matches!(question.asks[*ask], Ask::Apart { .. } | Ask::Visible { .. })
            || design.value(goal, design.with_all()) > HOPELESS
    };
    goals.iter().filter(is_hopeful).cloned().unzip()
}

/// What the design of a case sees of the effects asked for.
pub(super) fn assessed(
    question: &Question,
    case: &Case,
    (of, n_measured): (&Case, usize),
) -> Result<Vec<Assessment>, Error> {
    let asked = |label: &str| {
        question.asks.iter().any(|ask| matches!(ask, Ask::Visible { effect } if effect == label))
    };
    if !question.asks.iter().any(|ask| matches!(ask, Ask::Visible { .. })) {
        return Ok(Vec::new());
    }
    let prepared = of.measured.prepare_planned(n_measured)?;
    let assessed = assess_those(&*prepared.model, &case.loop_settings.options(), asked);
    assessed.map_err(|source| case.loop_error(source))
}
