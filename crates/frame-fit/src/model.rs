//! The declared model, as the loop sees it.

use model_discrepancy::{Covariate, Role};

use crate::{FrameFitError, FrameMap, Options, PointPair};

/// One measured point with its place in the loop.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredPoint<const D: usize> {
    /// The user's name for it.
    pub name: String,
    /// Points of one group are left out together; the point's own name, by default.
    pub group: String,
    /// Fitted or only judged.
    pub role: Role,
    /// The two positions and their uncertainty.
    pub pair: PointPair<D>,
}

impl<const D: usize> MeasuredPoint<D> {
    /// A fitted point that is a group of its own.
    #[must_use]
    pub fn new(name: impl Into<String>, pair: PointPair<D>) -> Self {
        let name = name.into();
        Self { group: name.clone(), name, role: Role::Fit, pair }
    }
}

/// `target − T(source)` over named points, and the effects that `T` leaves out.
///
/// Implements [`model_discrepancy::Model`].
#[derive(Clone, Debug)]
pub struct FrameModel<const D: usize> {
    points: Vec<MeasuredPoint<D>>,
}

impl<const D: usize> FrameModel<D> {
    /// Model of `points`, in the order measured.
    ///
    /// `covariates` are the columns recorded beside the points, one value per point: `time_s`
    /// drives the drift, every column ending in `_c` a thermal expansion. The loss of `options`
    /// serves only to find the start.
    ///
    /// # Errors
    ///
    /// As [`fit_frame`](crate::fit_frame) on the points to be fitted, and
    /// [`FrameFitError::InvalidCovariate`].
    pub fn new(
        points: Vec<MeasuredPoint<D>>,
        covariates: &[Covariate],
        options: &Options,
    ) -> Result<Self, FrameFitError> {
        todo!()
    }

    /// The positions at which the points were measured, as covariates: `from_x_mm`, ….
    #[must_use]
    pub fn coordinates(&self) -> Vec<Covariate> {
        todo!()
    }

    /// The transform at base parameters of a [`model_discrepancy::State`].
    #[must_use]
    pub fn map_at(&self, base: &nalgebra::DVector<f64>) -> FrameMap<D> {
        todo!()
    }
}
