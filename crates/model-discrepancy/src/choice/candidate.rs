//! Candidates for what is missing, and what of them the design can see.

use crate::levels::MIN_KEPT;
use crate::levels::MIN_KEPT_DRIVEN;
use nalgebra::DMatrix;

use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::basis::{Basis, smallest_cosine};
use crate::algebra::system::{Active, Empirical, Estimate, System};
use crate::count::count;
use crate::model::whole_tangent;
use crate::noise::linear::Linear;
use crate::tests::significance::Reach;
use crate::{Effect, Model, Scope};

/// Cosine above which two tangents are one: they differ by less than 1.5 % of their length.
const SAME: f64 = 0.9999;

/// Something that may be missing.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// An effect of the catalogue.
    Effect(Active),
    /// An empirical correction.
    Empirical(Empirical),
}

/// A candidate with its tangent at the present estimate.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// Catalogue id or `covariate:<column>`.
    pub(crate) id: String,
    pub(crate) subject: Option<String>,
    pub(crate) source: Source,
    /// Whitened, on the rows that take part in inference.
    pub(crate) tangent: DMatrix<f64>,
    /// What the model that it is tested beside leaves of the tangent.
    pub(crate) beside: DMatrix<f64>,
    pub(crate) reach: Reach,
    /// How many like it were looked at to find it.
    pub(crate) searched: f64,
    /// Cluster in which a candidate with [`Reach::One`] lives.
    pub(crate) home: Option<usize>,
}

impl Candidate {
    pub(crate) fn label(&self) -> String {
        label(&self.id, self.subject.as_deref())
    }

    /// Whether another is of the same effect of the catalogue.
    pub(crate) fn is_effect_of(&self, other: &Self) -> bool {
        match (&self.source, &other.source) {
            (Source::Effect(one), Source::Effect(other)) => one.effect == other.effect,
            _ => false,
        }
    }

    /// Share of the tangent that `base` absorbs, 0 to 1.
    pub(crate) fn absorbed(&self, base: &Basis) -> f64 {
        absorbed(&self.tangent, &self.beside, base)
    }

    /// The system with this candidate switched on.
    pub(crate) fn added_to<'m>(&self, system: &System<'m>) -> System<'m> {
        match &self.source {
            Source::Effect(active) => system.with_effect(active.clone()),
            Source::Empirical(empirical) => system.with_empirical(empirical.clone()),
        }
    }
}

/// Id, with the subject in brackets where there is one.
pub(crate) fn label(id: &str, subject: Option<&str>) -> String {
    subject.map_or_else(|| id.to_owned(), |s| format!("{id} [{s}]"))
}

/// What of an effect the design sees.
pub(crate) enum Estimability {
    /// The candidate, limited to the amplitudes that are seen.
    Estimable(Box<Candidate>),
    /// Nothing: share absorbed.
    NotEstimable(f64),
}

impl Estimability {
    pub(crate) fn candidate(self) -> Option<Candidate> {
        match self {
            Self::Estimable(candidate) => Some(*candidate),
            Self::NotEstimable(_) => None,
        }
    }
}

/// Every effect of the catalogue that is not yet in `system` and moves many observations.
pub(crate) fn catalogue(
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
) -> Vec<(usize, Estimability)> {
    let effects = &system.model.declared().effects;
    let local = |e: usize| matches!(effects[e].scope, Scope::Observation(_));
    let missing = (0..effects.len()).filter(|&e| !system.has_effect(e) && !local(e)).collect();
    estimabilities(system, at, lin, missing)
}

/// What the design sees of these effects, which are not in `system`.
pub(crate) fn estimabilities(
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
    missing: Vec<usize>,
) -> Vec<(usize, Estimability)> {
    let effects = &system.model.declared().effects;
    let tangent = |&e: &usize| lin.tangent(&whole_tangent(system.model, &at.state, e));
    let tangents: Vec<DMatrix<f64>> = missing.iter().map(tangent).collect();
    // All at once: a product of matrices.
    let columns: Vec<_> = tangents.iter().flat_map(DMatrix::column_iter).collect();
    if columns.is_empty() {
        return Vec::new();
    }
    let beside = lin.basis.reject_columns(&DMatrix::from_columns(&columns));
    let mut first = 0;
    let sight = |(e, tangent): (usize, DMatrix<f64>)| {
        let beside = beside.columns(first, tangent.ncols()).into_owned();
        first += tangent.ncols();
        let effect = &effects[e];
        (e, estimability_beside(lin, &lin.basis, (effect, e), (tangent, beside), min_kept(effect)))
    };
    missing.into_iter().zip(tangents).map(sight).collect()
}

/// What the design sees of effect `e` beside the span of `base`.
pub(crate) fn estimability(
    model: &dyn Model,
    e: usize,
    at: &Estimate,
    lin: &Linear<'_>,
    base: &Basis,
) -> Estimability {
    estimability_of_least(model, e, at, (lin, base), min_kept(&model.declared().effects[e]))
}

/// [`sight`] where at least this share of each tangent must be left.
pub(crate) fn estimability_of_least(
    model: &dyn Model,
    e: usize,
    at: &Estimate,
    (lin, base): (&Linear<'_>, &Basis),
    least: f64,
) -> Estimability {
    let tangent = lin.tangent(&whole_tangent(model, &at.state, e));
    let beside = base.reject_columns(&tangent);
    estimability_beside(lin, base, (&model.declared().effects[e], e), (tangent, beside), least)
}

/// What is seen of an effect, given by its number too, of whose tangent the span of `base` leaves
/// `beside`.
fn estimability_beside(
    lin: &Linear<'_>,
    base: &Basis,
    (effect, e): (&Effect, usize),
    (tangent, beside): (DMatrix<f64>, DMatrix<f64>),
    least: f64,
) -> Estimability {
    let parameters = estimable_columns(&tangent, &beside, least);
    if parameters.is_empty() {
        return Estimability::NotEstimable(absorbed(&tangent, &beside, base));
    }
    let (tangent, beside) =
        (tangent.select_columns(&parameters), beside.select_columns(&parameters));
    let home = effect.subject.as_ref().and_then(|_| only_cluster(lin, &tangent));
    Estimability::Estimable(Box::new(Candidate {
        id: effect.id.clone(),
        subject: effect.subject.clone(),
        source: Source::Effect(Active { effect: e, parameters }),
        reach: if home.is_some() { Reach::One } else { Reach::Many },
        searched: count(effect.searched.max(1)),
        home,
        tangent,
        beside,
    }))
}

pub(crate) fn min_kept(effect: &Effect) -> f64 {
    if effect.driver.is_some() { MIN_KEPT_DRIVEN } else { MIN_KEPT }
}

/// Columns of which at least `min_kept` of their norm is left in `beside`, what a model leaves of
/// them, and beside those before them.
pub(crate) fn estimable_columns(
    tangent: &DMatrix<f64>,
    beside: &DMatrix<f64>,
    min_kept: f64,
) -> Vec<usize> {
    let mut basis = Basis::empty(tangent.nrows());
    let columns = tangent.column_iter().zip(beside.column_iter()).enumerate();
    columns
        .filter(|(_, (whole, rest))| basis.push(&rest.clone_owned(), whole.norm(), min_kept))
        .map(|(i, _)| i)
        .collect()
}

/// `1 − |G⊥|²/|G|²`, each direction of the tangent counting the same.
fn absorbed(tangent: &DMatrix<f64>, beside: &DMatrix<f64>, base: &Basis) -> f64 {
    let left = if tangent.ncols() == 1 {
        beside.norm_squared() / tangent.norm_squared()
    } else {
        let directions = Basis::of(tangent, NEW_DIRECTION).matrix();
        base.reject_columns(&directions).norm_squared() / directions.norm_squared()
    };
    // No direction, nothing seen: 0/0.
    if left.is_nan() { 1.0 } else { (1.0 - left).clamp(0.0, 1.0) }
}

fn only_cluster(lin: &Linear<'_>, tangent: &DMatrix<f64>) -> Option<usize> {
    let touched = |c: &Vec<usize>| c.iter().any(|&i| tangent.row(i).iter().any(|&v| v != 0.0));
    let mut homes = (0..lin.clusters.len()).filter(|&c| touched(&lin.clusters[c]));
    homes.next().filter(|_| homes.next().is_none())
}

/// Class of each candidate: those whose tangents beside the model are the same direction share one.
pub(crate) fn classes(candidates: &[Candidate]) -> Vec<usize> {
    let spans: Vec<_> =
        candidates.iter().map(|c| Basis::of(&c.beside, NEW_DIRECTION).matrix()).collect();
    let mut classes: Vec<usize> = Vec::with_capacity(candidates.len());
    for (i, candidate) in candidates.iter().enumerate() {
        let twin = (0..i).find(|&j| {
            candidates[j].reach == Reach::Many
                && candidate.reach == Reach::Many
                && same_span(&spans[i], &spans[j])
        });
        classes.push(twin.map_or(i, |j| classes[j]));
    }
    classes
}

/// Whether two orthonormal bases span the same space.
pub(crate) fn same_span(a: &DMatrix<f64>, b: &DMatrix<f64>) -> bool {
    a.ncols() == b.ncols() && same_directions(&a.tr_mul(b))
}

/// The same from the cosines between two orthonormal bases of so many columns each.
pub(crate) fn same_directions(cosines: &DMatrix<f64>) -> bool {
    // Their sum of squares tells most apart without a decomposition.
    cosines.norm_squared() > count(cosines.ncols()) * SAME * SAME
        && cosines.singular_values().min() > SAME
}

/// Whether the space of `a` lies inside that of `b`.
pub(crate) fn inside(a: &DMatrix<f64>, b: &DMatrix<f64>) -> bool {
    a.ncols() < b.ncols() && smallest_cosine(a, b) > SAME
}
