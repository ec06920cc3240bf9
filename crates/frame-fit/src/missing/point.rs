//! A measured point with its place in the loop.

use model_discrepancy::Role;

use crate::PointPair;

/// One measured point with its place in the loop.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredPoint<const D: usize> {
    /// The user's name for it.
    pub name: String,
    /// Points of one group are left out together; the point's own name, by default.
    ///
    /// Points of one name but different roles form two groups.
    pub group: String,
    /// Fitted or only judged.
    pub role: Role,
    /// The rigid sub-assembly that carries the point, where the points sit on several.
    pub body: Option<String>,
    /// The two positions and their uncertainty.
    pub pair: PointPair<D>,
}

impl<const D: usize> MeasuredPoint<D> {
    /// A fitted point that is a group of its own, on the one body there is.
    #[must_use]
    pub fn new(name: impl Into<String>, pair: PointPair<D>) -> Self {
        let name = name.into();
        Self { group: name.clone(), name, role: Role::Fit, body: None, pair }
    }
}
