use crate::RobustRows;

/// How [`solve`](crate::solve) searches, when it stops, and what it may change.
///
/// No value panics. A tolerance that is negative or NaN never fires; a damping that is not
/// positive and finite counts as the default.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Options {
    /// Accepted steps per search before giving up.
    ///
    /// 1000: a well-posed fit takes under 20, the worst of the certified test problems 600, and
    /// the limit only guards against walking down an endless valley.
    pub max_iterations: usize,
    /// Stop when no column of the Jacobian correlates with the residual by more than this.
    ///
    /// 1e-12: the estimate is then within some 1e-11 of a standard uncertainty of the minimum.
    /// The last few digits cost one or two iterations, and a derivative taken through the
    /// estimate needs them.
    pub gradient_tolerance: f64,
    /// Stop when every component of the undamped step is below this share of the way that
    /// component has come.
    ///
    /// 1e-14: rounding of the point itself; it ends fits that leave no residual.
    pub step_tolerance: f64,
    /// Stop when the undamped step promises to lower the cost by less than this share.
    ///
    /// 1e-26: half the square of the gradient's 1e-12, rounded down, for strongly correlated
    /// parameters. Where rounding hides such changes of the cost, the gradient judges the steps.
    pub cost_tolerance: f64,
    /// Levenberg-Marquardt parameter of the first step, relative to unit columns.
    ///
    /// 1: the first step is about half of Gauss-Newton's, which keeps a bad start from being
    /// thrown across the parameter space and costs a good one two iterations. The test suites
    /// come out alike for 0.001 to 100.
    pub initial_damping: f64,
    /// Reciprocal condition number of the column-scaled Jacobian below which a direction is free.
    ///
    /// 1e-8: true freedoms show as 1e-15 with analytic derivatives and 1e-9 with differences.
    pub rank_tolerance: f64,
    /// Search again, in other ways, when the first search ends without a usable answer.
    ///
    /// On by default: it costs nothing where the first search succeeds.
    pub retry: bool,
    /// Tangent directions that stay at their start.
    pub held: Vec<usize>,
    /// Rows that count less the larger they are; all other rows count as their squares.
    pub robust: Vec<RobustRows>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 1000,
            gradient_tolerance: 1e-12,
            step_tolerance: 1e-14,
            cost_tolerance: 1e-26,
            initial_damping: 1.0,
            rank_tolerance: 1e-8,
            retry: true,
            held: Vec::new(),
            robust: Vec::new(),
        }
    }
}
