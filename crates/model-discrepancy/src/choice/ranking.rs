//! Which of the candidates that are significant goes first.

use std::cmp::Ordering;

use crate::algebra::basis::NEW_DIRECTION;
use crate::choice::score::{Scored, Scoring};
use crate::count::count;
use crate::levels::{PLACE_F, PLACE_SHARE, STAY, TIE};
use crate::noise::linear::Linear;
use crate::tests::significance::{Reach, significance};

/// Which candidates have all tests behind them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Confirmed {
    /// As many as decide which goes first.
    First,
    /// All that the F test finds significant.
    All,
}

/// [`eligible`] of those that are confirmed, as [`prefer_simpler`] has them; confirms them.
pub(crate) fn ranked(
    scoring: &Scoring<'_>,
    judged: &mut [Scored],
    confirmed: Confirmed,
) -> Vec<usize> {
    let significant = |j: &Scored| j.adjusted <= scoring.alpha;
    let mut screened: Vec<usize> = (0..judged.len()).filter(|&i| significant(&judged[i])).collect();
    screened.sort_by(|&a, &b| before(&judged[a], &judged[b]));
    let mut best: Option<usize> = None;
    for &i in &screened {
        let is_behind = best.is_some_and(|best| !is_tied(&judged[i], &judged[best]));
        if is_behind && confirmed == Confirmed::First {
            break;
        }
        judged[i].confirm(scoring);
        if is_eligible(&judged[i], scoring.alpha) {
            best = best.or(Some(i));
        }
    }
    if let Some(&first) = eligible(judged, scoring.alpha).first() {
        for i in screened {
            if may_take_the_place(&judged[i], &judged[first]) {
                judged[i].confirm(scoring);
            }
        }
    }
    let mut order = eligible(judged, scoring.alpha);
    prefer_simpler(scoring.lin, judged, &mut order);
    order
}

/// What shows in many groups goes before what lives in one, then the better description.
fn before(a: &Scored, b: &Scored) -> Ordering {
    let is_local = |j: &Scored| j.candidate.reach == Reach::One;
    is_local(a).cmp(&is_local(b)).then(a.criterion.total_cmp(&b.criterion))
}

/// Whether one is no worse a description than the best by more than the data's last digit makes.
fn is_tied(one: &Scored, best: &Scored) -> bool {
    one.candidate.reach == best.candidate.reach && one.criterion - best.criterion <= TIE
}

/// Significant candidates that generalise, the best description of the data first.
///
/// What shows in many groups goes before what lives in one: a few extreme points describe a
/// smooth effect well, the other way round is refused by the scatter between groups.
pub(crate) fn eligible(judged: &[Scored], alpha: f64) -> Vec<usize> {
    let mut order: Vec<_> = (0..judged.len()).filter(|&i| is_eligible(&judged[i], alpha)).collect();
    order.sort_by(|&a, &b| before(&judged[a], &judged[b]));
    // A tie goes by the order of the catalogue, not by the last digit of the data.
    let Some(&best) = order.first() else { return order };
    let tied = order.iter().take_while(|&&i| is_tied(&judged[i], &judged[best])).count();
    order[..tied].sort_unstable();
    order
}

/// Whether one with all tests behind it is significant and generalises.
pub(crate) fn is_eligible(judged: &Scored, alpha: f64) -> bool {
    judged.adjusted <= alpha && judged.generalises()
}

/// Whether the best may add nothing beside a candidate with fewer amplitudes. Beside one that explains
/// less than a share of what the best does the rest of that is left, and the best, which has every test
/// behind it at a far smaller level, is needed; so it is where the difference of the two is far beyond
/// what any test could doubt.
fn may_take_the_place(simpler: &Scored, best: &Scored) -> bool {
    let (less, all) = (&simpler.test, &best.test);
    let more = (all.explained - less.explained) / count(all.directions) / all.variance;
    simpler.candidate.reach == Reach::Many
        && less.directions < all.directions
        && less.explained >= PLACE_SHARE * all.explained
        && more < PLACE_F
}

/// Moves a candidate with fewer amplitudes to the front when the best adds nothing to it.
pub(crate) fn prefer_simpler(lin: &Linear<'_>, judged: &[Scored], order: &mut [usize]) {
    let Some(&best) = order.first() else { return };
    let mut simpler: Vec<usize> = (1..order.len())
        .filter(|&at| may_take_the_place(&judged[order[at]], &judged[best]))
        .collect();
    simpler.sort_by_key(|&at| judged[order[at]].test.directions);
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
