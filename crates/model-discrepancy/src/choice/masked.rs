//! Two single readings that hide each other: each alone is small beside the other.

use crate::algebra::system::{Estimate, System};
use crate::choice::candidate::Estimability;
use crate::choice::one_observation::{LocalEstimability, full_candidate, local_effects};
use crate::choice::pair::judge_pair;
use crate::choice::score::{Scored, Scoring, screened};
use crate::count::count;
use crate::levels::{MASKED, MASKED_AMONG};

/// The pair of readings that is best explained as two mistakes, when its significance survives the
/// number of pairs there are.
pub(crate) fn find_masked(
    scoring: &Scoring<'_>,
    system: &System<'_>,
    at: &Estimate,
) -> Option<[Scored; 2]> {
    let lin = scoring.lin;
    let seen: Vec<usize> = local_effects(system, at, lin)
        .filter(|(_, sight)| matches!(sight, LocalEstimability::Estimable(_)))
        .map(|(effect, _)| effect)
        .filter(|effect| !scoring.banned.contains(effect))
        .take(MASKED_AMONG.end() + 1)
        .collect();
    if !MASKED_AMONG.contains(&seen.len()) {
        return None;
    }
    let scored: Vec<Scored> = (seen.into_iter())
        .filter_map(|effect| match full_candidate(system, at, lin, effect) {
            Estimability::Estimable(candidate) => {
                screened(scoring, (&lin.basis, &scoring.clean), *candidate, 0, f64::INFINITY)
            }
            Estimability::NotEstimable(_) => None,
        })
        .collect();
    let n = count(scored.len());
    let level = MASKED / (0.5 * n * (n - 1.0));
    let mut best: Option<([Scored; 2], f64)> = None;
    for (i, a) in scored.iter().enumerate() {
        for b in scored[i + 1..].iter().filter(|b| b.candidate.id == a.candidate.id) {
            let Some((pair, criterion)) = judge_pair(scoring, a, b, level) else { continue };
            if best.as_ref().is_none_or(|(_, least)| criterion < *least) {
                best = Some((pair, criterion));
            }
        }
    }
    best.map(|(pair, _)| pair)
}
