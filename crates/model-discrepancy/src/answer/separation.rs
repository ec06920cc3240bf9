//! Which further measurement would tell rivals apart, or make an effect visible.

use crate::algebra::linearised::Linearised;
use crate::levels::AS_GOOD;
use crate::levels::WORTHWHILE;
use std::cell::{OnceCell, RefCell};

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
use crate::{Model, Parameter, Proposal, Role};

/// The measurement, out of those the user could make, that would split the class best.
pub(crate) fn separate_by(
    attribution: &Attribution<'_>,
    estimate: &Estimate,
    further: &Further<'_>,
) -> Option<String> {
    let Source::Effect(active) = &attribution.accepted.source else {
        return covariate_advice(attribution);
    };
    let model = attribution.system.model;
    let confounded: Vec<_> = (attribution.confounded.iter())
        .filter_map(|r| match &r.source {
            Source::Effect(a) => Some(a.effect),
            Source::Empirical(_) => None,
        })
        .collect();
    if confounded.is_empty() {
        return covariate_advice(attribution);
    }
    let amplitude = &estimate.state.amplitudes[active.effect];
    let others: Vec<_> = attribution.system.active.iter().map(|a| a.effect).collect();
    let reach = |extended: &dyn Model| {
        distances(model, extended, further.silent, active.effect, &confounded, &others, amplitude)
            .unwrap_or_else(|| vec![0.0; confounded.len()])
    };
    let present = reach(model);
    let proposals = further.proposals();
    let reached: Vec<Vec<f64>> = proposals.iter().map(|p| reach(p.model.as_ref())).collect();
    // A rival that holds the effect as a part of it stays one whatever is measured.
    let shows = |r: usize| reached.iter().any(|d| d[r] > NEW_DIRECTION * amplitude.norm());
    let split: Vec<usize> = (0..confounded.len()).filter(|&r| shows(r)).collect();
    let least = |d: &Vec<f64>| split.iter().map(|&r| d[r]).fold(f64::INFINITY, f64::min);
    let (present, distances) = (least(&present), reached.iter().map(least).collect::<Vec<_>>());
    let best = distances.iter().copied().fold(0.0, f64::max);
    if split.is_empty() || best <= WORTHWHILE * present || best <= NEW_DIRECTION * amplitude.norm()
    {
        return None;
    }
    let cheapest = distances.iter().position(|&d| d >= AS_GOOD * best)?;
    let text = &proposals[cheapest].text;
    if split.len() == confounded.len() {
        return Some(text.clone());
    }
    let effects = &model.declared().effects;
    let name = |&r: &usize| {
        let effect = &effects[confounded[r]];
        label(&effect.id, effect.subject.as_deref())
    };
    let names: Vec<String> = split.iter().map(name).collect();
    Some(format!("{text}, which tells it from {} alone", names.join(", ")))
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

/// Lengths, in whitened units, of what effect `accepted` at `amplitude` leaves beside each rival in the
/// design of `extended`; none beside one that is not there.
fn distances(
    model: &dyn Model,
    extended: &dyn Model,
    silent: &[bool],
    accepted: usize,
    confounded: &[usize],
    others: &[usize],
    amplitude: &DVector<f64>,
) -> Option<Vec<f64>> {
    let twin = |effect: usize| twin(model, extended, effect);
    let system = others.iter().filter_map(|&o| twin(o)).fold(System::declared(extended), |s, e| {
        let parameters = (0..extended.declared().effects[e].parameters.len()).collect();
        s.with_effect(Active { effect: e, parameters })
    });
    let at = system.start();
    let lin = Linear::of(&system, &at, &all_fitted(extended), silent);
    let effect = |e: usize| lin.tangent(&whole_tangent(extended, &at.state, e));
    let same = twin(accepted)?;
    // A wider design may show amplitudes that this one does not have.
    let place = |p: &Parameter| {
        extended.declared().effects[same].parameters.iter().position(|q| q.name == p.name)
    };
    let wanted = model.declared().effects[accepted].parameters.iter();
    let columns: Vec<usize> = wanted.map(place).collect::<Option<_>>()?;
    let trace = effect(same).select_columns(&columns) * amplitude;
    let left = |&rival: &usize| {
        twin(rival).map_or(0.0, |r| lin.basis.with(&effect(r), NEW_DIRECTION).reject(&trace).norm())
    };
    Some(confounded.iter().map(left).collect())
}

/// Those of a model's proposals whose effects fit their own rows: another cannot be worked out, and
/// [`check_tangents`](crate::check_tangents) tells its author.
fn proposals(model: &dyn Model) -> Vec<Proposal> {
    let mut all = model.proposals();
    all.retain(|proposal| fits_layout(proposal.model.as_ref()).is_ok());
    all
}

pub(crate) fn all_fitted(model: &dyn Model) -> Vec<bool> {
    model.declared().layout.groups.iter().map(|g| g.role == Role::Fit).collect()
}

/// Further measurements that the user could make, worked out only when somebody asks.
pub(crate) struct Further<'a> {
    model: &'a dyn Model,
    silent: &'a [bool],
    proposals: OnceCell<Vec<Proposal>>,
    /// The declared model with each of them.
    designs: RefCell<Vec<Design>>,
}

impl<'a> Further<'a> {
    pub(crate) fn new(model: &'a dyn Model, silent: &'a [bool]) -> Self {
        Self { model, silent, proposals: OnceCell::new(), designs: RefCell::default() }
    }

    fn proposals(&self) -> &[Proposal] {
        self.proposals.get_or_init(|| proposals(self.model))
    }

    /// Whether the design with a proposal shows an effect.
    fn shows(&self, proposal: usize, effect: usize) -> bool {
        let extended = self.proposals()[proposal].model.as_ref();
        let Some(twin) = twin(self.model, extended, effect) else { return false };
        let mut designs = self.designs.borrow_mut();
        for next in designs.len()..=proposal {
            designs.push(Design::of(self.proposals()[next].model.as_ref(), self.silent));
        }
        designs[proposal].sees(extended, twin)
    }

    /// The cheapest measurement with which the design would see `effect`.
    pub(crate) fn make_visible(&self, effect: usize) -> Option<String> {
        let mut all = 0..self.proposals().len();
        if let Some(cheapest) = all.find(|&proposal| self.shows(proposal, effect)) {
            return Some(self.proposals()[cheapest].text.clone());
        }
        let names: Vec<_> = (0..self.silent.len())
            .filter(|&c| self.silent[c])
            .map(|c| ["x", "y", "z"].get(c).copied().unwrap_or("the other components"))
            .collect();
        (!names.is_empty() && Design::of(self.model, &[]).sees(self.model, effect)).then(|| {
            format!("measure {} as well: both sides hold the same numbers", names.join(" and "))
        })
    }
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
