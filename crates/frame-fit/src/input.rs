//! Validation of what the user gives, once and before anything else.

use crate::decompose::dynamic;
use crate::{FrameFitError, InvalidPair, PointPair, Transform, Uncertainty};

/// What a case file may hold. Coordinates about the centre of the Earth are below, the ground at
/// 6e9 mm and satellites at 4e10 mm; a double resolves 1 nm in the former and 0.1 µm at the limit.
pub(crate) const LARGEST_COORDINATE_MM: f64 = 1e12;
/// A hundred thousandth of an atom.
const SMALLEST_SIGMA_MM: f64 = 1e-12;
/// Larger than the largest coordinate it could be about.
const LARGEST_SIGMA_MM: f64 = 1e12;
/// Asymmetry of a covariance that rounding in a file may cause, relative to its largest entry.
const ASYMMETRY_TOL: f64 = 1e-6;

pub(crate) fn check_pairs<const D: usize>(pairs: &[PointPair<D>]) -> Result<(), FrameFitError> {
    for (index, pair) in pairs.iter().enumerate() {
        check_pair(pair).map_err(|reason| FrameFitError::InvalidPair { index, reason })?;
    }
    Ok(())
}

pub(crate) fn check_count(
    transform: Transform,
    dimension: usize,
    got: usize,
) -> Result<(), FrameFitError> {
    // Nothing is estimated by `None`, but nothing can be judged on no point at all either.
    let needed = transform.minimum_points(dimension).max(1);
    if got < needed {
        return Err(FrameFitError::TooFewPoints { transform, needed, got });
    }
    Ok(())
}

fn check_pair<const D: usize>(pair: &PointPair<D>) -> Result<(), InvalidPair> {
    for &value in pair.target_mm.iter().chain(pair.source_mm.iter()) {
        if !value.is_finite() || value.abs() > LARGEST_COORDINATE_MM {
            return Err(InvalidPair::Coordinate { value, limit: LARGEST_COORDINATE_MM });
        }
    }
    for &sigma_mm in &pair.uncertainty.sigma_mm() {
        // Written so that NaN fails.
        if !(SMALLEST_SIGMA_MM..=LARGEST_SIGMA_MM).contains(&sigma_mm) {
            return Err(InvalidPair::Sigma {
                sigma_mm,
                smallest: SMALLEST_SIGMA_MM,
                largest: LARGEST_SIGMA_MM,
            });
        }
    }
    check_covariance(&pair.uncertainty)
}

fn check_covariance<const D: usize>(uncertainty: &Uncertainty<D>) -> Result<(), InvalidPair> {
    let Uncertainty::Full { covariance_mm2 } = uncertainty else { return Ok(()) };
    if covariance_mm2.iter().any(|v| !v.is_finite()) {
        return Err(InvalidPair::NotPositiveDefinite);
    }
    let covariance = dynamic(covariance_mm2);
    let asymmetry_mm2 = (&covariance - covariance.transpose()).amax();
    if asymmetry_mm2 > ASYMMETRY_TOL * covariance.amax() {
        return Err(InvalidPair::Asymmetric { asymmetry_mm2 });
    }
    if uncertainty.whitening_per_mm().is_none() {
        return Err(InvalidPair::NotPositiveDefinite);
    }
    Ok(())
}
