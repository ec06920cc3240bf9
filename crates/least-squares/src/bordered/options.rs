use crate::RobustRows;

/// How [`solve_bordered`](super::solve_bordered) searches, when it stops, and what it may change.
///
/// No value panics. A tolerance that is negative or NaN never fires; a damping that is negative
/// or not finite counts as nought.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BorderedOptions {
    /// Accepted steps before giving up.
    ///
    /// 100: a well-posed problem takes under 20.
    pub max_iterations: usize,
    /// Stop when the full step promises to lower the cost by less than this share of it, or when
    /// it lowered the cost as promised up to this share.
    ///
    /// 1e-10: with a million residuals the estimate is then within a hundredth of a standard
    /// uncertainty of the minimum, and one more step, which squares that, is still taken. Less
    /// would ask of the cost what the rounding of long ranges with short uncertainties hides.
    pub cost_tolerance: f64,
    /// Stop when the step is below this share of the way come, both in lengths of the Jacobian's
    /// columns.
    ///
    /// 1e-13: rounding of the point itself; it ends fits that leave no residual.
    pub step_tolerance: f64,
    /// Levenberg-Marquardt parameter of the first step, relative to unit columns.
    ///
    /// 1e-8: the first step is Gauss-Newton's in all directions that data determine well. A poor
    /// start costs one rejected step, after which damping grows fast.
    pub initial_damping: f64,
    /// Reciprocal condition number of the column-scaled Jacobian below which a direction is free.
    ///
    /// 1e-8, as in [`Options`](crate::Options::rank_tolerance).
    pub rank_tolerance: f64,
    /// Shared tangent directions that stay at their start.
    pub held_shared: Vec<usize>,
    /// Blocks that stay at their start.
    pub held_blocks: Vec<usize>,
    /// Rows of every block that count less the larger they are; all others count as their
    /// squares. Rows are those of the block's pattern, counted from 0.
    pub robust: Vec<RobustRows>,
}

impl Default for BorderedOptions {
    fn default() -> Self {
        Self {
            max_iterations: 100,
            cost_tolerance: 1e-10,
            step_tolerance: 1e-13,
            initial_damping: 1e-8,
            rank_tolerance: 1e-8,
            held_shared: Vec::new(),
            held_blocks: Vec::new(),
            robust: Vec::new(),
        }
    }
}
