//! What to measure next: which of the measurements that a machine can make tell rivals apart, make
//! an effect visible or a quantity better known.
//!
//! A kind of case offers measurements; each is a row of a table. The case is read with all of them
//! in it, at the readings that the declared model expects, and its own model gives the columns that
//! [`design`] chooses by. The figures are those of the case with the chosen ones alone.

mod answer;
mod chosen;
mod design;
mod figures;
mod foreseen;
mod hand_out;
mod inseparable;
mod linear;
mod pace;
mod planned;
mod power;
mod problem;
mod program;
mod question;
mod rows;
mod text;

use std::path::{Path, PathBuf};

use model_discrepancy::Model;

use crate::file::write_new;
use crate::kinds::Offer;
use crate::{Case, Error, Header};

use answer::LoopAnswer;
use chosen::{Chosen, Extended, Setting, assessed};
use design::{Design, Goal, Number};
use figures::Outlook;
use hand_out::{hand_out, handed_rows, measurements};
use pace::{Asked, Everything, Laid};
use question::{Ask, Question};

pub use planned::{
    PlanClass, PlanFigure, Planned, PlannedMeasurement, PlannedTouchPlace, Prediction,
};
pub use problem::PlanProblem;

/// Fewest measurements that a plan may have where no budget is given.
const LEAST: usize = 12;
/// What is said of a plan that meets its tests and not its aim.
const TOO_SELDOM: &str = "every test of the plan is met, and loops on simulated data still name the effect too seldom, or \
     leave a rival: make the plan twice, or look for larger sizes";
/// Share of its variance that a quantity can keep where a budget is to be used up: none.
const EVER_LESS: f64 = 1e-12;

/// What a plan is made for, and what it may cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanOptions {
    /// What `truing loop --json` printed for the case; without it the loop is closed first.
    pub answer: Option<PathBuf>,
    /// `rivals`, `unobservable`, `all`, or names of effects and quantities, separated by commas;
    /// without it rivals, or else what is not observable.
    pub aim: Option<String>,
    /// How much may be measured; without it as much as was measured.
    pub budget: Option<PlanBudget>,
}

/// How much may be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanBudget {
    /// Measurements.
    Measurements(usize),
    /// Minutes, at `[plan] minutes_per_measurement`.
    Minutes(f64),
}

/// Plans the next measurements of a case.
///
/// # Errors
///
/// [`Error::Plan`] where nothing can be planned; [`Error::Carry`] for an answer that is none; as
/// [`close_loop`](crate::close_loop).
pub fn plan(case: &Case, options: &PlanOptions) -> Result<Planned, Error> {
    let fail = |problem| Error::plan(&case.path, problem);
    let no_planner = PlanProblem::NoPlanner { kind: case.kind };
    let offer = case.measured.offer()?.ok_or_else(|| fail(no_planner))?;
    if offer.offered.is_empty() {
        return Err(fail(PlanProblem::NoPlace));
    }
    let budget = most(options.budget, offer.minutes).map_err(fail)?;
    let answer = LoopAnswer::of(case, options.answer.as_deref())?;
    let folder = &case.files.folder;
    let n_rows = folder.table(offer.table, &[])?.n_rows();
    let made = offer.made.unwrap_or(n_rows);
    let most = budget.unwrap_or(made.max(LEAST));
    let asking = Asked { case, offer: &offer, answer: &answer, n_rows, most };
    let question =
        |model: &dyn Model| Question::of(&answer, options.aim.as_deref(), model).map_err(fail);
    let all = Everything::in_time(&asking, made, question)?;
    let prepared = all.case.measured.prepare_planned(n_rows)?;
    let model = &*prepared.model;
    let question = question(model)?;
    let Laid { linear, design, mut goals } = all.laid_out(&asking, model, &question);
    spend(budget, &mut goals);
    let pairs = inseparable::taken_out(&design, &mut goals);
    let before = assessed(&question, case, (case, n_rows))?;
    let setting = Setting {
        case,
        offer: &offer,
        question: &question,
        design: &design,
        model,
        linear: &linear,
        n_rows,
        most,
    };
    let chosen = Chosen::of(&setting, goals.clone())?;
    let named = chosen.is_answered();
    let Chosen { extended, after, told_apart, never, asked, .. } = chosen;
    let Extended { sorted, rows, case: with_plan } = extended;
    let with_plan = Everything { rows, case: with_plan };
    let final_prepared = with_plan.case.measured.prepare_planned(n_rows)?;
    let final_model = &*final_prepared.model;
    let Laid { linear: final_linear, goals: final_goals, .. } =
        with_plan.laid_out(&asking, final_model, &question);
    let rows = &with_plan.rows;
    let outlook = Outlook::of(&question, final_model, &final_linear);
    let figures = outlook.figures(&final_goals, [&before, &after], &told_apart);
    let spent = options.budget.is_some();
    let reached =
        named && reached(&question, (&goals, &design, &sorted), (&final_goals, &outlook), spent);
    let not_told_apart = inseparable::not_told_apart(&question, &pairs, offer.noun);
    let classes = inseparable::classes(&question, &pairs);
    let would = (!reached).then(|| match not_told_apart.first() {
        Some(weakly) => format!("{weakly}; {}", wider(&offer)),
        None if !never.is_empty() => beyond(&question, &offer),
        None if named || sorted.len() >= most || !are_met(&design, &question, &asked, &sorted) => {
            would(&design, &question, &asked, &offer)
        }
        None => TOO_SELDOM.to_owned(),
    });
    let mut warnings = case.warnings.clone();
    warnings.extend(not_told_apart);
    warnings.extend(classes.iter().map(|class| class.words(offer.noun)));
    let mut planned = Planned {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::of("truing/plan/1", case),
        aim: question.aim.clone(),
        noun: offer.noun,
        measured: made,
        planned: sorted.len(),
        minutes: offer.minutes.map(|minutes| minutes * as_f64(sorted.len())),
        reached,
        would,
        classes,
        predicted: Prediction::of(&figures),
        figures,
        plan: measurements(rows, &offer, &sorted),
        measurements: handed_rows(rows, &offer, &sorted),
        program: None,
        warnings,
        files: Vec::new(),
    };
    planned.header.inputs.extend(answer.input);
    hand_out(&mut planned, case, &offer, (rows, &rows.csv()), &sorted);
    Ok(planned)
}

/// Writes the files of a plan into a folder, where none of them may exist.
///
/// # Errors
///
/// [`Error::Exists`], [`Error::NotWritten`].
pub fn write_plan(planned: &Planned, folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let files: Vec<(&str, &str)> =
        planned.files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    write_new(folder, &files)
}

/// Measurements that the budget pays for.
fn most(budget: Option<PlanBudget>, each: Option<f64>) -> Result<Option<usize>, PlanProblem> {
    let count = match budget {
        None => return Ok(None),
        Some(PlanBudget::Measurements(count)) => count,
        Some(PlanBudget::Minutes(minutes)) => {
            let each = each.ok_or(PlanProblem::NoTime)?;
            // A round number of measurements stays one through the division.
            let fits = (minutes / each * (1.0 + f64::EPSILON)).floor();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "budget and time of one are positive"
            )]
            let fits = fits as usize;
            fits
        }
    };
    if count == 0 { Err(PlanProblem::NoBudget) } else { Ok(Some(count)) }
}

/// Makes goals for which nothing is ever enough, where a budget says how far to go.
fn spend(budget: Option<usize>, goals: &mut [(usize, Goal)]) {
    for (_, goal) in goals.iter_mut().filter(|_| budget.is_some()) {
        if let Goal::Known { needed, .. } = goal {
            *needed = EVER_LESS;
        }
    }
}

/// Whether every ask is answered with the plan: rivals and quantities by the model of the case with
/// it, effects at the size that matters by the model that they were chosen by; `spent` where a
/// budget says how far a quantity goes.
fn reached(
    question: &Question,
    (goals, design, chosen): (&[(usize, Goal)], &Design, &[usize]),
    (final_goals, outlook): (&[(usize, Goal)], &Outlook<'_>),
    spent: bool,
) -> bool {
    let met = |index: usize| match &question.asks[index] {
        Ask::Visible { .. } => {
            let own: Vec<Goal> = of(goals, index).cloned().collect();
            design.are_safe(&own, chosen)
        }
        Ask::All => true,
        // As well as the budget lets it is all that is asked then.
        Ask::Known { .. } if spent => true,
        _ => of(final_goals, index).all(|goal| outlook.meets(goal)),
    };
    is_all_asked(question, goals) && (0..question.asks.len()).all(met)
}

/// Whether some measurement on offer shows each thing that is asked for.
fn is_all_asked(question: &Question, goals: &[(usize, Goal)]) -> bool {
    (0..question.asks.len()).all(|index| of(goals, index).next().is_some())
}

fn of(goals: &[(usize, Goal)], index: usize) -> impl Iterator<Item = &Goal> {
    goals.iter().filter(move |(ask, _)| *ask == index).map(|(_, goal)| goal)
}

/// Whether measurements show all that is asked for, by every test.
fn are_met(
    design: &Design,
    question: &Question,
    goals: &[(usize, Goal)],
    chosen: &[usize],
) -> bool {
    let all: Vec<Goal> = goals.iter().map(|(_, goal)| goal.clone()).collect();
    is_all_asked(question, goals) && design.are_safe(&all, chosen)
}

/// What would reach the aim, where the plan does not.
fn would(design: &Design, question: &Question, goals: &[(usize, Goal)], offer: &Offer) -> String {
    let all: Vec<Goal> = goals.iter().map(|(_, goal)| goal.clone()).collect();
    let most = design.forward(&all, Number::up_to(design.n_offered()));
    if are_met(design, question, goals, &most) {
        return format!("{} would reach it", text::counted(most.len(), offer.noun));
    }
    beyond(question, offer)
}

/// What would, where no measurement of the offer does.
fn beyond(question: &Question, offer: &Offer) -> String {
    let none = format!("no {} that the machine is said to make reaches it", offer.noun);
    match &question.advice {
        Some(advice) => format!("{none}; {advice}; or {}", wider(offer)),
        None => format!("{none}; {}, or measure the quantity by other means", wider(offer)),
    }
}

/// How to have more measurements on offer.
fn wider(offer: &Offer) -> String {
    let keys: Vec<String> = offer.undeclared.iter().map(|key| format!("`{key}`")).collect();
    if keys.is_empty() {
        return "widen what `[plan]` declares".to_owned();
    }
    format!("declare in `[plan]` what else the machine can do, by {}", keys.join(", "))
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
