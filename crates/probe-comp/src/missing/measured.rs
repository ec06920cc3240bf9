use model_discrepancy::Role;

use crate::BallTouch;

/// A touch as the loop needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredTouch {
    /// Name as the user knows it.
    pub name: String,
    /// Touches of one group are left out together.
    pub group: String,
    /// Whether it is fitted, or only judged.
    pub role: Role,
    /// What was measured.
    pub touch: BallTouch,
}
