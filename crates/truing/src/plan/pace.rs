//! When planned measurements are made: what drifts goes on, the further the more of them there are.

use model_discrepancy::Model;

use super::answer::LoopAnswer;
use super::chosen::hopeful;
use super::design::{Design, Goal, Number};
use super::linear::{Linear, Origins};
use super::question::Question;
use super::rows::Rows;
use crate::kinds::Offer;
use crate::{Case, Error};

/// Lengths of a plan that are tried.
const MOST_ROUNDS: usize = 6;

/// The case with measurements on offer: all of them, in the time that a plan of some takes, or those that were chosen.
pub(super) struct Everything {
    pub(super) rows: Rows,
    pub(super) case: Case,
}

/// What is asked, of whom, and how many measurements may answer it.
pub(super) struct Asked<'a> {
    pub(super) case: &'a Case,
    pub(super) offer: &'a Offer,
    pub(super) answer: &'a LoopAnswer,
    /// Rows of the table of the case.
    pub(super) n_rows: usize,
    pub(super) most: usize,
}

/// What measurements are chosen by.
pub(super) struct Laid {
    pub(super) linear: Linear,
    pub(super) design: Design,
    pub(super) goals: Vec<(usize, Goal)>,
}

impl Everything {
    fn of(case: &Case, offer: &Offer, n_made: usize) -> Result<Self, Error> {
        let every: Vec<usize> = (0..offer.offered.len()).collect();
        let rows = Rows::paced(&case.files.folder, offer, &every, n_made)?;
        let case = case.with(&rows.edits())?;
        Ok(Self { rows, case })
    }

    /// In the time of `n_made` measurements; where the table has times, in that of as many as are then
    /// chosen, or a few fewer: a plan that lasts longer shows a drift no less.
    pub(super) fn in_time(
        asked: &Asked<'_>,
        n_made: usize,
        question: impl Fn(&dyn Model) -> Result<Question, Error>,
    ) -> Result<Self, Error> {
        let mut n = n_made.min(asked.most).min(asked.offer.offered.len()).max(1);
        let mut all = Self::of(asked.case, asked.offer, n)?;
        // Too few, in whose time more would be chosen, and too many.
        let (mut few, mut many) = (0, usize::MAX);
        for _ in 0..MOST_ROUNDS {
            if !all.rows.are_timed() {
                break;
            }
            let chosen = all.chosen(asked, &question)?;
            if (n..=n + n / 4).contains(&chosen) {
                break;
            }
            if chosen > n {
                few = n;
            } else {
                many = n;
            }
            let next = if many == usize::MAX { chosen } else { usize::midpoint(few, many) };
            if next == few {
                break;
            }
            n = next.max(1);
            all = Self::of(asked.case, asked.offer, n)?;
        }
        Ok(all)
    }

    /// How many measurements are chosen by tests alone.
    fn chosen(
        &self,
        asked: &Asked<'_>,
        question: impl Fn(&dyn Model) -> Result<Question, Error>,
    ) -> Result<usize, Error> {
        let prepared = self.case.measured.prepare_planned(asked.n_rows)?;
        let model = &*prepared.model;
        let question = question(model)?;
        let laid = self.laid_out(asked, model, &question);
        let (_, goals) = hopeful(&laid.design, &question, &laid.goals);
        Ok(laid.design.chosen(&goals, Number::of(asked.offer, asked.most)).len())
    }

    /// Columns, design and goals of the model that was prepared of it.
    pub(super) fn laid_out(
        &self,
        asked: &Asked<'_>,
        model: &dyn Model,
        question: &Question,
    ) -> Laid {
        let origins = Origins {
            rows: self.case.measured.rows(),
            n_rows: asked.n_rows,
            sizes: &self.rows.sizes,
            new_session: asked.offer.is_new_session,
        };
        let linear =
            Linear::of(model, &question.effects(model), &origins, asked.answer.noise(model));
        let design = Design::of(&linear.measured, &linear.planned, linear.n_base);
        let goals = question.goals(model, &linear, &asked.case.loop_settings.options());
        Laid { linear, design, goals }
    }
}
