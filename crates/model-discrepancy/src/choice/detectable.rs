//! How large an effect must be to be found.

use crate::levels::POWER;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::algebra::basis::Basis;
use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::f_tail::f_tail;
use crate::choice::candidate::Candidate;
use crate::choice::one_observation::LocalTest;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::tests::f_test::Significance;

/// Non-centrality `|G⊥a|²/s²` at which an F test of size `alpha` has the power 0.9.
///
/// By Patnaik's (1949) approximation of the non-central F law, good to a few per cent.
pub(crate) fn noncentrality(alpha: f64, directions: usize, dof: usize) -> f64 {
    let (m, v) = (count(directions), count(dof));
    let Ok(central) = FisherSnedecor::new(m, v) else { return f64::INFINITY };
    let critical = central.inverse_cdf((1.0 - alpha).clamp(0.0, 1.0 - 1e-12));
    let power = |lambda: f64| {
        let shape = (m + lambda).powi(2) / (m + 2.0 * lambda);
        f_tail(critical * m / (m + lambda), shape, v)
    };
    let (mut low, mut high) = (0.0, 1.0);
    while power(high) < POWER {
        low = high;
        high *= 2.0;
        if high > 1e12 {
            return f64::INFINITY;
        }
    }
    // Sixty halvings reach round-off.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if power(middle) < POWER { low = middle } else { high = middle }
    }
    high
}

/// Rms over the observations, in report units, of an effect that would be found nine times in
/// ten at the noise of `test`; mean over the directions of its tangent.
pub(crate) fn detectable_rms(
    lin: &Linear<'_>,
    test: &Significance,
    candidate: &Candidate,
    alpha: f64,
) -> f64 {
    let lambda = noncentrality(alpha / candidate.searched, test.directions, test.dof);
    let directions = Basis::of(&candidate.tangent, NEW_DIRECTION).matrix();
    let seen = (1.0 - candidate.absorbed(&lin.basis)).max(f64::MIN_POSITIVE);
    // A unit direction leaves √seen beside the model, so the whole must be 1/√seen longer.
    let length = (lambda * test.variance / seen).sqrt();
    length * unwhitened_rms(lin, &directions)
}

/// Rms per observation, in report units, of a random unit combination of `directions`.
fn unwhitened_rms(lin: &Linear<'_>, directions: &DMatrix<f64>) -> f64 {
    let mut sum = 0.0;
    for (i, &row) in lin.rows.iter().enumerate() {
        let row = lin.layout.rows[row];
        if row.reported {
            sum += directions.row(i).norm_squared() * lin.sigma[i] * lin.sigma[i];
        }
    }
    let observations = reported_observations(lin).max(1);
    (sum / count(directions.ncols().max(1)) / count(observations)).sqrt()
}

/// [`detectable_rms`] of an effect that moves one observation of so many that are reported.
pub(crate) fn local_detectable_rms(local: &LocalTest, lambda: f64, observations: usize) -> f64 {
    let seen = (1.0 - local.absorbed).max(f64::MIN_POSITIVE);
    let length = (lambda * local.test.variance / seen).sqrt();
    length * (local.reported / count(observations.max(1))).sqrt()
}

/// Amplitude of each parameter alone, in internal units, at which the effect would be found nine
/// times in ten.
pub(crate) fn local_detectable_amplitudes(local: &LocalTest, lambda: f64) -> Vec<f64> {
    local.kept.iter().map(|kept| (lambda * local.test.variance).sqrt() / kept).collect()
}

/// Observations of which any row is reported.
pub(crate) fn reported_observations(lin: &Linear<'_>) -> usize {
    let mut reported = vec![false; lin.layout.observations.len()];
    for row in lin.rows.iter().map(|&row| lin.layout.rows[row]).filter(|row| row.reported) {
        reported[row.observation] = true;
    }
    reported.into_iter().filter(|&r| r).count()
}

/// Amplitude of each parameter alone, in internal units, at which the candidate would be found
/// nine times in ten.
pub(crate) fn detectable_amplitudes(
    lin: &Linear<'_>,
    test: &Significance,
    candidate: &Candidate,
    alpha: f64,
) -> DVector<f64> {
    let lambda = noncentrality(alpha / candidate.searched, test.directions, test.dof);
    let seen = lin.basis.reject_columns(&candidate.tangent);
    DVector::from_iterator(
        seen.ncols(),
        seen.column_iter().map(|c| (lambda * test.variance).sqrt() / c.norm()),
    )
}
