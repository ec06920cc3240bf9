//! Candidates that are nothing but one reading far off, which may be the tail of the noise.

use nalgebra::DVector;

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::choice::candidate::Candidate;
use crate::levels::STAY;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test_of;
use crate::tests::tails::{beside, is_in_tails};

/// Whether any of `candidates` is a single reading as far off as noise with heavy tails puts one.
pub(crate) fn may_be_a_tail(lin: &Linear<'_>, base: &Basis, candidates: &[&Candidate]) -> bool {
    let single: Vec<usize> =
        candidates.iter().filter_map(|candidate| only_observation(lin, candidate)).collect();
    if single.is_empty() {
        return false;
    }
    let mut beside = base.clone();
    for candidate in candidates {
        beside = beside.with(&candidate.tangent, NEW_DIRECTION);
    }
    single.into_iter().any(|observation| is_in_tails(lin, &beside, observation))
}

/// The one observation that a candidate moves; `None` where it moves more.
fn only_observation(lin: &Linear<'_>, candidate: &Candidate) -> Option<usize> {
    candidate.home?;
    let moved = (0..lin.rows.len()).filter(|&i| candidate.tangent.row(i).iter().any(|v| *v != 0.0));
    let mut observations = moved.map(|i| lin.layout.rows[lin.rows[i]].observation);
    let first = observations.next()?;
    observations.all(|o| o == first).then_some(first)
}

/// Whether a candidate that moves many readings is nothing without one of them, and this one no
/// farther off than noise with heavy tails puts one: a beam that is said to have jumped at the last
/// angle, a smooth error that a single corner shows.
pub(crate) fn is_one_tail(
    lin: &Linear<'_>,
    base: &Basis,
    residual: &DVector<f64>,
    candidate: &Candidate,
) -> bool {
    let Some(observation) = carried_by(lin, base, residual, candidate) else { return false };
    let beside = base.with(&candidate.tangent, NEW_DIRECTION);
    is_in_tails(lin, &beside, observation)
}

/// The observation without which nothing is left of a candidate.
fn carried_by(
    lin: &Linear<'_>,
    base: &Basis,
    residual: &DVector<f64>,
    candidate: &Candidate,
) -> Option<usize> {
    let added = Basis::of(&candidate.beside, NEW_DIRECTION.sqrt());
    let explained = residual - added.reject(residual);
    let readings = lin.noise.all_readings(lin);
    let squares = (lin.noise.free_readings(lin).iter())
        .map(|(i, left)| (readings[*i].of(&explained).powi(2) / left, readings[*i].observation));
    let (_, observation) = squares.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let without = beside(lin, base, observation);
    let full = without.with(&candidate.beside, NEW_DIRECTION.sqrt());
    let test = f_test_of(
        full.explained_from(without.dim(), residual),
        full.dim() - without.dim(),
        without.reject(residual).norm_squared(),
        residual.len(),
        without.dim(),
    );
    test.is_none_or(|test| test.p_value > STAY).then_some(observation)
}
