//! How large an effect must be for the whole choice to name it, by simulation.

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::system::{Estimate, System};
use crate::answer::confounded::is_rival;
use crate::choice::candidate::Candidate;
use crate::choice::context::Context;
use crate::choice::detectable::noncentrality;
use crate::choice::score::{Candidates, Scored, Scoring, criterion};
use crate::choice::select::{eligible, prefer_simpler};
use crate::count::count;
use crate::levels::{POWER, TIE};
use crate::model::moved::evenly;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test;
use crate::tests::significance::{Reach, holds_in_readings};

/// Simulated data sets for each effect.
const DATA_SETS: usize = 40;
/// The size in one of them is looked for between these factors of the F test's own; below the second
/// it mostly is.
const FACTORS: [f64; 3] = [0.7, 1.4, 5.6];
/// Ratio of two factors that are not told apart any more.
const CLOSE: f64 = 1.1;
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
        let normal = Normal::standard();
        // Half a step from either end, which no normal number reaches.
        let one = |i: usize| sigma * normal.inverse_cdf(evenly(i).clamp(1e-9, 1.0 - 1e-9));
        let set = |k: usize| lin.basis.reject(&DVector::from_fn(n, |i, _| one(k * n + i)));
        Self { context, system, at, lin, alpha, sigma, noise: (0..DATA_SETS).map(set).collect() }
    }

    /// For the candidate at a place in the list: factor from the size that an F test at the level `alpha` finds nine times in ten to the one
    /// that is named as often; each data set has one amplitude alone.
    pub(crate) fn factor(&self, candidates: &Candidates, index: usize, alpha: f64) -> f64 {
        let span = |c: &Candidate| Basis::of(&c.beside, NEW_DIRECTION.sqrt());
        let among = Among { candidates, spans: candidates.all.iter().map(span).collect() };
        let of = &candidates.all[index];
        let amplitudes = of.beside.ncols();
        let dof = self.lin.rows.len().saturating_sub(self.lin.basis.dim() + amplitudes).max(1);
        let length = self.sigma * noncentrality(alpha / of.searched, amplitudes, dof).sqrt();
        let least = |k: usize| {
            let signal = of.beside.column(k % amplitudes).normalize() * length;
            let is_named =
                |factor: f64| self.is_named(&among, index, &self.noise[k] + factor * &signal);
            let [least, mostly, most] = FACTORS;
            let (mut low, mut high) =
                if is_named(mostly) { (least, mostly) } else { (mostly, most) };
            while high > CLOSE * low {
                let middle = (low * high).sqrt();
                if is_named(middle) { high = middle } else { low = middle }
            }
            (low * high).sqrt()
        };
        let mut all: Vec<f64> = (0..DATA_SETS).map(least).collect();
        all.sort_by(f64::total_cmp);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of a count"
        )]
        let at = (POWER / NOTHING_ELSE * count(DATA_SETS)) as usize;
        // The mean of the three about it scatters less than the one.
        all[at - 2..=at].iter().sum::<f64>() / 3.0
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
                    let comes_before = criterion(lin.rows.len(), &t) <= worst;
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
