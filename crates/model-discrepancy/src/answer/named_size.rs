//! How large an effect must be for the whole choice to name it, by simulation.

use nalgebra::DVector;

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::system::{Estimate, System};
use crate::answer::confounded::is_rival;
use crate::choice::candidate::Candidate;
use crate::choice::context::Context;
use crate::choice::detectable::noncentrality;
use crate::choice::ranking::{eligible, prefer_simpler};
use crate::choice::score::{Candidates, Scored, Scoring, criterion};
use crate::count::count;
use crate::levels::{POWER, TIE};
use crate::model::moved::normally;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test;
use crate::tests::significance::{Reach, holds_in_readings};

/// Simulated data sets for each effect.
const DATA_SETS: usize = 40;
/// Ratio of the sizes that are tried, the first of which is what the F test alone finds; and where
/// that is far from enough.
const NEXT: f64 = 1.1;
const FAR: f64 = 1.5;
/// The largest factor that is tried.
const MOST: f64 = 8.0;
/// Share of the answers with the right name that have no other beside it: what is added later counts
/// against the whole answer.
const NOTHING_ELSE: f64 = 0.95;

/// White noise of the level found, in the rows of a design.
pub(crate) struct Simulation<'a> {
    pub(crate) context: &'a Context<'a>,
    pub(crate) system: &'a System<'a>,
    pub(crate) at: &'a Estimate,
    pub(crate) lin: &'a Linear<'a>,
    pub(crate) alpha: f64,
    /// Standard deviation in units of what was declared.
    sigma: f64,
    noise: Vec<DVector<f64>>,
}

impl<'a> Simulation<'a> {
    pub(crate) fn new(
        context: &'a Context<'a>,
        (system, at): (&'a System<'a>, &'a Estimate),
        lin: &'a Linear<'a>,
        alpha: f64,
    ) -> Self {
        let n = lin.rows.len();
        let dof = n.saturating_sub(lin.basis.dim()).max(1);
        let sigma = (lin.clean_residual().norm_squared() / count(dof)).sqrt();
        let noise = |k: usize| DVector::from_fn(n, |i, _| sigma * normally(k * n + i));
        let set = |k: usize| lin.basis.reject(&noise(k));
        Self { context, system, at, lin, alpha, sigma, noise: (0..DATA_SETS).map(set).collect() }
    }

    /// For the candidate at a place in the list: factor from the size that an F test at the level
    /// `alpha` finds nine times in ten to the one that is named as often; each data set has one
    /// amplitude alone.
    pub(crate) fn factor(&self, candidates: &Candidates, index: usize, alpha: f64) -> f64 {
        let span = |c: &Candidate| Basis::of(&c.beside, NEW_DIRECTION.sqrt());
        let among = Among { candidates, spans: candidates.all.iter().map(span).collect() };
        let of = &candidates.all[index];
        let amplitudes = of.beside.ncols();
        let dof = self.lin.rows.len().saturating_sub(self.lin.basis.dim() + amplitudes).max(1);
        let length = self.sigma * noncentrality(alpha / of.searched, amplitudes, dof).sqrt();
        let mut left: Vec<usize> = (0..DATA_SETS).collect();
        let (mut before, mut factor) = (1.0_f64, 1.0);
        loop {
            left.retain(|&k| {
                let signal = of.beside.column(k % amplitudes).normalize() * (length * factor);
                !self.is_named(&among, index, &self.noise[k] + signal)
            });
            let missed = count(left.len()) / count(DATA_SETS);
            if missed <= 1.0 - POWER / NOTHING_ELSE || factor > MOST {
                return (before * factor).sqrt();
            }
            before = factor;
            factor *= if factor < FAR { NEXT } else { FAR };
        }
    }

    /// Whether the first choice is the candidate at a place in the list, or one of which it is a rival.
    fn is_named(&self, among: &Among<'_>, of: usize, residual: DVector<f64>) -> bool {
        let lin = self.lin.with_residual(residual);
        let scoring = Scoring::new(self.context, self.system, self.at, &lin, self.alpha);
        let Some(own) = among.candidates.judged(&scoring, of) else { return false };
        if own.adjusted > self.alpha || !own.generalises() {
            return false;
        }
        let (reach, directions, worst) =
            (own.candidate.reach, own.test.directions, own.criterion + TIE);
        // Those that may come before it: better ones, and simpler ones.
        let may_be = |&i: &usize| {
            let candidate = &among.candidates.all[i];
            let trials = candidate.searched * among.candidates.trials_of(candidate);
            let wider = candidate.reach == Reach::Many || reach == Reach::One;
            let test = f_test(&scoring.clean, lin.basis.dim(), &among.spans[i]).filter(|_| wider);
            i != of
                && test.is_some_and(|t| {
                    let comes_before = criterion(lin.rows.len(), &t, candidate.searched) <= worst;
                    t.p_value * trials <= self.alpha && (comes_before || t.directions < directions)
                })
        };
        let others = (0..among.candidates.all.len()).filter(may_be);
        let judged: Vec<Scored> = std::iter::once(own)
            .chain(others.filter_map(|i| among.candidates.judged(&scoring, i)))
            .collect();
        let mut order = eligible(&judged, self.alpha);
        prefer_simpler(&lin, &judged, &mut order);
        let holds = |j: &Scored| {
            holds_in_readings(&lin, &scoring.clean, &j.candidate.beside, &j.test, j.asked)
        };
        let Some(first) = order.into_iter().find(|&i| holds(&judged[i])) else { return false };
        first == 0 || is_rival(&lin, &judged[first].candidate, &judged[0].candidate, &scoring.skip)
    }
}

/// What competes, and its span in whitened rows beside the declared model.
struct Among<'a> {
    candidates: &'a Candidates,
    spans: Vec<Basis>,
}
