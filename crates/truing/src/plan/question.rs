//! What a plan is made for, and what that asks of the linearised model.

use std::collections::BTreeSet;

use model_discrepancy::{Model, Options};
use nalgebra::{DMatrix, DVector};

use super::answer::{Amplitude, LoopAnswer};
use super::design::Goal;
use super::linear::{Linear, label};
use super::power::needed;
use super::problem::PlanProblem;
use crate::carry::is_of_one_observation;

/// Probability with which every single test of a plan is to answer, so that all of them together,
/// and what the loop asks beyond them, do in nineteen of twenty.
pub(super) const WANTED: f64 = 0.99;
/// The same of a test between rivals: the loop also judges it under noise with memory, which takes some
/// of what white noise promises, and there is no margin in the size, as it is the one found.
const WANTED_APART: f64 = 0.999;
/// Significance at which the loop keeps a name beside its rival; its `DECIDED`.
pub(super) const DECIDED: f64 = 0.01;
/// Share of the loop's budget for single effects; its `CATALOGUE_SHARE`.
const CATALOGUE_SHARE: f64 = 0.5;
/// Root mean square of an effect's trace over what can be measured, in standard uncertainties of a
/// reading, from which on it matters: below it, readings scatter as much without it.
const MATTERS: f64 = 2.0;
/// Share of its variance that a quantity shall keep where no budget is given: half its uncertainty.
const QUARTER: f64 = 0.25;
/// Singular values below this share of the largest are directions that no row shows.
const FREE: f64 = 1e-9;

/// A shift of everything that is measured later, as plans speak of it.
const SESSION: &str = "a shift between this session and the next";
/// Word for the rivals of an answer.
const RIVALS: &str = "rivals";
/// Word for the effects that an answer calls not observable.
const UNOBSERVABLE: &str = "unobservable";

/// One thing to find out.
#[derive(Clone, Debug)]
pub(super) enum Ask {
    /// Which of two names is right, if it is `truth`, in the place of what the answer calls `accepted`.
    Apart { truth: String, rival: String, accepted: String, sizes: Sizes },
    /// An effect, whatever its size.
    Visible { effect: String },
    /// A parameter of the declared model.
    Known { parameter: String },
    /// All parameters of the model.
    All,
}

/// How large a truth is.
#[derive(Clone, Debug)]
pub(super) enum Sizes {
    /// As the loop found it.
    Found(Vec<Amplitude>),
    /// As it has to be to look like another effect of this size.
    Imitating { other: String, sizes: Vec<Amplitude> },
}

/// Everything that is asked.
#[derive(Clone, Debug)]
pub(super) struct Question {
    pub(super) asks: Vec<Ask>,
    /// What the answer found, by label.
    accepted: Vec<String>,
    /// In words.
    pub(super) aim: String,
    /// What the loop itself proposes.
    pub(super) advice: Option<String>,
}

impl Question {
    /// What `wanted`, or else the answer, asks of a model that knows all effects.
    pub(super) fn of(
        answer: &LoopAnswer,
        wanted: Option<&str>,
        model: &dyn Model,
    ) -> Result<Self, PlanProblem> {
        let accepted = answer.steps.iter().map(super::answer::Step::label);
        let labels: Vec<String> = model.declared().effects.iter().map(label).collect();
        let question = |asks, aim: &str, advice: Option<String>| Self {
            asks,
            accepted: accepted.clone().filter(|a| labels.contains(a)).collect(),
            aim: aim.to_owned(),
            advice,
        };
        let (rivals, proposed) = rivals(answer, model, &labels);
        let unseen: Vec<&super::answer::Unseen> =
            answer.not_observable.iter().filter(|u| labels.contains(&u.effect)).collect();
        let of_unseen =
            || unseen.iter().map(|u| Ask::Visible { effect: u.effect.clone() }).collect();
        let advice = |is_asked: &dyn Fn(&str) -> bool| {
            let asked = unseen.iter().filter(|u| is_asked(&u.effect));
            let all: BTreeSet<String> = asked.filter_map(|u| u.advice()).collect();
            (!all.is_empty()).then(|| all.into_iter().collect::<Vec<_>>().join("; "))
        };
        let default = if rivals.is_empty() { UNOBSERVABLE } else { RIVALS };
        match wanted.unwrap_or(default) {
            RIVALS if rivals.is_empty() => Err(PlanProblem::NoRivals),
            RIVALS => Ok(question(rivals, RIVALS, proposed.cloned())),
            UNOBSERVABLE if unseen.is_empty() => Err(PlanProblem::NothingToAsk),
            UNOBSERVABLE => Ok(question(of_unseen(), UNOBSERVABLE, advice(&|_| true))),
            "all" => Ok(question(vec![Ask::All], "all", None)),
            list => {
                let mut asks = Vec::new();
                for name in list.split(',').map(str::trim) {
                    asks.extend(named(name, model, &labels)?);
                }
                Ok(question(asks, list, advice(&|effect| list.contains(effect))))
            }
        }
    }

    /// What the answer found, with `truth` in the place of what it calls `accepted`.
    pub(super) fn with_instead<'a>(&'a self, truth: &'a str, accepted: &str) -> Vec<&'a str> {
        let others =
            self.accepted.iter().map(String::as_str).filter(|a| *a != accepted && *a != truth);
        others.chain([truth]).collect()
    }

    /// Effects whose columns are needed, by their place in the model.
    pub(super) fn effects(&self, model: &dyn Model) -> Vec<usize> {
        let asked = self.asks.iter().flat_map(|ask| match ask {
            Ask::Apart { truth, rival, .. } => vec![truth, rival],
            Ask::Visible { effect } => vec![effect],
            Ask::Known { .. } | Ask::All => Vec::new(),
        });
        let wanted: Vec<&String> = self.accepted.iter().chain(asked).collect();
        // What an effect may be taken for instead.
        let rivals = self.asks.iter().any(|ask| matches!(ask, Ask::Visible { .. }));
        let is_needed = |(index, e): &(usize, &model_discrepancy::Effect)| {
            wanted.contains(&&label(e)) || (rivals && !is_of_one_observation(model, *index))
        };
        let effects = model.declared().effects.iter().enumerate();
        effects.filter(is_needed).map(|(index, _)| index).collect()
    }

    /// The goals, with the ask that each belongs to; none of an ask that the model has no columns
    /// for.
    pub(super) fn goals(
        &self,
        model: &dyn Model,
        linear: &Linear,
        options: &Options,
    ) -> Vec<(usize, Goal)> {
        let mut goals = Vec::new();
        for (index, ask) in self.asks.iter().enumerate() {
            let of = self.goals_of(ask, model, linear, options);
            goals.extend(of.into_iter().map(|goal| (index, goal)));
        }
        goals
    }

    fn goals_of(
        &self,
        ask: &Ask,
        model: &dyn Model,
        linear: &Linear,
        options: &Options,
    ) -> Vec<Goal> {
        match ask {
            Ask::Apart { truth, rival, accepted, sizes } => {
                let columns = |of: &str| columns(model, linear, of);
                let of = columns(truth);
                let others = self.others(model, linear, &[truth, rival, accepted]);
                let beside = [others.clone(), columns(rival)].concat();
                let amplitude = match sizes {
                    Sizes::Found(sizes) => found(model, truth, sizes),
                    Sizes::Imitating { other, sizes } => {
                        let (known, shown) = (found(model, other, sizes), columns(other));
                        imitating(&linear.measured, (&shown, &known), &of, &others)
                    }
                };
                if of.is_empty() || amplitude.norm() == 0.0 {
                    return Vec::new();
                }
                let dof = degrees_of_freedom(linear, beside.len() + of.len());
                let needed = needed(WANTED_APART, of.len(), dof, DECIDED);
                // Whatever lies between the two sessions may not look like what is to be told.
                let beside = [beside, linear.session().to_vec()].concat();
                vec![Goal::Seen { of, amplitude, beside, needed, from: None }]
            }
            Ask::Visible { effect } => {
                let beside = self.others(model, linear, &[effect]);
                let dof = degrees_of_freedom(linear, beside.len() + 1);
                let of_effect = needed(WANTED, 1, dof, level(model, options));
                let beside_rival = needed(WANTED, 1, dof, DECIDED);
                let rivals: Vec<String> = (model.declared().effects.iter().enumerate())
                    .filter(|(index, _)| !is_of_one_observation(model, *index))
                    // A period or lag that is looked for in the readings is none before there are any.
                    .filter(|(_, other)| other.searched <= 1)
                    .map(|(_, other)| label(other))
                    .filter(|l| l != effect && !self.accepted.contains(l))
                    .collect();
                let mut goals = Vec::new();
                let own = columns(model, linear, effect);
                for &column in &own {
                    // Places along a diagonal show two slopes, and not how they differ.
                    let beside: Vec<usize> = beside
                        .iter()
                        .chain(own.iter().filter(|o| **o != column))
                        .copied()
                        .collect();
                    let amplitude = DVector::from_element(1, size_that_matters(linear, column));
                    let seen = |needed, from: Option<String>| {
                        let rival = from.iter().flat_map(|rival| columns(model, linear, rival));
                        let beside = beside.iter().copied().chain(rival).collect();
                        let (of, amplitude) = (vec![column], amplitude.clone());
                        Goal::Seen { of, amplitude, beside, needed, from }
                    };
                    goals.push(seen(of_effect, None));
                    if !linear.session().is_empty() {
                        let beside = beside.iter().chain(linear.session()).copied().collect();
                        let (of, amplitude) = (vec![column], amplitude.clone());
                        let from = Some(SESSION.to_owned());
                        goals.push(Goal::Seen {
                            of,
                            amplitude,
                            beside,
                            needed: beside_rival,
                            from,
                        });
                    }
                    goals
                        .extend(rivals.iter().map(|rival| seen(beside_rival, Some(rival.clone()))));
                }
                goals
            }
            Ask::Known { parameter } => {
                let base = &model.declared().base;
                let Some(of) = base.iter().position(|p| p.name == *parameter) else {
                    return Vec::new();
                };
                let mut beside = self.others(model, linear, &[]);
                beside.retain(|column| *column != of);
                vec![Goal::Known { of, beside, needed: QUARTER }]
            }
            Ask::All => vec![Goal::Determined { columns: self.others(model, linear, &[]) }],
        }
    }

    /// Columns of base and accepted effects but these.
    fn others(&self, model: &dyn Model, linear: &Linear, without: &[&str]) -> Vec<usize> {
        let accepted = self.accepted.iter().filter(|a| !without.contains(&a.as_str()));
        let of = accepted.flat_map(|a| columns(model, linear, a));
        linear.base().into_iter().chain(of).collect()
    }
}

/// Every pair of names for the same thing, both ways, and what the loop proposes to tell them apart.
fn rivals<'a>(
    answer: &'a LoopAnswer,
    model: &dyn Model,
    labels: &[String],
) -> (Vec<Ask>, Option<&'a String>) {
    let (mut asks, mut proposed) = (Vec::new(), None);
    let can_be_asked = |name: &String| {
        let index = labels.iter().position(|label| label == name);
        index.is_some_and(|index| !is_of_one_observation(model, index))
    };
    for step in &answer.steps {
        let accepted = step.label();
        let others: Vec<&String> = step.rivals().iter().filter(|name| can_be_asked(name)).collect();
        if others.is_empty() {
            continue;
        }
        proposed = proposed.or(step.separate_by.as_ref());
        if !labels.contains(&accepted) {
            // The data have it, as a form that is place and size over all that can be measured: whether it is
            // one of the others is seen by them.
            asks.extend(others.into_iter().map(|name| Ask::Visible { effect: name.clone() }));
            continue;
        }
        let known: Vec<String> = std::iter::once(&accepted).chain(others).cloned().collect();
        for truth in &known {
            let sizes = || {
                let sizes = step.parameters.clone();
                if *truth == accepted {
                    Sizes::Found(sizes)
                } else {
                    Sizes::Imitating { other: accepted.clone(), sizes }
                }
            };
            let others = known.iter().filter(|rival| *rival != truth);
            asks.extend(others.map(|rival| Ask::Apart {
                truth: truth.clone(),
                rival: rival.clone(),
                accepted: accepted.clone(),
                sizes: sizes(),
            }));
        }
    }
    (asks, proposed)
}

/// Effects of that id, or the parameter of that name.
fn named(name: &str, model: &dyn Model, labels: &[String]) -> Result<Vec<Ask>, PlanProblem> {
    let declared = model.declared();
    let is_it = |(e, l): &(&model_discrepancy::Effect, &String)| e.id == name || *l == name;
    let effects = declared.effects.iter().zip(labels).filter(is_it);
    let asks: Vec<Ask> = effects.map(|(_, l)| Ask::Visible { effect: l.clone() }).collect();
    if !asks.is_empty() {
        return Ok(asks);
    }
    if declared.base.iter().any(|p| p.name == name) {
        return Ok(vec![Ask::Known { parameter: name.to_owned() }]);
    }
    let mut known: Vec<String> = ["rivals", "unobservable", "all"].map(str::to_owned).into();
    known.extend(declared.base.iter().map(|p| p.name.clone()));
    for effect in &declared.effects {
        if !known.contains(&effect.id) {
            known.push(effect.id.clone());
        }
    }
    Err(PlanProblem::UnknownAim { found: name.to_owned(), known })
}

fn columns(model: &dyn Model, linear: &Linear, of: &str) -> Vec<usize> {
    let effect = model.declared().effects.iter().position(|e| label(e) == of);
    effect.map_or_else(Vec::new, |effect| linear.columns(model, effect))
}

/// Amplitudes in internal units; zero where the answer has none.
fn found(model: &dyn Model, of: &str, sizes: &[Amplitude]) -> DVector<f64> {
    let effect = model.declared().effects.iter().find(|e| label(e) == of);
    let parameters = effect.map_or(&[][..], |e| &e.parameters);
    let size = |p: &model_discrepancy::Parameter| {
        let found = sizes.iter().find(|size| size.name == p.name).and_then(|size| size.value);
        found.map_or(0.0, |value| value / p.report_factor)
    };
    DVector::from_iterator(parameters.len(), parameters.iter().map(size))
}

/// Amplitudes of `of` that, beside `others`, look most like the columns `shown` at `known`.
fn imitating(
    rows: &DMatrix<f64>,
    (shown, known): (&[usize], &DVector<f64>),
    of: &[usize],
    others: &[usize],
) -> DVector<f64> {
    let all = [of, others].concat();
    let mut columns = rows.select_columns(&all);
    let lengths: Vec<f64> =
        columns.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    for (mut column, length) in columns.column_iter_mut().zip(&lengths) {
        column.unscale_mut(*length);
    }
    let trace = rows.select_columns(shown) * known;
    match columns.svd(true, true).solve(&trace, FREE) {
        Ok(found) => DVector::from_fn(of.len(), |i, _| found[i] / lengths[i]),
        Err(_) => DVector::zeros(of.len()),
    }
}

/// Amplitude of one column with which its trace over what can be measured matters; zero where it
/// has none.
fn size_that_matters(linear: &Linear, column: usize) -> f64 {
    let rows: usize = linear.planned.iter().map(DMatrix::nrows).sum();
    let squares: f64 = linear.planned.iter().map(|b| b.column(column).norm_squared()).sum();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let rms = (squares / rows.max(1) as f64).sqrt();
    if rms > 0.0 { MATTERS / rms } else { 0.0 }
}

/// Sizes from which on the amplitudes of an effect matter, in internal units.
pub(super) fn sizes_that_matter(model: &dyn Model, linear: &Linear, effect: &str) -> Vec<f64> {
    let of = columns(model, linear, effect);
    of.into_iter().map(|column| size_that_matters(linear, column)).collect()
}

fn degrees_of_freedom(linear: &Linear, fitted: usize) -> usize {
    linear.measured.nrows().saturating_sub(fitted).max(1)
}

/// Significance asked of a single effect, shared out over the catalogue.
fn level(model: &dyn Model, options: &Options) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let candidates = model.declared().effects.len().max(1) as f64;
    CATALOGUE_SHARE * options.alpha / candidates
}
