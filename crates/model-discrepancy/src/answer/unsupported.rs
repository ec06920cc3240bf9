//! What was added and does not stand once the choice is repeated or held against groups set aside.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::algebra::system::{Estimate, System};
use crate::answer::contradiction::misfit;
use crate::answer::external_validation::{badly_predicted, check_distance};
use crate::answer::structure::is_memory;
use crate::answer::summary::Summaries;
use crate::answer::verdict::noisier_than_declared;
use crate::choice::candidate::label;
use crate::choice::context::Context;
use crate::choice::score::home_of_bad;
use crate::choice::select::without;
use crate::choice::selected::{Added, Selected, What};
use crate::count::count;
use crate::levels::{
    BEYOND_DOUBT, FOUND_AGAIN, HARDLY_CHANCE, HARDLY_LEFT, HEARD, REFUTED, SEVERAL_TIMES,
};
use crate::noise::linear::Linear;
use crate::tests::global_test::global_test;
use crate::tests::groups_apart::GROUP;
use crate::{HoldOut, Remaining, Row, Stability};

/// Why something is left over that does not lower the error on data that the fit did not see.
const NO_GAIN: &str = "does not predict unseen groups any better: taken back";

/// Why one bad reading is left over where groups set aside lie as far off.
const NO_ACCIDENT: &str = "no accident, as groups set aside lie off as well: taken back";

/// Why a name is left over beside something without one that is the more significant of the two.
const OUTWEIGHED: &str =
    "weaker than what is left beside it, of which it may be a part: taken back";

/// The choice without an addition that does not stand.
pub(crate) struct TakenBack<'a> {
    pub(crate) rest: Selected<'a>,
    pub(crate) why: Why,
}

/// Why an addition does not stand.
pub(crate) enum Why {
    /// Something is there, and is left over in its place.
    Left(Remaining),
    /// Nothing is: with the groups set aside it is not significant. What to say of it.
    Chance(String),
}

/// The choice without the addition to be taken back next, and what is left over in its place.
///
/// One that too few repetitions find again; or the last of many readings, where unseen groups are not
/// predicted any better; or the last bad reading, where groups set aside lie as far off, or where they
/// did, as `taken_back` has it: the fit is worse without that, and less surprised by them.
pub(crate) fn unsupported<'a>(
    (context, keep): (&Context<'a>, &[bool]),
    (chosen, lin): (&Selected<'a>, &Linear<'_>),
    summaries: &Summaries,
    taken_back: &[Remaining],
) -> Option<TakenBack<'a>> {
    let left = |i: usize, why: &str| {
        let why = Why::Left(left_over(context, &chosen.added[i], why.to_owned()));
        Some(TakenBack { rest: without(context, keep, chosen, i)?, why })
    };
    let chance =
        |i: usize, against: &str| Why::Chance(by_chance(context, &chosen.added[i], against));
    let gainless = |i: usize| {
        if is_of_the_noise((context, keep), chosen) {
            let why = chance(i, "groups that were not fitted");
            return Some(TakenBack { rest: without(context, keep, chosen, i)?, why });
        }
        left(i, NO_GAIN)
    };
    if let Some((i, why)) = least_stable(&summaries.stability) {
        return left(i, &why);
    }
    let is_checked = summaries.after.hold_out == HoldOut::CheckGroups;
    let lie_off = badly_predicted(context, chosen, lin).is_some();
    let last = |bad: bool| {
        chosen.added.iter().rposition(|added| is_bad_reading(context, chosen, lin, added) == bad)
    };
    // Check groups choose nothing; what they refute does not stand.
    let are_against = is_checked && summaries.unseen_ratio >= REFUTED;
    let is_gainless = if is_checked { are_against && lie_off } else { summaries.gain_ratio >= 1.0 };
    if let Some(i) = last(false) {
        if is_gainless {
            return gainless(i);
        }
        if is_checked
            && has_no_gain(summaries)
            && let Some(rest) = without(context, keep, chosen, i)
            && !holds_with_checks((context, keep), (chosen, lin), &rest, chosen.added[i].p_value)
        {
            return Some(TakenBack { rest, why: chance(i, "groups set aside") });
        }
        let has_lost = if is_checked {
            are_against
        } else {
            // One name may rest on the groups at its end; several are chosen by one group.
            let are_several = chosen
                .added
                .iter()
                .filter(|added| !is_bad_reading(context, chosen, lin, added))
                .nth(1);
            (summaries.strays.is_empty() || are_several.is_some()) && has_no_gain(summaries)
        };
        if has_lost && chosen.added[i].p_value > BEYOND_DOUBT {
            return gainless(i);
        }
    }
    let are_accidents = !lie_off && taken_back.iter().all(|before| before.shape != NO_ACCIDENT);
    last(true).filter(|_| !are_accidents).and_then(|i| left(i, NO_ACCIDENT))
}

/// Whether what `others` lack is significant still, once the likelihood of the check groups with it, over
/// that without it, is added to that of the groups that were fitted.
///
/// What is significant by chance, once in a thousand times, check groups speak against as often as for.
fn holds_with_checks(
    (context, keep): (&Context<'_>, &[bool]),
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    others: &Selected<'_>,
    p_value: f64,
) -> bool {
    let before = context.linear(&others.system, &others.estimate, keep);
    // Of one fit and of the other the same noise.
    let sigma = |row: &Row| chosen.estimate.sigma(row);
    let of = |chosen: &Selected<'_>, lin: &Linear<'_>| {
        Some(check_distance(context, chosen, lin, &sigma)?.square)
    };
    let (Some(with), Some(without)) = (of(chosen, lin), of(others, &before)) else { return true };
    let directions = lin.basis.dim().saturating_sub(before.basis.dim());
    let Ok(law) = ChiSquared::new(count(directions)) else { return true };
    let needed = law.inverse_cdf(1.0 - HEARD) + with - without;
    p_value <= law.sf(needed)
}

/// Whether the one addition is no clearer than chance is once in ten thousand times, and all that is there without it is
/// the declared noise.
fn is_of_the_noise((context, keep): (&Context<'_>, &[bool]), chosen: &Selected<'_>) -> bool {
    let [added] = &chosen.added[..] else { return false };
    let is_noise = || {
        let rest = without(context, keep, chosen, 0)?;
        let lin = context.linear(&rest.system, &rest.estimate, keep);
        let is_declared = global_test(&rest.system, &rest.estimate, &lin).is_some();
        Some(is_declared && !noisier_than_declared(context, &lin, &rest))
    };
    added.p_value > HARDLY_CHANCE && is_noise().unwrap_or(false)
}

fn by_chance(context: &Context<'_>, added: &Added, against: &str) -> String {
    format!(
        "{} shows in the fitted groups (p = {:.1e}) and {against} speak against it: together they show \
         no more than chance does, and it was not added",
        name_of(context, added),
        added.p_value
    )
}

/// The choice without the last name that is less significant than something `left` in the fitted groups: that is
/// not explained, and the name may be a part of it.
///
/// Not beside a hundredth of the misfit: the smallest is significant where readings are many. Nor beside groups that
/// lie apart, or memory of noise that is as declared: both are in the significance of the name. Beside what `repeats`
/// at places that are visited again, a name that was looked for along them, as a period is, is a part of that.
pub(crate) fn outweighed<'a>(
    (context, keep): (&Context<'a>, &[bool]),
    base: &Estimate,
    (chosen, lin): (&Selected<'a>, &Linear<'_>),
    (left, repeats): (&[Remaining], Option<&Remaining>),
) -> Option<TakenBack<'a>> {
    let is_noise = |remaining: &Remaining| {
        is_memory(remaining) && !noisier_than_declared(context, lin, chosen)
    };
    let unexplained = left.iter().filter(|r| r.covariate != GROUP && !is_noise(r));
    let strongest = unexplained.map(|remaining| remaining.p_value).min_by(f64::total_cmp);
    // What scatters several times as declared is as clear as anything.
    let strongest = strongest.or_else(|| {
        let test = global_test(&chosen.system, &chosen.estimate, lin)?;
        (left.is_empty() && test.per_dof() >= SEVERAL_TIMES).then(|| test.p_value())
    });
    let was_looked_for = |effect: usize| context.model.declared().effects[effect].searched > 1;
    let is_weaker = |added: &Added| {
        let What::Effect(effect) = added.what else { return false };
        let is_beside = |p_value: f64| added.p_value > p_value.max(BEYOND_DOUBT);
        let is_of_repeats = was_looked_for(effect) && repeats.is_some_and(|r| is_beside(r.p_value));
        (is_of_repeats || strongest.is_some_and(is_beside))
            && !is_bad_reading(context, chosen, lin, added)
    };
    let i = chosen.added.iter().rposition(is_weaker)?;
    let before = misfit(keep, &System::declared(context.model), base);
    if misfit(keep, &chosen.system, &chosen.estimate) < HARDLY_LEFT * before {
        return None;
    }
    let why = Why::Left(left_over(context, &chosen.added[i], OUTWEIGHED.to_owned()));
    Some(TakenBack { rest: without(context, keep, chosen, i)?, why })
}

/// Whether unseen groups are not predicted any better, weighed by their uncertainties or as the error is reported.
fn has_no_gain(summaries: &Summaries) -> bool {
    summaries.unseen_ratio >= 1.0 || summaries.after.held_out_rms > summaries.before.held_out_rms
}

/// What was added, where unseen groups are not predicted any better, weighed by their uncertainties or
/// as the error is reported: it stands, and explains nothing.
pub(crate) fn no_gain(
    context: &Context<'_>,
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    summaries: &Summaries,
) -> Option<Remaining> {
    let is_of_many = |added: &Added| !is_bad_reading(context, chosen, lin, added);
    let is_gainless = has_no_gain(summaries) && chosen.added.iter().any(is_of_many);
    let shape = if summaries.gain_ratio < 1.0 && !summaries.strays.is_empty() {
        format!(
            "what was added predicts them but for {}, without which something else is chosen: measure \
             there again",
            summaries.strays.join(", ")
        )
    } else {
        "what was added does not predict them any better".to_owned()
    };
    is_gainless.then(|| Remaining {
        covariate: "unseen groups".to_owned(),
        shape,
        p_value: chosen.added.iter().map(|a| a.p_value).fold(0.0, f64::max),
    })
}

/// Whether an addition is one bad reading, which is no part of the model: without it, others are
/// predicted better or worse by chance.
fn is_bad_reading(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
    added: &Added,
) -> bool {
    match added.what {
        What::Effect(effect) => home_of_bad(context, &chosen.estimate, lin, effect).is_some(),
        What::Empirical(..) => false,
    }
}

/// The addition that the fewest repetitions find again, where that is fewer than half of them, and
/// why that is too few.
fn least_stable(stability: &[Stability]) -> Option<(usize, String)> {
    let one = |(i, s): (usize, &Stability)| {
        [
            (s.resampled, "without some groups"),
            (s.perturbed, "with readings moved within their resolution"),
        ]
        .map(|(share, repetitions)| Some((i, share?, repetitions)))
    };
    let known = stability.iter().enumerate().flat_map(one).flatten();
    let (i, share, repetitions) =
        known.filter(|(_, share, _)| *share < FOUND_AGAIN).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let share = 100.0 * share;
    Some((
        i,
        format!("found again in {share:.0} % of the repetitions {repetitions}: too few to add it"),
    ))
}

/// An addition that is not made, as something left.
fn left_over(context: &Context<'_>, added: &Added, shape: String) -> Remaining {
    Remaining { covariate: name_of(context, added), shape, p_value: added.p_value }
}

fn name_of(context: &Context<'_>, added: &Added) -> String {
    match &added.what {
        What::Effect(e) => {
            let effect = &context.model.declared().effects[*e];
            label(&effect.id, effect.subject.as_deref())
        }
        What::Empirical(covariate, _) => covariate.clone(),
    }
}
