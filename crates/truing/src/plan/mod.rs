//! What to measure next: which of the measurements that a machine can make tell rivals apart, make
//! an effect visible or a quantity better known.
//!
//! A kind of case offers measurements; each is a row of a table. The case is read with all of them
//! in it, at the readings that the declared model expects, and its own model gives the columns that
//! [`design`] chooses by. The figures are those of the case with the chosen ones alone.

mod answer;
mod design;
mod figures;
mod hand_out;
mod linear;
mod planned;
mod power;
mod problem;
mod program;
mod question;
mod rows;
mod text;

use std::path::{Path, PathBuf};

use model_discrepancy::{Assessment, Model, assess_those};

use crate::file::write_new;
use crate::{Case, Error, Header};

use answer::LoopAnswer;
use design::{Design, Goal};
use figures::Outlook;
use hand_out::{hand_out, measurements};
use linear::Linear;
use question::{Ask, Question};
use rows::Rows;

pub use planned::{PlanFigure, Planned, PlannedMeasurement, PlannedTouchPlace};
pub use problem::PlanProblem;

/// Fewest measurements that a plan may have where no budget is given.
const LEAST: usize = 12;
/// A non-centrality that no further measurement is worth.
const HOPELESS: f64 = 1.0;
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
    let table = case.files.folder.table(offer.table, &[])?;
    let n_measured = table.n_rows();

    let every: Vec<usize> = (0..offer.offered.len()).collect();
    let with_all = case.with(&[Rows::of(&table, &offer, &every)?.edit(&offer)])?;
    let prepared = with_all.measured.prepare()?;
    let model = &*prepared.model;
    let question = Question::of(&answer, options.aim.as_deref(), model).map_err(fail)?;
    let loop_options = case.loop_settings.options();
    let noise = answer.noise(components(model));
    let counts = [n_measured, every.len()];
    let linear = Linear::of(model, &question.effects(model), counts, noise);
    let mut goals = question.goals(model, &linear, &loop_options);
    if budget.is_some() {
        for (_, goal) in &mut goals {
            spend(goal);
        }
    }
    let design = Design::of(&linear.measured, &linear.planned);
    let hopeful = hopeful(&design, &question, &goals);
    let most = budget.unwrap_or(n_measured.max(LEAST));
    let chosen = design.exchanged(&hopeful, design.forward(&hopeful, most));
    let mut sorted = chosen.clone();
    // The order of the offer, in which place and time do not run together.
    sorted.sort_unstable();

    let rows = Rows::of(&table, &offer, &sorted)?;
    let with_plan = case.with(&[Rows::of(&table, &offer, &sorted)?.edit(&offer)])?;
    let after = with_plan.measured.prepare()?;
    let final_linear = Linear::of(
        &*after.model,
        &question.effects(&*after.model),
        [n_measured, sorted.len()],
        noise,
    );
    let final_goals = question.goals(&*after.model, &final_linear, &loop_options);
    let outlook = Outlook::of(&question, &*after.model, &final_linear);
    let assessed = assessed(&question, case, &with_plan)?;
    let figures = outlook.figures(&final_goals, [&assessed[0], &assessed[1]]);
    let spent = options.budget.is_some();
    let reached = reached(&question, (&goals, &design, &sorted), (&final_goals, &outlook), spent);
    let would = (!reached).then(|| would(&design, &question, &goals, offer.noun));

    let mut planned = Planned {
        kind: case.kind,
        version: env!("CARGO_PKG_VERSION"),
        header: Header::of("truing/plan/1", case),
        aim: question.aim.clone(),
        noun: offer.noun,
        measured: n_measured,
        planned: sorted.len(),
        minutes: offer.minutes.map(|minutes| minutes * as_f64(sorted.len())),
        reached,
        would,
        figures,
        plan: measurements(&rows, &offer, &sorted),
        warnings: case.warnings.clone(),
        files: Vec::new(),
    };
    planned.header.inputs.extend(answer.input);
    hand_out(&mut planned, case, &offer, (&rows, &rows.csv(&table, &offer)), &sorted);
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

/// Makes a goal for which nothing is ever enough.
fn spend(goal: &mut Goal) {
    if let Goal::Known { needed, .. } = goal {
        *needed = EVER_LESS;
    }
}

/// Goals that measurements can serve.
fn hopeful(design: &Design, question: &Question, goals: &[(usize, Goal)]) -> Vec<Goal> {
    let every: Vec<usize> = (0..design.n_offered()).collect();
    let all = design.with(&every);
    let is_hopeful = |(ask, goal): &&(usize, Goal)| {
        !matches!(question.asks[*ask], Ask::Apart { .. } | Ask::Visible { .. })
            || design.value(goal, &all) > HOPELESS
    };
    goals.iter().filter(is_hopeful).map(|(_, goal)| goal.clone()).collect()
}

/// Scalars of one observation.
fn components(model: &dyn Model) -> usize {
    let rows = &model.declared().layout.rows;
    rows.iter().filter(|row| row.reported).map(|row| row.component + 1).max().unwrap_or(1)
}

/// What the design sees without and with the plan, where that is asked.
fn assessed(question: &Question, case: &Case, with: &Case) -> Result<[Vec<Assessment>; 2], Error> {
    let asked = |label: &str| {
        question.asks.iter().any(|ask| matches!(ask, Ask::Visible { effect } if effect == label))
    };
    if !question.asks.iter().any(|ask| matches!(ask, Ask::Visible { .. })) {
        return Ok([Vec::new(), Vec::new()]);
    }
    let of = |case: &Case| {
        let prepared = case.measured.prepare()?;
        let assessed = assess_those(&*prepared.model, &case.loop_settings.options(), asked);
        assessed.map_err(|source| case.loop_error(source))
    };
    Ok([of(case)?, of(with)?])
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
        Ask::Visible { .. } => of(goals, index).all(|goal| design.is_safe(goal, chosen)),
        Ask::All => true,
        // As well as the budget lets it is all that is asked then.
        Ask::Known { .. } if spent => true,
        _ => of(final_goals, index).all(|goal| outlook.meets(goal)),
    };
    let asked = |index: usize| of(goals, index).next().is_some();
    (0..question.asks.len()).all(|index| asked(index) && met(index))
}

fn of(goals: &[(usize, Goal)], index: usize) -> impl Iterator<Item = &Goal> {
    goals.iter().filter(move |(ask, _)| *ask == index).map(|(_, goal)| goal)
}

/// What would reach the aim, where the plan does not.
fn would(design: &Design, question: &Question, goals: &[(usize, Goal)], noun: &str) -> String {
    let all: Vec<Goal> = goals.iter().map(|(_, goal)| goal.clone()).collect();
    let most = design.forward(&all, design.n_offered());
    let answered = (0..question.asks.len()).all(|ask| of(goals, ask).next().is_some());
    if answered && all.iter().all(|goal| design.is_safe(goal, &most)) {
        return format!("{} would reach it", text::counted(most.len(), noun));
    }
    match &question.advice {
        Some(advice) => format!("no {noun} that the machine is said to make reaches it; {advice}"),
        None => format!(
            "no {noun} that the machine is said to make reaches it; widen what `[plan]` declares, \
             or measure the quantity by other means"
        ),
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}
