use least_squares::Loss;

use crate::{Handedness, Transform};

/// What to fit.
///
/// The default is a proper rigid transform by plain least squares under declared noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Options {
    /// Family of transforms.
    pub transform: Transform,
    /// Whether a rigid or similarity transform may mirror; the other families ignore it.
    pub handedness: Handedness,
    /// What the uncertainties of the pairs mean.
    pub noise: Noise,
    /// Loss on the whitened length of a point's residual; `None` for plain squares.
    ///
    /// A loss in `Some` needs no clean start: the search goes through Huber's convex loss first.
    pub loss: Option<Loss>,
}

impl Options {
    /// The default for another family.
    #[must_use]
    pub fn of(transform: Transform) -> Self {
        Self { transform, ..Self::default() }
    }
}

/// What the uncertainties of the pairs mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Noise {
    /// They are known: uncertainties of the result are a priori, intervals normal.
    #[default]
    Declared,
    /// They only weigh points against each other: uncertainties of the result are a posteriori,
    /// intervals those of Student.
    Estimated,
}
