//! Which family do the data need?

use crate::problem::FitProblem;
use crate::statistics::{chi2_tail, f_tail, ratio};
use crate::{FrameFit, FrameFitError, Noise, Options, PointPair, Transform, fit_frame, input};

/// F-test of one family of transforms against the next larger one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NestedTest {
    /// The smaller family: the null hypothesis.
    pub smaller: Transform,
    /// The larger family.
    pub larger: Transform,
    /// Drop of the weighted sum of squares per added parameter, over what is left per degree of
    /// freedom.
    pub f_statistic: f64,
    /// Parameters added.
    pub numerator_dof: usize,
    /// Degrees of freedom of the larger family.
    pub denominator_dof: usize,
    /// Probability of such a drop when the smaller family is right.
    pub p_value: f64,
    /// The same from the drop alone, with the noise as declared (χ²); `None` where the noise is
    /// estimated.
    pub declared_p_value: Option<f64>,
    /// Root-mean-square distance left by the smaller family.
    pub smaller_rms_mm: f64,
    /// Root-mean-square distance left by the larger family.
    pub larger_rms_mm: f64,
}

/// Tests each family against the next: none ⊂ translation ⊂ rigid ⊂ similarity ⊂ affine.
///
/// Plain least squares whatever `options.loss` says; `options.transform` is ignored. A pair is
/// left out where the points do not determine the larger family or leave it no redundancy.
///
/// # Errors
///
/// [`FrameFitError::InvalidPair`] and [`FrameFitError::TooFewPoints`].
pub fn compare_transforms<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
) -> Result<Vec<NestedTest>, FrameFitError> {
    input::check_pairs(pairs)?;
    input::check_count(Transform::None, D, pairs.len())?;
    let fits: Vec<FrameFit<D>> = Transform::ALL
        .into_iter()
        .map_while(|transform| {
            fit_frame(pairs, &Options { transform, loss: None, ..*options }).ok()
        })
        .collect();
    Ok(fits.windows(2).filter_map(|nested| test(pairs, &nested[0], &nested[1])).collect())
}

fn test<const D: usize>(
    pairs: &[PointPair<D>],
    smaller: &FrameFit<D>,
    larger: &FrameFit<D>,
) -> Option<NestedTest> {
    let denominator_dof = larger.degrees_of_freedom;
    let variance_factor = larger.variance_factor?;
    let numerator_dof = smaller.degrees_of_freedom - denominator_dof;
    // What rounding leaves of an exact fit is no measure of noise.
    let map = &larger.target_from_source;
    let round_off = FitProblem::new(pairs, larger.transform, map).round_off_chi2;
    let left = (variance_factor * ratio(denominator_dof)).max(round_off);
    let before = smaller.variance_factor? * ratio(smaller.degrees_of_freedom);
    let drop = (before - left).max(0.0);
    let f_statistic = (drop / ratio(numerator_dof)) / (left / ratio(denominator_dof));
    Some(NestedTest {
        smaller: smaller.transform,
        larger: larger.transform,
        f_statistic,
        numerator_dof,
        denominator_dof,
        p_value: f_tail(f_statistic, numerator_dof, denominator_dof),
        declared_p_value: (larger.noise == Noise::Declared).then(|| chi2_tail(drop, numerator_dof)),
        smaller_rms_mm: smaller.rms_mm(),
        larger_rms_mm: larger.rms_mm(),
    })
}
