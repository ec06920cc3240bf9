//! One bad point at a time: Baarda's data snooping.

use nalgebra::SVector;

use crate::{FrameFit, FrameFitError, Options, PointPair};

/// How sure data snooping has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SnoopingOptions {
    /// Probability that any of the good points is called bad; shared among the points by Šidák.
    pub family_significance: f64,
    /// Probability with which a bias of the detectable size is found.
    pub power: f64,
    /// Most points to set aside.
    pub max_removed: usize,
}

impl Default for SnoopingOptions {
    /// 5 % for the whole set, power 80 %, and as many removals as the redundancy allows.
    fn default() -> Self {
        Self { family_significance: 0.05, power: 0.8, max_removed: usize::MAX }
    }
}

/// How well one point is controlled by the others, and what they say of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reliability<const D: usize> {
    /// Share of a bias of each coordinate that shows in its residual: 0 is uncontrolled, 1 full.
    pub redundancy: SVector<f64, D>,
    /// Baarda's `w` of each coordinate, standard normal for a good point; 0 where uncontrolled.
    pub w: SVector<f64, D>,
    /// Smallest bias of each coordinate that is found with the chosen power; infinite where
    /// uncontrolled.
    pub detectable_mm: SVector<f64, D>,
    /// Best estimate of the bias of the point; `None` where the others do not determine it.
    pub bias_mm: Option<SVector<f64, D>>,
    /// Test statistic of the point as a whole; 0 where it is not testable.
    pub statistic: f64,
    /// Probability of such a statistic for a good point, before sharing among the points.
    pub p_value: f64,
}

/// A point that was set aside.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Suspect<const D: usize> {
    /// Position in the input slice.
    pub index: usize,
    /// Estimate of its bias, `target − T·source` with `T` from the points kept.
    pub bias_mm: SVector<f64, D>,
    /// Probability of such a statistic for a good point, before sharing among the points.
    pub p_value: f64,
}

/// Outcome of data snooping.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Snooping<const D: usize> {
    /// Points set aside, in the order found.
    pub suspects: Vec<Suspect<D>>,
    /// Positions of the points kept, in input order.
    pub kept: Vec<usize>,
    /// Reliability of each point kept, in the order of `kept`.
    pub reliability: Vec<Reliability<D>>,
    /// Critical probability of a single test in the last round.
    pub critical_p: f64,
    /// Fit to the points kept.
    pub fit: FrameFit<D>,
}

/// Sets aside, one at a time, the point that the others contradict most.
///
/// # Errors
///
/// As [`fit_frame`](crate::fit_frame).
pub fn snoop<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
    snooping: &SnoopingOptions,
) -> Result<Snooping<D>, FrameFitError> {
    todo!()
}

/// Reliability of every point of a fit, in input order.
///
/// # Errors
///
/// As [`fit_frame`](crate::fit_frame).
pub fn reliability<const D: usize>(
    pairs: &[PointPair<D>],
    fit: &FrameFit<D>,
    snooping: &SnoopingOptions,
) -> Result<Vec<Reliability<D>>, FrameFitError> {
    todo!()
}
