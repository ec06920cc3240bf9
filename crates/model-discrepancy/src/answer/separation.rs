//! Which further measurement would tell rivals apart, or make an effect visible.

use crate::algebra::linearised::Linearised;
use crate::levels::AS_GOOD;
use crate::levels::WORTHWHILE;
use std::cell::OnceCell;
use std::collections::HashMap;

use nalgebra::{DVector, Dyn, SVD};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::system::{Active, Estimate, System, whitened};
use crate::answer::confounded::Attribution;
use crate::choice::candidate::{Source, estimable_columns, label, min_kept};
use crate::model::covariate::ORDER;
use crate::model::validate::fits_layout;
use crate::model::whole_tangent;
use crate::noise::linear::Linear;
use crate::{Model, Parameter, Role};

/// Which further measurements to make.
pub(crate) struct Advice {
    /// Of every step, what would tell it from its rivals.
    pub(crate) separate_by: Vec<Option<String>>,
    /// Of every hidden effect asked about, what would make it visible.
    make_visible: HashMap<usize, String>,
}

impl Advice {
    /// Of what a declared model hides alone.
    pub(crate) fn on_hidden(model: &dyn Model, silent: &[bool], hidden: &[usize]) -> Self {
        Self::new(model, silent, (&[], &[]), hidden)
    }

    /// On steps, with the amplitudes of all effects, and on effects that the design hides.
    ///
    /// A proposal is as large as the data: each is built once, held against everything that is
    /// asked, and dropped.
    pub(crate) fn new(
        model: &dyn Model,
        silent: &[bool],
        (steps, amplitudes): (&[Option<Attribution<'_>>], &[DVector<f64>]),
        hidden: &[usize],
    ) -> Self {
        let mut classes: Vec<_> =
            steps.iter().map(|step| Class::of(step.as_ref()?, silent, amplitudes)).collect();
        let is_split = classes.iter().any(Option::is_some);
        let mut make_visible = HashMap::new();
        let mut still_hidden: Vec<usize> = hidden.to_vec();
        for proposal in model.proposals() {
            if !is_split && still_hidden.is_empty() {
                break;
            }
            let Some(extended) = proposal.model() else { continue };
            // Another cannot be worked out; `check_tangents` tells its author.
            if fits_layout(extended.as_ref()).is_err() {
                continue;
            }
            for class in classes.iter_mut().flatten() {
                class.hold_against(&proposal.text, extended.as_ref());
            }
            if !still_hidden.is_empty() {
                let design = Design::of(extended.as_ref(), silent);
                still_hidden.retain(|&effect| {
                    let twin = twin(model, extended.as_ref(), effect);
                    let is_hidden = !twin.is_some_and(|t| design.sees(extended.as_ref(), t));
                    if !is_hidden {
                        make_visible.insert(effect, proposal.text.clone());
                    }
                    is_hidden
                });
            }
        }
        if let Some(text) = all_components(silent).filter(|_| !still_hidden.is_empty()) {
            let design = Design::of(model, &[]);
            still_hidden.retain(|&effect| design.sees(model, effect));
            make_visible.extend(still_hidden.into_iter().map(|effect| (effect, text.clone())));
        }
        let of_step = |(step, class): (&Option<Attribution<'_>>, Option<Class<'_>>)| {
            let step = step.as_ref().filter(|step| !step.confounded.is_empty())?;
            class.map_or_else(|| covariate_advice(step), Class::advice)
        };
        Self { separate_by: steps.iter().zip(classes).map(of_step).collect(), make_visible }
    }

    /// The cheapest measurement with which the design would see `effect`.
    pub(crate) fn make_visible(&self, effect: usize) -> Option<String> {
        self.make_visible.get(&effect).cloned()
    }
}

/// What to do about components that hold the same numbers on both sides, where there are any.
fn all_components(silent: &[bool]) -> Option<String> {
    let names: Vec<_> = (0..silent.len())
        .filter(|&c| silent[c])
        .map(|c| ["x", "y", "z"].get(c).copied().unwrap_or("the other components"))
        .collect();
    let names = names.join(" and ");
    (!names.is_empty())
        .then(|| format!("measure {names} as well: both sides hold the same numbers"))
}

/// An effect that was added, those it is confounded with, and how far proposals part them.
struct Class<'a> {
    attribution: &'a Attribution<'a>,
    silent: &'a [bool],
    accepted: usize,
    confounded: Vec<usize>,
    amplitude: &'a DVector<f64>,
    /// Text of every proposal, and the lengths of [`distances`].
    reached: Vec<(String, Vec<f64>)>,
}

impl<'a> Class<'a> {
    /// `None` where no effect of the catalogue is confounded with it.
    fn of(
        attribution: &'a Attribution<'a>,
        silent: &'a [bool],
        amplitudes: &'a [DVector<f64>],
    ) -> Option<Self> {
        let Source::Effect(active) = &attribution.accepted.source else { return None };
        let confounded: Vec<_> = (attribution.confounded.iter())
            .filter_map(|r| match &r.source {
                Source::Effect(a) => Some(a.effect),
                Source::Empirical(_) => None,
            })
            .collect();
        let (accepted, amplitude) = (active.effect, &amplitudes[active.effect]);
        let reached = Vec::new();
        (!confounded.is_empty()).then_some(Self {
            attribution,
            silent,
            accepted,
            confounded,
            amplitude,
            reached,
        })
    }

    fn reach(&self, extended: &dyn Model) -> Vec<f64> {
        self.distances(extended).unwrap_or_else(|| vec![0.0; self.confounded.len()])
    }

    fn hold_against(&mut self, text: &str, extended: &dyn Model) {
        let reach = self.reach(extended);
        self.reached.push((text.to_owned(), reach));
    }

    /// The measurement, out of those the user could make, that would split the class best.
    fn advice(self) -> Option<String> {
        let model = self.attribution.system.model;
        let size = self.amplitude.norm();
        // A rival that holds the effect as a part of it stays one whatever is measured.
        let shows = |r: usize| self.reached.iter().any(|(_, d)| d[r] > NEW_DIRECTION * size);
        let split: Vec<usize> = (0..self.confounded.len()).filter(|&r| shows(r)).collect();
        let least = |d: &[f64]| split.iter().map(|&r| d[r]).fold(f64::INFINITY, f64::min);
        let present = least(&self.reach(model));
        let best = self.reached.iter().map(|(_, d)| least(d)).fold(0.0, f64::max);
        if split.is_empty() || best <= WORTHWHILE * present || best <= NEW_DIRECTION * size {
            return None;
        }
        let (text, _) = self.reached.iter().find(|(_, d)| least(d) >= AS_GOOD * best)?;
        if split.len() == self.confounded.len() {
            return Some(text.clone());
        }
        let effects = &model.declared().effects;
        let name = |&r: &usize| {
            let effect = &effects[self.confounded[r]];
            label(&effect.id, effect.subject.as_deref())
        };
        let names: Vec<String> = split.iter().map(name).collect();
        Some(format!("{text}, which tells it from {} alone", names.join(", ")))
    }

    /// Lengths, in whitened units, of what the effect leaves beside each rival in the design of
    /// `extended`; none beside one that is not there.
    fn distances(&self, extended: &dyn Model) -> Option<Vec<f64>> {
        let model = self.attribution.system.model;
        let twin = |effect: usize| twin(model, extended, effect);
        let others = self.attribution.system.active.iter().filter_map(|a| twin(a.effect));
        let system = others.fold(System::declared(extended), |s, e| {
            let parameters = (0..extended.declared().effects[e].parameters.len()).collect();
            s.with_effect(Active { effect: e, parameters })
        });
        let at = system.start();
        let lin = Linear::of(&system, &at, &all_fitted(extended), self.silent);
        let effect = |e: usize| lin.tangent(&whole_tangent(extended, &at.state, e));
        let same = twin(self.accepted)?;
        // A wider design may show amplitudes that this one does not have.
        let place = |p: &Parameter| {
            extended.declared().effects[same].parameters.iter().position(|q| q.name == p.name)
        };
        let wanted = model.declared().effects[self.accepted].parameters.iter();
        let columns: Vec<usize> = wanted.map(place).collect::<Option<_>>()?;
        let trace = effect(same).select_columns(&columns) * self.amplitude;
        let left = |&rival: &usize| {
            twin(rival)
                .map_or(0.0, |r| lin.basis.with(&effect(r), NEW_DIRECTION).reject(&trace).norm())
        };
        Some(self.confounded.iter().map(left).collect())
    }
}

fn covariate_advice(attribution: &Attribution<'_>) -> Option<String> {
    attribution.confounded.iter().find_map(|r| match &r.source {
        Source::Empirical(e) if e.covariate == ORDER => Some(
            "repeat the readings in another order, so that time and the other conditions do not run together"
                .to_owned(),
        ),
        Source::Empirical(e) => Some(format!(
            "vary {} independently of the other conditions, or hold it constant",
            e.covariate
        )),
        Source::Effect(_) => None,
    })
}

pub(crate) fn all_fitted(model: &dyn Model) -> Vec<bool> {
    model.declared().layout.groups.iter().map(|g| g.role == Role::Fit).collect()
}

/// The same effect in an extended model.
fn twin(model: &dyn Model, extended: &dyn Model, effect: usize) -> Option<usize> {
    let wanted = &model.declared().effects[effect];
    extended
        .declared()
        .effects
        .iter()
        .position(|e| e.id == wanted.id && e.subject == wanted.subject)
}

/// What a declared model leaves of effects.
struct Design {
    at: Estimate,
    rows: Vec<usize>,
    sigma: Vec<f64>,
    basis: Basis,
}

impl Design {
    fn of(model: &dyn Model, silent: &[bool]) -> Self {
        let system = System::declared(model);
        let at = system.start();
        let Linearised { rows, sigma, basis, .. } =
            Linearised::of(&system, &at, &all_fitted(model), silent);
        Self { at, rows, sigma, basis }
    }

    fn sees(&self, model: &dyn Model, effect: usize) -> bool {
        let mut tangent = whole_tangent(model, &self.at.state, effect).select_rows(&self.rows);
        for (mut row, sigma) in tangent.row_iter_mut().zip(&self.sigma) {
            row.unscale_mut(*sigma);
        }
        let beside = self.basis.reject_columns(&tangent);
        !estimable_columns(&tangent, &beside, min_kept(&model.declared().effects[effect]))
            .is_empty()
    }
}

/// What the parameters of a system do, worked out only when somebody asks.
pub(crate) struct Imitation<'a> {
    system: &'a System<'a>,
    at: &'a Estimate,
    lin: &'a Linear<'a>,
    /// Of the whitened Jacobian with columns of unit length, along the directions of `lin`.
    svd: OnceCell<SVD<f64, Dyn, Dyn>>,
}

impl<'a> Imitation<'a> {
    pub(crate) fn new(system: &'a System<'a>, at: &'a Estimate, lin: &'a Linear<'a>) -> Self {
        Self { system, at, lin, svd: OnceCell::new() }
    }

    /// Parameters of the system that together imitate an effect the design cannot see.
    ///
    /// Named are those that contribute at least a third of the largest.
    pub(crate) fn aliased_with(&self, effect: usize) -> Vec<String> {
        const NAMED: f64 = 1.0 / 3.0;
        let Self { system, at, lin, .. } = self;
        let tangent = lin.tangent(&whole_tangent(system.model, &at.state, effect));
        if system.dim() == 0 || tangent.norm() == 0.0 {
            return Vec::new();
        }
        let svd = self.svd.get_or_init(|| self.decomposed());
        let Ok(shares) = svd.solve(&lin.basis.along(&tangent), NEW_DIRECTION) else {
            return Vec::new();
        };
        let lengths: Vec<f64> = shares.row_iter().map(|row| row.norm()).collect();
        let largest = lengths.iter().copied().fold(0.0, f64::max);
        let names = system.parameter_names().into_iter().zip(lengths);
        names.filter(|(_, length)| *length >= NAMED * largest).map(|(name, _)| name).collect()
    }

    fn decomposed(&self) -> SVD<f64, Dyn, Dyn> {
        let Self { system, at, lin, .. } = self;
        let mut scaled = whitened(lin.layout, at, &lin.rows, &system.jacobian(at));
        for mut column in scaled.column_iter_mut() {
            let length = column.norm().max(f64::MIN_POSITIVE);
            column.unscale_mut(length);
        }
        lin.basis.along(&scaled).svd(true, true)
    }
}
