//! Which other names the data would accept for an effect that was found.

use crate::Origin;
use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::f_tail::f_tail;
use crate::algebra::linearised::Linearised;
use crate::algebra::system::{System, rows_of};
use crate::choice::candidate::{
    Candidate, Source, catalogue, estimability, estimability_of_least, inside, label, same_span,
};
use crate::choice::context::Context;
use crate::choice::one_observation::{full_candidate, promising};
use crate::choice::score::excluded;
use crate::choice::score_shapes::{empirical_candidate, shape_again};
use crate::choice::selected::Selected;
use crate::choice::selected::What;
use crate::choice::selected::within_limits;
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
    /// Names of the rivals, each once.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for rival in &self.confounded {
            let name = if rival.id == self.accepted.id {
                label(&rival.id, rival.subject.as_deref())
            } else {
                rival.id.clone()
            };
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
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
    others
        .extend(sights.filter_map(|(effect, sight)| {
            sight.candidate().or_else(|| hardly(effect).candidate())
        }));
    others.extend(recorded_shapes(context, &lin, &accepted));
    others.extend(same_levels(context, &lin, &accepted));
    others.retain(|rival| {
        is_rival(&lin, &accepted, rival, &skip)
            || explains_most(&lin, &accepted, rival)
                && takes_the_place_of(context, keep, &system, chosen, rival, what)
    });
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

pub(crate) fn is_rival(
    lin: &Linear<'_>,
    accepted: &Candidate,
    rival: &Candidate,
    skip: &[bool],
) -> bool {
    let (own, other) = (span(&lin.basis, accepted), span(&lin.basis, rival));
    let (is_same, is_inside) = (same_span(&own, &other), inside(&own, &other));
    let beside = lin.basis.with(&rival.tangent, NEW_DIRECTION);
    // The cheap question first.
    if !is_same
        && !is_inside
        && leaves_twice(lin, &lin.basis.with(&accepted.tangent, NEW_DIRECTION), &beside)
    {
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
        return holds_as_amplitudes(lin, &own, rival);
    }
    let needed = significance(lin, &beside, &accepted.tangent, accepted.reach, STAY);
    match needed {
        None => true,
        Some(t) if t.p_value > STAY => true,
        Some(t) if t.p_value <= DECIDED => false,
        Some(_) => {
            let folds = folds(lin.clusters.len(), CHOICE_FOLDS);
            let own =
                leave_out(lin, &lin.basis.with(&accepted.tangent, NEW_DIRECTION), &folds, skip);
            let other = leave_out(lin, &beside, &folds, skip);
            let c = compare(&own, &other, skip);
            c.difference <= c.std
        }
    }
}

/// Share of what the accepted effect explains from which on a rival is fitted in its place.
const MOST: f64 = 0.5;

/// Whether a rival explains most of what the accepted effect does, as the tangents have it.
///
/// Where a parameter is hardly held, as the place of a shallow part beside its tilt, the fit moves far
/// between one name and the other, and what is left is no longer what the tangents say.
fn explains_most(lin: &Linear<'_>, accepted: &Candidate, rival: &Candidate) -> bool {
    let explained = |c: &Candidate| {
        lin.basis.with(&c.tangent, NEW_DIRECTION).explained_from(lin.basis.dim(), &lin.residual)
    };
    rival.home.is_none()
        && matches!(rival.source, Source::Effect(_))
        && explained(rival) >= MOST * explained(accepted)
        && !inside(&span(&lin.basis, accepted), &span(&lin.basis, rival))
}

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
fn holds_as_amplitudes(lin: &Linear<'_>, own: &nalgebra::DMatrix<f64>, rival: &Candidate) -> bool {
    let columns = rival.tangent.ncols();
    let spans = |some: &[usize]| {
        let alone = lin.basis.reject_columns(&rival.tangent.select_columns(some));
        same_span(&Basis::of(&alone, NEW_DIRECTION.sqrt()).matrix(), own)
    };
    columns <= MOST_AMPLITUDES && some_of(columns, own.ncols()).iter().any(|some| spans(some))
}

/// Most amplitudes of an effect of which all choices are tried.
const MOST_AMPLITUDES: usize = 6;

/// Every choice of so many of the first `of` numbers.
fn some_of(of: usize, many: usize) -> Vec<Vec<usize>> {
    if many == 0 {
        return vec![Vec::new()];
    }
    let with_last = |last: usize| {
        some_of(last, many - 1).into_iter().map(move |mut some| {
            some.push(last);
            some
        })
    };
    (many - 1..of).flat_map(with_last).collect()
}

/// Factor of the sum of squares that no rival leaves: twice the error. Noise with memory moves it by
/// less, whatever its law, and the few groups in which two jumps a reading apart differ need not agree.
const TWICE: f64 = 4.0;

/// Whether a rival leaves clearly more than the accepted effect does.
fn leaves_twice(lin: &Linear<'_>, own: &Basis, other: &Basis) -> bool {
    let [(own, own_dof), (other, other_dof)] = [own, other].map(|basis| {
        let dof = lin.residual.len().saturating_sub(basis.dim());
        (basis.reject(&lin.residual).norm_squared(), count(dof.max(1)))
    });
    let ratio = (other / other_dof) / (own / own_dof);
    ratio >= TWICE && f_tail(ratio, other_dof, own_dof) <= DECIDED
}

fn span(base: &Basis, candidate: &Candidate) -> nalgebra::DMatrix<f64> {
    Basis::of(&base.reject_columns(&candidate.tangent), NEW_DIRECTION.sqrt()).matrix()
}
