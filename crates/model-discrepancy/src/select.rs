//! Which effects are missing: one a pass, each refitted and judged on groups left out.

use crate::candidate::{Candidate, Sight, Source, label, sight};
use crate::constancy::not_proportional;
use crate::detectable::detectable_rms;
use crate::holdout::rms;
use crate::judge::{Bench, Hearing, Judged, Setting, hear_catalogue, hear_covariates};
use crate::linear::{Linear, NEW_DIRECTION};
use crate::pair::find_pair;
use crate::replace::replace_superseded;
use crate::significance::{Reach, count, holds_in_readings, significance};
use crate::system::{Estimate, System, rows_of};
use crate::{Outcome, Pass, Score};

/// Share of `alpha` for the catalogue; pairs and covariates get a quarter each.
pub(crate) const CATALOGUE_SHARE: f64 = 0.5;

/// Share of `alpha` for pairs of effects, and for covariates.
pub(crate) const QUARTER: f64 = 0.25;

/// Share of `alpha` for passes after something was added: what is found beside a name counts
/// against the whole answer, and there may be several such passes.
const LATER: f64 = 0.4;

/// Significance that an effect must keep once others are beside it.
pub(crate) const STAY: f64 = 0.05;

/// Residuals below this, in report units, are round-off: a picometre, a nanonewton.
const ROUND_OFF: f64 = 1e-9;

/// Most groups left out one by one while candidates are compared.
pub(crate) const CHOICE_FOLDS: usize = 64;

/// A system as chosen on some groups.
#[derive(Clone)]
pub(crate) struct Selected<'a> {
    pub(crate) system: System<'a>,
    pub(crate) estimate: Estimate,
    pub(crate) added: Vec<Added>,
    /// For the report, where it is asked for.
    pub(crate) passes: Vec<Pass>,
    /// Effects that the declared model's design cannot see, with the share absorbed.
    pub(crate) unseen: Vec<(usize, f64)>,
}

/// Something that was added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Added {
    pub(crate) what: What,
    pub(crate) p_value: f64,
}

/// What was added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum What {
    /// Index into the catalogue.
    Effect(usize),
    /// Covariate and shape.
    Empirical(String, String),
}

/// Chooses effects on the groups of `keep`, from the declared model as fitted to these.
pub(crate) fn select<'a>(
    setting: &Setting<'a>,
    keep: &[bool],
    declared: &Estimate,
) -> Selected<'a> {
    let mut chosen = Selected {
        system: System::declared(setting.model),
        estimate: declared.clone(),
        added: Vec::new(),
        passes: Vec::new(),
        unseen: Vec::new(),
    };
    loop {
        let lin = catalogue_passes(setting, keep, &mut chosen);
        let named = chosen.system.clone();
        covariate_pass(setting, keep, &mut chosen, lin);
        // With nothing new along the covariates the catalogue has had its say.
        let unchanged = chosen.system.empirical.len() == named.empirical.len();
        if unchanged || chosen.added.len() >= setting.options.max_steps {
            break;
        }
    }
    drop_superfluous(setting, keep, &mut chosen);
    chosen
}

/// Probability of adding anything false in the pass that comes next.
fn level(setting: &Setting<'_>, chosen: &Selected<'_>) -> f64 {
    setting.options.alpha * if chosen.added.is_empty() { 1.0 } else { LATER }
}

/// Adds from the catalogue while it has something; the last selection, linearised, where known.
fn catalogue_passes<'a>(
    setting: &Setting<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
) -> Option<Linear<'a>> {
    while chosen.added.len() < setting.options.max_steps {
        let lin = Linear::of(&chosen.system, &chosen.estimate, keep, setting.silent);
        if at_round_off(&lin) {
            return Some(lin);
        }
        let alpha = level(setting, chosen) * CATALOGUE_SHARE;
        let bench = Bench::new(setting, &chosen.system, &chosen.estimate, &lin, alpha);
        let hearing = hear_catalogue(&chosen.system, &chosen.estimate, &bench);
        if chosen.added.is_empty() {
            chosen.unseen.clone_from(&hearing.unseen);
        }
        let mut order = eligible(&hearing.judged, alpha);
        prefer_simpler(&lin, &hearing.judged, &mut order);
        if !not_proportional(setting, chosen, &lin).is_empty() {
            // The rest is a known misfit of a named effect; single points are not to blame.
            order.retain(|&i| hearing.judged[i].candidate.reach == Reach::Many);
        }
        let holds = |j: &Judged| {
            holds_in_readings(&lin, &bench.clean, &j.candidate.beside, &j.test, j.asked)
        };
        let added = order.iter().copied().find(|&i| {
            let judged = &hearing.judged[i];
            holds(judged) && add(chosen, keep, &[judged])
        });
        let pair = if added.is_none() {
            find_pair(&bench, &hearing)
                .filter(|pair| !one_shape_is_better(setting, &bench, pair))
                .filter(|pair| add(chosen, keep, &[&pair[0], &pair[1]]))
        } else {
            None
        };
        if setting.thorough {
            chosen.passes.push(record(setting, &bench, &hearing, added, pair.as_ref()));
        }
        if added.is_none() && pair.is_none() {
            return Some(lin);
        }
    }
    None
}

/// Difference of the Bayesian information criterion that is worth mentioning (Raftery 1995).
const WORTH_MENTIONING: f64 = 2.0;

/// Whether a single shape along a covariate describes the data better than two named effects.
fn one_shape_is_better(setting: &Setting<'_>, bench: &Bench<'_>, pair: &[Judged; 2]) -> bool {
    let judged = hear_covariates(setting, bench);
    let order = eligible(&judged, setting.options.alpha * QUARTER);
    let n = count(bench.lin.rows.len());
    let before = bench.lin.clean_residual().norm_squared();
    order.iter().any(|&i| {
        let test = &judged[i].test;
        let Source::Empirical(shape) = &judged[i].candidate.source else { return false };
        // Unlike two effects, a shape brings its constants along: they count here.
        let left = (test.variance * count(test.dof) / before).max(f64::MIN_POSITIVE);
        let criterion = n * left.ln() + count(test.directions + shape.constants) * n.ln();
        criterion < pair[0].criterion - WORTH_MENTIONING
    })
}

/// Significant candidates that generalise, the best description of the data first.
///
/// What shows in many groups goes before what lives in one: a few extreme points describe a
/// smooth effect well, the other way round is refused by the scatter between groups.
fn eligible(judged: &[Judged], alpha: f64) -> Vec<usize> {
    let mut order: Vec<_> = (0..judged.len())
        .filter(|&i| judged[i].adjusted <= alpha && judged[i].generalises())
        .collect();
    let local = |i: usize| judged[i].candidate.reach == Reach::One;
    order.sort_by(|&a, &b| {
        local(a).cmp(&local(b)).then(judged[a].criterion.total_cmp(&judged[b].criterion))
    });
    order
}

/// Moves a candidate with fewer amplitudes to the front when the best adds nothing to it.
fn prefer_simpler(lin: &Linear<'_>, judged: &[Judged], order: &mut [usize]) {
    let Some(&best) = order.first() else { return };
    let directions = |i: usize| judged[i].test.directions;
    let mut simpler: Vec<usize> = (1..order.len())
        .filter(|&at| {
            directions(order[at]) < directions(best)
                && judged[order[at]].candidate.reach == Reach::Many
        })
        .collect();
    simpler.sort_by_key(|&at| directions(order[at]));
    for at in simpler {
        let base = lin.basis.with(&judged[order[at]].candidate.tangent, NEW_DIRECTION);
        let c = &judged[best].candidate;
        let more = significance(lin, &base, &c.tangent, c.reach, STAY);
        if more.is_none_or(|t| t.p_value > STAY) {
            order[..=at].rotate_right(1);
            return;
        }
    }
}

/// Adds candidates and refits; false, and nothing changed, when the nested cost did not fall.
fn add(chosen: &mut Selected<'_>, keep: &[bool], candidates: &[&Judged]) -> bool {
    let mut system = chosen.system.clone();
    for judged in candidates {
        system = judged.candidate.added_to(&system);
    }
    let rows = rows_of(&system.model.declared().layout, keep);
    let start = system.carry(&chosen.estimate);
    let Ok(estimate) = system.fit(&rows, &start) else { return false };
    if cost(&system, &estimate, &rows) >= cost(&chosen.system, &chosen.estimate, &rows) {
        return false;
    }
    let Ok(estimate) = system.reweighed(&rows, estimate) else { return false };
    chosen.system = system;
    chosen.estimate = estimate;
    for judged in candidates {
        let what = what(&judged.candidate);
        chosen.added.push(Added { what, p_value: judged.test.p_value });
    }
    true
}

fn what(candidate: &Candidate) -> What {
    match &candidate.source {
        Source::Effect(active) => What::Effect(active.effect),
        Source::Empirical(e) => What::Empirical(e.covariate.clone(), e.shape.clone()),
    }
}

/// Sum of squared whitened residuals over `rows`.
fn cost(system: &System<'_>, at: &Estimate, rows: &[usize]) -> f64 {
    let layout = &system.model.declared().layout;
    let all = system.residuals(at);
    rows.iter().map(|&row| (all[row] / at.sigma(&layout.rows[row])).powi(2)).sum()
}

fn at_round_off(lin: &Linear<'_>) -> bool {
    let sum: f64 =
        (lin.sigma.iter().zip(lin.residual.iter())).map(|(sigma, r)| (r * sigma).powi(2)).sum();
    (sum / count(lin.rows.len().max(1))).sqrt() < ROUND_OFF
}

/// Adds the shape along a covariate that describes the rest best, and takes back effects that
/// it makes superfluous.
fn covariate_pass<'a>(
    setting: &Setting<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
    known: Option<Linear<'a>>,
) {
    if chosen.added.len() >= setting.options.max_steps {
        return;
    }
    let anew = || Linear::of(&chosen.system, &chosen.estimate, keep, setting.silent);
    let lin = known.unwrap_or_else(anew);
    if at_round_off(&lin) {
        return;
    }
    let alpha = level(setting, chosen) * QUARTER;
    let bench = Bench::new(setting, &chosen.system, &chosen.estimate, &lin, alpha);
    let judged = hear_covariates(setting, &bench);
    let mut order = eligible(&judged, alpha);
    prefer_simpler(&lin, &judged, &mut order);
    let found = order.into_iter().find(|&i| add(chosen, keep, &[&judged[i]]));
    if let Some(found) = found {
        replace_superseded(setting, keep, chosen, &judged[found].candidate);
    }
}

/// Takes back effects that the ones added later have made superfluous.
fn drop_superfluous(setting: &Setting<'_>, keep: &[bool], chosen: &mut Selected<'_>) {
    let effects: Vec<_> = chosen.system.active.iter().map(|a| a.effect).collect();
    for effect in effects {
        let without = chosen.system.without_effect(effect);
        let without = regrown(setting, keep, &without, &chosen.estimate);
        let rows = rows_of(&setting.model.declared().layout, keep);
        let Ok(estimate) = without.fit(&rows, &without.carry(&chosen.estimate)) else { continue };
        let lin = Linear::of(&without, &estimate, keep, setting.silent);
        let needed = match sight(setting.model, effect, &estimate, &lin, &lin.basis) {
            Sight::Seen(c) => significance(&lin, &lin.basis, &c.tangent, c.reach, STAY)
                .is_some_and(|t| t.p_value <= STAY),
            Sight::Unseen(_) => false,
        };
        if !needed {
            let Ok(estimate) = without.reweighed(&rows, estimate) else { continue };
            chosen.system = without;
            chosen.estimate = estimate;
            chosen.added.retain(|a| a.what != What::Effect(effect));
        }
    }
}

/// The system with every amplitude that its effects have beside each other: one that was added
/// beside an effect which is there no more may have had to leave some to it.
fn regrown<'a>(
    setting: &Setting<'_>,
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
        let at = others.carry(at);
        let lin = Linear::of(&others, &at, keep, setting.silent);
        if let Sight::Seen(whole) = sight(setting.model, effect, &at, &lin, &lin.basis) {
            regrown = whole.added_to(&others);
        }
    }
    regrown
}

/// The table of one pass for the report, best first.
fn record(
    setting: &Setting<'_>,
    bench: &Bench<'_>,
    hearing: &Hearing,
    added: Option<usize>,
    pair: Option<&[Judged; 2]>,
) -> Pass {
    let in_pair =
        |c: &Candidate| pair.is_some_and(|p| p.iter().any(|j| what(&j.candidate) == what(c)));
    let mut judged: Vec<_> = hearing.judged.iter().enumerate().collect();
    judged.sort_by(|a, b| a.1.criterion.total_cmp(&b.1.criterion));
    let mut scores: Vec<_> = judged
        .into_iter()
        .map(|(i, j)| {
            let outcome = if added == Some(i) || in_pair(&j.candidate) {
                Outcome::Added
            } else if j.adjusted > bench.alpha {
                Outcome::NotSignificant
            } else if !j.generalises() {
                Outcome::DidNotGeneralise
            } else if added.is_some_and(|a| hearing.judged[a].class == j.class) {
                Outcome::Rival
            } else {
                Outcome::Weaker
            };
            Score {
                label: j.candidate.label(),
                absorbed: j.candidate.absorbed(&bench.lin.basis),
                f_statistic: j.test.f_statistic,
                p_value: j.test.p_value,
                held_out_rms: j.held_out.as_deref().map_or(f64::NAN, |h| rms(h).0),
                detectable_rms: detectable_rms(
                    bench.lin,
                    &j.test,
                    &j.candidate,
                    hearing.alpha_single,
                ),
                outcome,
            }
        })
        .collect();
    scores.extend(hearing.unseen.iter().map(|&(e, absorbed)| {
        let effect = &setting.model.declared().effects[e];
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
