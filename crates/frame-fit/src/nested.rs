//! Which family do the data need?

use crate::{FrameFitError, Options, PointPair, Transform};

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
    todo!()
}
