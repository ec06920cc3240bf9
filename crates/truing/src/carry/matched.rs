use std::collections::BTreeSet;

use model_discrepancy::{Effect, Model, Scope, State};
use nalgebra::DVector;
use serde::Serialize;
use truing_report::by_sign;

use super::former::{present, present_amplitude};
use super::learnt::{Learnt, LearntStep};
use super::problem::CarryProblem;
use crate::Error;
use crate::case::quote;
use crate::estimated::LoopParameter;

/// Prefix of what the loop corrects along a column without knowing why.
pub(crate) const EMPIRICAL: &str = "covariate:";

/// Ending of the ids of effects that go with the course of one session.
const DRIFT: &str = "drift";

/// What is looked for in each case anew: its place or time is part of what it is.
const LOOKED_FOR: [&str; 2] = ["patch", "session-shift"];

/// An effect that counts as declared, with the amplitudes it was learnt to have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CarriedEffect {
    /// Catalogue id.
    pub effect: String,
    /// What it is about, where there is one candidate per thing.
    pub subject: Option<String>,
    /// One sentence for people.
    pub description: String,
    /// Amplitudes; their uncertainties are those of the case they were learnt on.
    pub parameters: Vec<LoopParameter>,
    /// Effects from which it could not be told where it was learnt: the same correction by another
    /// name.
    pub indistinguishable_from: Vec<String>,
}

/// Effects of a model that were learnt elsewhere.
pub(crate) struct Matched {
    pub(crate) effects: Vec<CarriedEffect>,
    /// One vector per effect of the model, zero where nothing is carried.
    pub(crate) amplitudes: Vec<DVector<f64>>,
    /// What stays behind, and what is doubtful.
    pub(crate) warnings: Vec<String>,
}

/// Finds the effects of `learnt` among those of `model`.
pub(crate) fn matched(learnt: &Learnt, model: &dyn Model) -> Result<Matched, Error> {
    let fail = |problem| Error::carry(&learnt.from, problem);
    let mut amplitudes = State::start(model).amplitudes;
    let (mut effects, mut left, mut doubts) = (Vec::new(), Vec::new(), Vec::new());
    let mut seen = BTreeSet::new();
    for step in &learnt.steps {
        let index = match place(step, model).map_err(fail)? {
            Place::At(index) => index,
            Place::Left(why) => {
                left.push(why);
                continue;
            }
        };
        let effect = &model.declared().effects[index];
        if !seen.insert(index) {
            return Err(fail(CarryProblem::Twice { effect: step.effect.clone() }));
        }
        let parameters = fill(step, effect, &mut amplitudes[index]).map_err(fail)?;
        let values: Vec<f64> = parameters.iter().map(|p| p.value).collect();
        if !step.indistinguishable_from.is_empty() {
            doubts.push(format!(
                "{} is carried under this name; where it was learnt it could not be told from {}",
                effect.id,
                step.indistinguishable_from.join(", ")
            ));
        }
        effects.push(CarriedEffect {
            effect: effect.id.clone(),
            subject: effect.subject.clone(),
            description: by_sign(&effect.description, &values),
            parameters,
            indistinguishable_from: step.indistinguishable_from.clone(),
        });
    }
    if effects.is_empty() {
        return Err(fail(CarryProblem::Nothing { left }));
    }
    let mut warnings: Vec<String> = left.into_iter().map(|w| format!("not carried: {w}")).collect();
    warnings.extend(doubts);
    Ok(Matched { effects, amplitudes, warnings })
}

/// Where a step belongs, or why it stays behind.
enum Place {
    At(usize),
    Left(String),
}

fn place(step: &LearntStep, model: &dyn Model) -> Result<Place, CarryProblem> {
    if let Some(column) = step.effect.strip_prefix(EMPIRICAL) {
        let column = quote(column);
        return Ok(Place::Left(format!(
            "the empirical correction along {column}, whose cause is not known and which holds only \
             where it was fitted"
        )));
    }
    if step.effect.ends_with(DRIFT) {
        let effect = quote(&step.effect);
        return Ok(Place::Left(format!("{effect}, which belongs to the course of that session")));
    }
    let catalogue = &model.declared().effects;
    let (id, own_subject) = present(&step.effect, step.subject.as_deref());
    let of_id = || catalogue.iter().enumerate().filter(|(_, e)| e.id == id);
    if of_id().next().is_none() && !LOOKED_FOR.contains(&id) {
        let known: BTreeSet<String> = catalogue.iter().map(|e| format!("`{}`", e.id)).collect();
        let known = known.into_iter().collect();
        return Err(CarryProblem::UnknownEffect { effect: step.effect.clone(), known });
    }
    let found = of_id().find(|(_, e)| e.subject.as_deref() == own_subject);
    let subject = step.subject.as_deref().map_or_else(String::new, |s| format!(" [{}]", quote(s)));
    Ok(match found {
        Some((index, _)) if is_of_one_observation(model, index) => Place::Left(format!(
            "`{}`{subject}, which is about one reading of the other case",
            step.effect
        )),
        Some((index, _)) => Place::At(index),
        None => Place::Left(format!("`{}`{subject}, which this case does not have", step.effect)),
    })
}

/// Whether an effect moves one observation alone.
pub(crate) fn is_of_one_observation(model: &dyn Model, effect: usize) -> bool {
    if matches!(model.declared().effects[effect].scope, Scope::Observation(_)) {
        return true;
    }
    let tangent = model.tangent(&State::start(model), effect);
    let rows = model.declared().layout.rows.iter().zip(tangent.row_iter());
    let moved: BTreeSet<usize> =
        rows.filter(|(_, row)| row.amax() > 0.0).map(|(row, _)| row.observation).collect();
    moved.len() == 1
}

/// Sets the amplitudes of one effect, in the model's own units.
fn fill(
    step: &LearntStep,
    effect: &Effect,
    amplitudes: &mut DVector<f64>,
) -> Result<Vec<LoopParameter>, CarryProblem> {
    let values: Vec<f64> = step.parameters.iter().filter_map(|p| p.value).collect();
    let said = by_sign(&effect.description, &values);
    // Both as it is said of that sign, and as it stands in the catalogue.
    let is_other = |d: &&String| **d != effect.description && **d != said;
    if let Some(there) = step.description.as_ref().filter(is_other) {
        let (effect, here) = (effect.id.clone(), effect.description.clone());
        return Err(CarryProblem::OtherConditions { effect, there: there.clone(), here });
    }
    let mut parameters = Vec::new();
    for given in &step.parameters {
        let name = present_amplitude(&effect.id, &given.name).to_owned();
        let Some(index) = effect.parameters.iter().position(|p| p.name == name) else {
            let known = effect.parameters.iter().map(|p| format!("`{}`", p.name)).collect();
            let effect = effect.id.clone();
            return Err(CarryProblem::UnknownParameter { effect, parameter: name, known });
        };
        let own = &effect.parameters[index];
        if own.unit != given.unit {
            let (found, expected) = (given.unit.clone(), own.unit.clone());
            let effect = effect.id.clone();
            return Err(CarryProblem::OtherUnit { effect, parameter: name, found, expected });
        }
        let Some(value) = given.value.filter(|v| v.is_finite()) else {
            return Err(CarryProblem::NotFinite { effect: effect.id.clone(), parameter: name });
        };
        amplitudes[index] = value / own.report_factor;
        let std = given.std.unwrap_or(f64::NAN);
        parameters.push(LoopParameter { name, value, unit: own.unit.clone(), std });
    }
    Ok(parameters)
}
