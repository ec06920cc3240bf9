use crate::RobustRows;

/// How [`solve`](crate::solve) searches, when it stops, and what it may change.
///
/// No value panics: a tolerance that is negative or NaN never fires.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Steps accepted before giving up.
    pub max_iterations: usize,
    /// Stop when no column of the Jacobian correlates with the residual by more than this.
    pub gradient_tolerance: f64,
    /// Stop when a full step is shorter than this share of the way travelled.
    pub step_tolerance: f64,
    /// Stop when a full step promises to reduce the cost by less than this share of it.
    pub cost_tolerance: f64,
    /// Marquardt parameter of the first step, relative to unit columns.
    pub initial_damping: f64,
    /// Reciprocal condition number of the column-scaled Jacobian below which a direction is free.
    pub rank_tolerance: f64,
    /// Tangent directions that stay at their start.
    pub held: Vec<usize>,
    /// Rows that count less the larger they are; all other rows count as their squares.
    pub robust: Vec<RobustRows>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 1000,
            gradient_tolerance: 1e-13,
            step_tolerance: 1e-14,
            cost_tolerance: 1e-28,
            initial_damping: 1e-3,
            rank_tolerance: 1e-13,
            held: Vec::new(),
            robust: Vec::new(),
        }
    }
}
