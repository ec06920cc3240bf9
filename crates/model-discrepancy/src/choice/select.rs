//! Which effects are missing: one a pass, each refitted and judged on groups left out.

use crate::algebra::system::{Estimate, System, rows_of};
use crate::choice::additivity::not_additive;
use crate::choice::blocks::passing::Passing;
use crate::choice::candidate::{Candidate, Estimability, Source, estimability, label};
use crate::choice::context::Context;
use crate::choice::detectable::detectable_rms;
use crate::choice::exchange::exchange;
use crate::choice::grown::grow;
use crate::choice::masked::find_masked;
use crate::choice::pair::find_pair;
use crate::choice::ranking::{Confirmed, is_eligible, ranked};
use crate::choice::replace::replace_superseded;
use crate::choice::score::{
    ScorePass, Scored, Scoring, home_of_bad, score_catalogue, score_passing,
};
use crate::choice::score_shapes::score_covariates;
use crate::choice::selected::{Added, Selected, What, cost, what, within_limits};
use crate::choice::shape::is_of_levels;
use crate::choice::tail::may_be_a_tail;
use crate::count::count;
use crate::levels::CATALOGUE_SHARE;
use crate::levels::FAR_CLEARER;
use crate::levels::LATER;
use crate::levels::QUARTER;
use crate::levels::STAY;
use crate::levels::WORTH_MENTIONING;
use crate::noise::linear::Linear;
use crate::tests::hold_out::rms;
use crate::tests::significance::{Reach, holds_in_readings, significance};
use crate::{Model, Outcome, Pass, Score};

/// Residuals below this, in report units, are round-off: a picometre, a nanonewton.
const ROUND_OFF: f64 = 1e-9;

/// Chooses effects on the groups of `keep`, from the declared model as fitted to these.
pub(crate) fn select<'a>(
    context: &Context<'a>,
    keep: &[bool],
    declared: &Estimate,
) -> Selected<'a> {
    let mut chosen = Selected {
        system: System::declared(context.model),
        estimate: declared.clone(),
        added: Vec::new(),
        passes: Vec::new(),
        not_estimable: Vec::new(),
    };
    let mut exchanges = 0;
    loop {
        let shapes = chosen.system.empirical.len();
        let mut lin = catalogue_passes(context, keep, &mut chosen);
        while exchanges < context.options.max_steps && exchange(context, keep, &mut chosen) {
            exchanges += 1;
            lin = catalogue_passes(context, keep, &mut chosen);
        }
        let lin = if replaced_by_shape(context, keep, &mut chosen) { None } else { lin };
        covariate_pass(context, keep, &mut chosen, lin);
        // With nothing new along the covariates the catalogue has had its say.
        let unchanged = chosen.system.empirical.len() == shapes;
        if unchanged || chosen.added.len() >= context.options.max_steps {
            break;
        }
    }
    drop_superfluous(context, keep, &mut chosen);
    chosen
}

/// Probability of adding anything false in the pass that comes next.
fn level(context: &Context<'_>, chosen: &Selected<'_>) -> f64 {
    context.options.alpha * if chosen.added.is_empty() { 1.0 } else { LATER }
}

/// Adds from the catalogue while it has something; the last selection, linearised, where known.
fn catalogue_passes<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
) -> Option<Linear<'a>> {
    while chosen.added.len() < context.options.max_steps {
        let alpha = level(context, chosen) * CATALOGUE_SHARE;
        let passing = (context.without_block)
            .map_or(Passing::Any, |known| known.passing(&chosen.system, alpha));
        if matches!(passing, Passing::Nothing) {
            return None;
        }
        let lin = context.linear(&chosen.system, &chosen.estimate, keep);
        if at_round_off(&lin) {
            return Some(lin);
        }
        let scoring = Scoring::new(context, &chosen.system, &chosen.estimate, &lin, alpha);
        if let Passing::These(these) = passing {
            let mut judged = score_passing(&chosen.system, &chosen.estimate, &scoring, &these);
            if add_best(context, keep, chosen, &scoring, &mut judged).is_some() {
                grow(context, keep, chosen);
                continue;
            }
        }
        let mut pass = score_catalogue(&chosen.system, &chosen.estimate, &scoring);
        if chosen.added.is_empty() {
            chosen.not_estimable.clone_from(&pass.not_estimable);
        }
        let added = add_best(context, keep, chosen, &scoring, &mut pass.judged);
        let pair = if added.is_none() {
            pass.judged.retain(|j| j.adjusted.is_finite());
            let stands = |pair: &[Scored; 2]| !one_shape_is_better(context, &scoring, pair);
            let masked = || find_masked(&scoring, &chosen.system, &chosen.estimate);
            find_pair(&scoring, &pass)
                .filter(stands)
                .or_else(|| masked().filter(stands))
                .filter(|[a, b]| !may_be_a_tail(&lin, &lin.basis, &[&a.candidate, &b.candidate]))
                .filter(|pair| add(chosen, keep, &[&pair[0], &pair[1]]))
        } else {
            None
        };
        if context.thorough {
            chosen.passes.push(record(context, &scoring, &pass, added, pair.as_ref()));
        }
        if added.is_none() && pair.is_none() {
            return Some(lin);
        }
        grow(context, keep, chosen);
    }
    None
}

/// Adds the best candidate that stands all tests; which one it is.
fn add_best(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &mut Selected<'_>,
    scoring: &Scoring<'_>,
    judged: &mut [Scored],
) -> Option<usize> {
    let lin = scoring.lin;
    [Confirmed::First, Confirmed::All].into_iter().find_map(|confirmed| {
        let mut order = ranked(scoring, judged, confirmed);
        let is_wide = |i: usize| judged[i].candidate.reach == Reach::Many;
        if !order.iter().all(|&i| is_wide(i)) {
            // The rest is a known misfit of a named effect; single points are not to blame, but for one that is far
            // clearer than that.
            let misfits = not_additive(context, chosen, lin);
            let clearest = misfits.iter().map(|d| d.remaining.p_value).reduce(f64::min);
            let is_clearer = |i: usize| {
                clearest.is_none_or(|p_value| judged[i].test.p_value < FAR_CLEARER * p_value)
            };
            order.retain(|&i| is_wide(i) || is_clearer(i));
        }
        let holds = |j: &Scored| {
            holds_in_readings(lin, &scoring.clean, &j.candidate.beside, &j.test, j.asked)
        };
        order.into_iter().find(|&i| holds(&judged[i]) && add(chosen, keep, &[&judged[i]]))
    })
}

/// Whether a single shape along a covariate describes the data better than two named effects.
fn one_shape_is_better(context: &Context<'_>, scoring: &Scoring<'_>, pair: &[Scored; 2]) -> bool {
    better_shape(context, scoring, (pair[0].criterion, 0), |_| true).is_some()
}

/// The shape along a covariate that describes the data best of those whose names `counts`, where it
/// does so clearly better than effects of this criterion and so many directions; with no more
/// directions than these, where it does so no worse.
fn better_shape(
    context: &Context<'_>,
    scoring: &Scoring<'_>,
    (than, directions): (f64, usize),
    counts: impl Fn(&str) -> bool,
) -> Option<Scored> {
    let alpha = context.options.alpha * QUARTER;
    let mut judged = score_covariates(context, scoring);
    let n = count(scoring.lin.rows.len());
    let before = scoring.lin.clean_residual().norm_squared();
    let criterion = |judged: &Scored| {
        let Source::Empirical(shape) = &judged.candidate.source else { return f64::INFINITY };
        if !counts(&shape.shape) {
            return f64::INFINITY;
        }
        let left = (judged.test.variance * count(judged.test.dof) / before).max(f64::MIN_POSITIVE);
        let (free, own) = (judged.test.directions, shape.constants);
        if free <= directions {
            // As many laws as levels: they pass through any values, and their names say nothing.
            return n * left.ln() + count(free) * n.ln() - 2.0 * WORTH_MENTIONING;
        }
        // Unlike effects, a shape brings its constants along: they count here.
        n * left.ln() + count(free + own) * n.ln()
    };
    let mut better: Vec<_> = (judged.iter().map(criterion).enumerate())
        .filter(|(_, criterion)| *criterion < than - WORTH_MENTIONING)
        .collect();
    better.sort_by(|a, b| a.1.total_cmp(&b.1));
    let first = better.into_iter().map(|(i, _)| i).find(|&i| {
        judged[i].confirm(scoring);
        is_eligible(&judged[i], alpha)
    });
    first.map(|i| judged.swap_remove(i))
}

/// Puts a shape of levels in place of all named effects where it describes the data better: two laws
/// of a load pass through any three loads, and say nothing where one of the loads went otherwise; and
/// of an error of its own at every place a sag or a shear takes a part, as any few numbers do.
///
/// With no more directions than the effects have it need be no worse, where these are two, or one whose
/// place was found by looking: a shift from a press on is the load that begins there.
fn replaced_by_shape(context: &Context<'_>, keep: &[bool], chosen: &mut Selected<'_>) -> bool {
    if chosen.system.active.is_empty() || !has_levels(context) {
        return false;
    }
    let named = context.linear(&chosen.system, &chosen.estimate, keep);
    // One bad reading is no law.
    let is_bad = |effect| home_of_bad(context, &chosen.estimate, &named, effect).is_some();
    let effects = chosen.system.active.iter().map(|active| active.effect);
    let effects: Vec<usize> = effects.filter(|effect| !is_bad(*effect)).collect();
    if effects.is_empty() {
        return false;
    }
    let mut plain = chosen.clone();
    for &effect in &effects {
        plain.system = plain.system.without_effect(effect);
        plain.added.retain(|a| a.what != What::Effect(effect));
    }
    let rows = rows_of(&context.model.declared().layout, keep);
    let start = plain.system.warm_start(&chosen.estimate);
    let Ok(estimate) = plain.system.fit(&rows, &start) else { return false };
    plain.estimate = estimate;
    let lin = context.linear(&plain.system, &plain.estimate, keep);
    let n = count(lin.rows.len());
    let left =
        cost(&chosen.system, &chosen.estimate, &rows) / cost(&plain.system, &plain.estimate, &rows);
    let directions = named.basis.dim().saturating_sub(lin.basis.dim());
    let criterion = n * left.max(f64::MIN_POSITIVE).ln() + count(directions) * n.ln();
    let alpha = context.options.alpha * QUARTER;
    let scoring = Scoring::new(context, &plain.system, &plain.estimate, &lin, alpha);
    let is_law = |effect: usize| context.model.declared().effects[effect].searched == 1;
    let as_many = if matches!(effects[..], [one] if is_law(one)) { 0 } else { directions };
    let than = (criterion, as_many);
    let Some(shape) = better_shape(context, &scoring, than, is_of_levels) else { return false };
    if !add(&mut plain, keep, &[&shape]) {
        return false;
    }
    plain.passes.clone_from(&chosen.passes);
    *chosen = plain;
    true
}

/// Whether any covariate has levels, or is a load that is set again.
fn has_levels(context: &Context<'_>) -> bool {
    let mut all = context.shapes.iter().flat_map(|along| along.single.iter().chain(&along.apart));
    all.any(|shape| is_of_levels(&shape.name))
}

/// Adds candidates and refits; false, and nothing changed, when the nested cost did not fall.
fn add(chosen: &mut Selected<'_>, keep: &[bool], candidates: &[&Scored]) -> bool {
    let mut system = chosen.system.clone();
    for judged in candidates {
        system = judged.candidate.added_to(&system);
    }
    let rows = rows_of(&system.model.declared().layout, keep);
    let start = system.warm_start(&chosen.estimate);
    let Ok(estimate) = system.fit(&rows, &start) else { return false };
    if cost(&system, &estimate, &rows) >= cost(&chosen.system, &chosen.estimate, &rows) {
        return false;
    }
    let Ok(estimate) = system.reweighed(&rows, estimate) else { return false };
    if !within_limits(&system, &estimate) {
        return false;
    }
    chosen.system = system;
    chosen.estimate = estimate;
    for judged in candidates {
        let what = what(&judged.candidate);
        chosen.added.push(Added { what, p_value: judged.test.p_value });
    }
    true
}

fn at_round_off(lin: &Linear<'_>) -> bool {
    let sum: f64 =
        (lin.sigma.iter().zip(lin.residual.iter())).map(|(sigma, r)| (r * sigma).powi(2)).sum();
    (sum / count(lin.rows.len().max(1))).sqrt() < ROUND_OFF
}

/// Adds the shape along a covariate that describes the rest best, and takes back effects that
/// it makes superfluous.
fn covariate_pass<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
    known: Option<Linear<'a>>,
) {
    if chosen.added.len() >= context.options.max_steps {
        return;
    }
    let alpha = level(context, chosen) * QUARTER;
    if context.without_block.is_some_and(|known| !known.shape_may_pass(&chosen.system, alpha)) {
        return;
    }
    let anew = || context.linear(&chosen.system, &chosen.estimate, keep);
    let lin = known.unwrap_or_else(anew);
    if at_round_off(&lin) {
        return;
    }
    let scoring = Scoring::new(context, &chosen.system, &chosen.estimate, &lin, alpha);
    let mut judged = score_covariates(context, &scoring);
    let found = [Confirmed::First, Confirmed::All].into_iter().find_map(|confirmed| {
        let order = ranked(&scoring, &mut judged, confirmed);
        order.into_iter().find(|&i| add(chosen, keep, &[&judged[i]]))
    });
    if let Some(found) = found {
        replace_superseded(context, keep, chosen, &judged[found].candidate);
    }
}

/// Takes back effects that the ones added later have made superfluous.
fn drop_superfluous(context: &Context<'_>, keep: &[bool], chosen: &mut Selected<'_>) {
    let effects: Vec<_> = chosen.system.active.iter().map(|a| a.effect).collect();
    let all = chosen.added.len();
    for effect in effects {
        let is_last = chosen.added.last().is_some_and(|last| last.what == What::Effect(effect));
        if is_last && chosen.added.len() == all {
            // Nothing has changed since it was significant beside all others, at a smaller level.
            continue;
        }
        let without = chosen.system.without_effect(effect);
        let without = regrown(context, keep, &without, &chosen.estimate);
        let rows = rows_of(&context.model.declared().layout, keep);
        let Ok(estimate) = without.fit(&rows, &without.warm_start(&chosen.estimate)) else {
            continue;
        };
        let lin = Linear::of(&without, &estimate, keep, context.silent);
        if !is_needed(context.model, effect, &estimate, &lin, STAY) {
            let Ok(estimate) = without.reweighed(&rows, estimate) else { continue };
            if !within_limits(&without, &estimate) {
                continue;
            }
            chosen.system = without;
            chosen.estimate = estimate;
            chosen.added.retain(|a| a.what != What::Effect(effect));
        }
    }
}

/// Whether an effect is significant at `level` beside the system of `lin`, which lacks it.
fn is_needed(
    model: &dyn Model,
    effect: usize,
    at: &Estimate,
    lin: &Linear<'_>,
    level: f64,
) -> bool {
    let Estimability::Estimable(c) = estimability(model, effect, at, lin, &lin.basis) else {
        return false;
    };
    let test = significance(lin, &lin.basis, &c.tangent, c.reach, level);
    test.is_some_and(|test| test.p_value <= level)
}

/// Whether the named effect that was added as number `index` is significant at `level` beside the others
/// that were, on the groups of `keep`.
pub(crate) fn still_needed(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'_>,
    index: usize,
    level: f64,
) -> bool {
    let What::Effect(effect) = chosen.added[index].what else { return false };
    let Some(others) = without(context, keep, chosen, index) else { return false };
    let lin = context.linear(&others.system, &others.estimate, keep);
    is_needed(context.model, effect, &others.estimate, &lin, level)
}

/// The selection without its entry `index`, fitted anew; `None` where that cannot be fitted.
pub(crate) fn without<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
    index: usize,
) -> Option<Selected<'a>> {
    let mut left = chosen.clone();
    let removed = left.added.remove(index);
    left.system = match &removed.what {
        What::Effect(effect) => left.system.without_effect(*effect),
        What::Empirical(covariate, shape) => left.system.without_empirical(covariate, shape),
    };
    let rows = rows_of(&context.model.declared().layout, keep);
    let start = left.system.warm_start(&chosen.estimate);
    let estimate = left.system.fit(&rows, &start).ok()?;
    left.estimate = left.system.reweighed(&rows, estimate).ok()?;
    Some(left)
}

/// The system with every amplitude that its effects have beside each other: one that was added
/// beside an effect which is there no more may have had to leave some to it.
fn regrown<'a>(
    context: &Context<'_>,
    keep: &[bool],
    system: &System<'a>,
    at: &Estimate,
) -> System<'a> {
    let mut regrown = system.clone();
    for active in &system.active {
        let effect = active.effect;
        if active.parameters.len() == system.model.declared().effects[effect].parameters.len() {
            continue;
        }
        let others = regrown.without_effect(effect);
        let at = others.warm_start(at);
        let lin = Linear::of(&others, &at, keep, context.silent);
        if let Estimability::Estimable(whole) =
            estimability(context.model, effect, &at, &lin, &lin.basis)
            && let Source::Effect(seen) = &whole.source
            && seen.parameters.len() > active.parameters.len()
        {
            regrown = whole.added_to(&others);
        }
    }
    regrown
}

/// The table of one pass for the report, best first.
fn record(
    context: &Context<'_>,
    scoring: &Scoring<'_>,
    pass: &ScorePass,
    added: Option<usize>,
    pair: Option<&[Scored; 2]>,
) -> Pass {
    let in_pair =
        |c: &Candidate| pair.is_some_and(|p| p.iter().any(|j| what(&j.candidate) == what(c)));
    let mut judged: Vec<_> = pass.judged.iter().enumerate().collect();
    judged.sort_by(|a, b| a.1.criterion.total_cmp(&b.1.criterion));
    let mut scores: Vec<_> = judged
        .into_iter()
        .map(|(i, j)| {
            let outcome = if added == Some(i) || in_pair(&j.candidate) {
                Outcome::Added
            } else if j.adjusted > scoring.alpha {
                Outcome::NotSignificant
            } else if !j.generalises() {
                Outcome::DidNotGeneralise
            } else if added.is_some_and(|a| pass.judged[a].class == j.class) {
                Outcome::Rival
            } else {
                Outcome::Weaker
            };
            Score {
                label: j.candidate.label(),
                absorbed: j.candidate.absorbed(&scoring.lin.basis),
                f_statistic: j.test.f_statistic,
                p_value: j.test.p_value,
                held_out_rms: j.held_out.as_deref().map_or(f64::NAN, |h| rms(h).0),
                detectable_rms: detectable_rms(
                    scoring.lin,
                    &j.test,
                    &j.candidate,
                    pass.alpha_single,
                ),
                outcome,
            }
        })
        .collect();
    scores.extend(pass.not_estimable.iter().map(|&(e, absorbed)| {
        let effect = &context.model.declared().effects[e];
        Score {
            label: label(&effect.id, effect.subject.as_deref()),
            absorbed,
            f_statistic: f64::NAN,
            p_value: f64::NAN,
            held_out_rms: f64::NAN,
            detectable_rms: f64::INFINITY,
            outcome: Outcome::NotObservable,
        }
    }));
    Pass { scores }
}
