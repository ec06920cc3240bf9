//! Which other names the data would accept for an effect that was found.

use nalgebra::{DMatrix, DVector};

use crate::Origin;
use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::f_tail::f_tail;
use crate::algebra::linearised::Linearised;
use crate::algebra::system::{System, rows_of};
use crate::choice::candidate::{
    Candidate, Source, catalogue, estimability, estimability_of_least, inside, same_span,
};
use crate::choice::context::Context;
use crate::choice::one_observation::{full_candidate, promising};
use crate::choice::score::excluded;
use crate::choice::score_shapes::{empirical_candidate, shape_again};
use crate::choice::selected::Selected;
use crate::choice::selected::What;
use crate::choice::selected::within_limits;
use crate::choice::sets::some_of;
use crate::choice::shape::BY_LEVEL;
use crate::count::count;
use crate::levels::CHOICE_FOLDS;
use crate::levels::DECIDED;
use crate::levels::MIN_KEPT_CONFOUNDED;
use crate::levels::STAY;
use crate::noise::linear::Linear;
use crate::tests::hold_out::{compare, folds, leave_out};
use crate::tests::significance::significance;

/// An accepted effect among its rivals, on the system without it.
pub(crate) struct Attribution<'a> {
    pub(crate) system: System<'a>,
    /// The accepted effect itself.
    pub(crate) accepted: Candidate,
    /// Candidates that explain the data as well.
    pub(crate) confounded: Vec<Candidate>,
}

impl Attribution<'_> {
    /// Ids of the rivals, each once; with the subject beside an accepted effect of the same id.
    pub(crate) fn names(&self) -> Vec<String> {
        let is_same = |rival: &Candidate| rival.id == self.accepted.id;
        let name = |r: &Candidate| if is_same(r) { r.label() } else { r.id.clone() };
        each_once(self.confounded.iter().map(name))
    }

    /// Rivals with their subjects, each once.
    pub(crate) fn labels(&self) -> Vec<String> {
        each_once(self.confounded.iter().map(Candidate::label))
    }
}

fn each_once(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut once = Vec::new();
    for name in names {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once
}

/// Looks for rivals of `what` in the final selection.
pub(crate) fn attribute<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
    what: &What,
) -> Option<Attribution<'a>> {
    let mut system = chosen.system.clone();
    match what {
        What::Effect(effect) => system = system.without_effect(*effect),
        What::Empirical(covariate, shape) => {
            system.empirical.retain(|e| e.covariate != *covariate || e.shape != *shape);
        }
    }
    let rows = rows_of(&context.model.declared().layout, keep);
    let estimate = system.fit(&rows, &system.warm_start(&chosen.estimate)).ok()?;
    let lin = Linear::of(&system, &estimate, keep, context.silent);
    let accepted = match what {
        What::Effect(effect) => {
            estimability(context.model, *effect, &estimate, &lin, &lin.basis).candidate()?
        }
        What::Empirical(covariate, shape) => {
            shape_again(context, &lin, &lin.basis, covariate, shape)?.0
        }
    };
    let skip = excluded(context, &system, &estimate, &lin);
    let mut others = Vec::new();
    let sights = catalogue(&system, &estimate, &lin).into_iter();
    let local = promising(&system, &estimate, &lin, DECIDED).into_iter();
    let sights = sights.chain(local.map(|e| (e, full_candidate(&system, &estimate, &lin, e))));
    let sights = sights.filter(|(effect, _)| *what != What::Effect(*effect));
    let hardly = |e| {
        estimability_of_least(context.model, e, &estimate, (&lin, &lin.basis), MIN_KEPT_CONFOUNDED)
    };
    // With the amplitudes that the design hardly shows, too: these may be what the accepted effect does.
    others.extend(sights.flat_map(|(effect, sight)| {
        let all = context.model.declared().effects[effect].parameters.len();
        let seen = sight.candidate();
        let n_seen = seen.as_ref().map_or(0, |c| c.tangent.ncols());
        let whole = (n_seen < all).then(|| hardly(effect).candidate()).flatten();
        [seen, whole.filter(|c| c.tangent.ncols() > n_seen)].into_iter().flatten()
    }));
    others.extend(recorded_shapes(context, &lin, &accepted));
    others.extend(same_levels(context, &lin, &accepted));
    let place = Place::of(&lin, &accepted, &skip);
    others.retain(|rival| {
        place.is_for(rival)
            || place.may_be_for(rival)
                && takes_the_place_of(context, keep, &system, chosen, rival, what)
    });
    others.dedup_by(|a, b| a.is_effect_of(b));
    Some(Attribution { system, accepted, confounded: others })
}

/// Recorded columns and the measured order, other than what the accepted effect follows itself.
///
/// Where the effect is a drift already, time and order are another word for it, not rivals.
fn recorded_shapes(
    context: &Context<'_>,
    lin: &Linear<'_>,
    accepted: &Candidate,
) -> Vec<Candidate> {
    let driver = match &accepted.source {
        Source::Effect(active) => context.model.declared().effects[active.effect].driver.clone(),
        Source::Empirical(e) => Some(e.covariate.clone()),
    };
    let accepted_span = span(&lin.basis, accepted);
    let another_word = |c: &Candidate| same_span(&span(&lin.basis, c), &accepted_span);
    let mut found = Vec::new();
    for (covariate, shapes) in context.along() {
        let order = covariate.is_course();
        if driver.as_deref() == Some(covariate.name.as_str())
            || (covariate.origin == Origin::Coordinate && !order)
        {
            continue;
        }
        // Along the order only a plain drift: a curve imitates too much.
        let shapes = shapes.single.iter().take(if order { 1 } else { usize::MAX });
        // A value of its own at each level holds whatever follows that column.
        let shapes = shapes.filter(|s| s.name != BY_LEVEL);
        let candidates = shapes.filter_map(|s| empirical_candidate(lin, &lin.basis, covariate, s));
        found.extend(candidates.map(|(c, _)| c).filter(|c| !order || !another_word(c)));
    }
    found
}

/// Other columns whose levels part the data as those of an accepted shape of levels do.
fn same_levels(context: &Context<'_>, lin: &Linear<'_>, accepted: &Candidate) -> Vec<Candidate> {
    let Source::Empirical(own) = &accepted.source else { return Vec::new() };
    if own.shape != BY_LEVEL {
        return Vec::new();
    }
    let own_span = span(&lin.basis, accepted);
    let others = context.along().filter(|(c, _)| c.name != own.covariate);
    let levels = others.filter_map(|(covariate, shapes)| {
        let shape = shapes.single.iter().find(|s| s.name == BY_LEVEL)?;
        Some(empirical_candidate(lin, &lin.basis, covariate, shape)?.0)
    });
    levels.filter(|c| same_span(&span(&lin.basis, c), &own_span)).collect()
}

/// Whether the data would accept `rival` for `accepted`, both beside `lin`.
pub(crate) fn is_rival(
    lin: &Linear<'_>,
    accepted: &Candidate,
    rival: &Candidate,
    skip: &[bool],
) -> bool {
    Place::of(lin, accepted, skip).is_for(rival)
}

/// The place of an accepted effect in a system without it.
struct Place<'a> {
    lin: &'a Linear<'a>,
    accepted: &'a Candidate,
    /// See [`Scoring`](crate::choice::score::Scoring).
    skip: &'a [bool],
    /// What the system leaves of the data.
    clean: DVector<f64>,
    /// Directions of the accepted effect beside the system, and what they explain.
    own: DMatrix<f64>,
    explained: f64,
}

impl<'a> Place<'a> {
    fn of(lin: &'a Linear<'a>, accepted: &'a Candidate, skip: &'a [bool]) -> Self {
        let (clean, own) = (lin.clean_residual(), span(&lin.basis, accepted));
        let explained = own.tr_mul(&clean).norm_squared();
        Self { lin, accepted, skip, clean, own, explained }
    }

    /// Whether a rival may be there, as the tangents have it.
    fn is_for(&self, rival: &Candidate) -> bool {
        let Self { lin, accepted, .. } = self;
        let other = span(&lin.basis, rival);
        let (is_same, is_inside) = (same_span(&self.own, &other), inside(&self.own, &other));
        // The cheap question first.
        if !is_same && !is_inside && self.leaves_twice(&other) {
            return false;
        }
        let alone = significance(lin, &lin.basis, &rival.tangent, rival.reach, DECIDED);
        if alone.is_none_or(|t| t.p_value > DECIDED) {
            return false;
        }
        if is_same {
            return true;
        }
        // A wider effect that contains the accepted one adds nothing to it, unless some amplitudes of it
        // are the accepted one under another name.
        if is_inside {
            return holds_as_amplitudes(lin, &self.own, rival);
        }
        let beside = lin.basis.with(&rival.tangent, NEW_DIRECTION);
        let needed = significance(lin, &beside, &accepted.tangent, accepted.reach, STAY);
        // A law that was chosen among many for how well it fits says more by that alone.
        match needed.map(|test| test.p_value * accepted.searched) {
            None => true,
            Some(p_value) if p_value > STAY => true,
            Some(p_value) if p_value <= DECIDED => false,
            Some(_) => {
                let folds = folds(lin.clusters.len(), CHOICE_FOLDS);
                let with_own = lin.basis.with(&accepted.tangent, NEW_DIRECTION);
                let own = leave_out(lin, &with_own, &folds, self.skip);
                let other = leave_out(lin, &beside, &folds, self.skip);
                let c = compare(&own, &other, self.skip);
                c.difference <= c.std
            }
        }
    }

    /// Whether a rival leaves clearly more than the accepted effect does.
    fn leaves_twice(&self, other: &DMatrix<f64>) -> bool {
        let (rows, base) = (self.lin.residual.len(), self.lin.basis.dim());
        let left = |directions: &DMatrix<f64>, explained: f64| {
            let dof = count(rows.saturating_sub(base + directions.ncols()).max(1));
            ((self.clean.norm_squared() - explained).max(0.0), dof)
        };
        let (own, own_dof) = left(&self.own, self.explained);
        let (other, other_dof) = left(other, other.tr_mul(&self.clean).norm_squared());
        let ratio = (other / other_dof) / (own / own_dof);
        ratio >= TWICE && f_tail(ratio, other_dof, own_dof) <= DECIDED
    }

    /// Whether a rival explains most of what the accepted effect does, as the tangents have it.
    ///
    /// Where a parameter is hardly held, as the place of a shallow part beside its tilt, the fit moves far
    /// between one name and the other, and what is left is no longer what the tangents say.
    fn may_be_for(&self, rival: &Candidate) -> bool {
        if rival.home.is_some() || !matches!(rival.source, Source::Effect(_)) {
            return false;
        }
        let other = span(&self.lin.basis, rival);
        other.tr_mul(&self.clean).norm_squared() >= MOST * self.explained
            && !inside(&self.own, &other)
    }
}

/// Share of what the accepted effect explains from which on a rival is fitted in its place.
const MOST: f64 = 0.5;

/// Whether the accepted effect adds nothing to the fit with the rival in its place.
fn takes_the_place_of(
    context: &Context<'_>,
    keep: &[bool],
    without: &System<'_>,
    chosen: &Selected<'_>,
    rival: &Candidate,
    accepted: &What,
) -> bool {
    let What::Effect(effect) = accepted else { return false };
    let system = rival.added_to(without);
    let rows = rows_of(&context.model.declared().layout, keep);
    let Ok(refitted) = system.fit(&rows, &system.warm_start(&chosen.estimate)) else {
        return false;
    };
    if !within_limits(&system, &refitted) {
        return false;
    }
    // A course with a time constant of its own is any other course.
    let lin = Linear::from(Linearised::of_found(&system, &refitted, keep, context.silent));
    let sight = estimability(context.model, *effect, &refitted, &lin, &lin.basis).candidate();
    let needed = sight.and_then(|c| significance(&lin, &lin.basis, &c.tangent, c.reach, STAY));
    let own = Linearised::of_found(&chosen.system, &chosen.estimate, keep, context.silent);
    let leaves = |lin: &Linearised<'_>| lin.residual.norm_squared();
    leaves(&lin) < TWICE * leaves(&own) && needed.is_none_or(|test| test.p_value > STAY)
}

/// Whether as many amplitudes of a rival as the accepted effect has directions span what it does: to
/// touches of a paraboloid a coma is the two squarenesses with z.
fn holds_as_amplitudes(lin: &Linear<'_>, own: &DMatrix<f64>, rival: &Candidate) -> bool {
    let columns = rival.tangent.ncols();
    let spans = |some: &[usize]| {
        let alone = lin.basis.reject_columns(&rival.tangent.select_columns(some));
        same_span(&Basis::of(&alone, NEW_DIRECTION.sqrt()).matrix(), own)
    };
    columns <= MOST_AMPLITUDES && some_of(columns, own.ncols()).iter().any(|some| spans(some))
}

/// Most amplitudes of an effect of which all choices are tried.
const MOST_AMPLITUDES: usize = 6;

/// Factor of the sum of squares that no rival leaves: twice the error. Noise with memory moves it by
/// less, whatever its law, and the few groups in which two jumps a reading apart differ need not agree.
const TWICE: f64 = 4.0;

/// Directions of a candidate beside a system.
fn span(base: &Basis, candidate: &Candidate) -> DMatrix<f64> {
    match candidate.source {
        Source::Effect(_) => Basis::of(&candidate.beside, NEW_DIRECTION.sqrt()),
        // A shape was tested beside its constants, too.
        Source::Empirical(_) => {
            Basis::of(&base.reject_columns(&candidate.tangent), NEW_DIRECTION.sqrt())
        }
    }
    .matrix()
}
