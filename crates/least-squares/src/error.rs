use std::fmt;

use nalgebra::DVector;

use crate::{FreeDirection, Report};

/// Why there is no estimate to rely on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError<Point = DVector<f64>> {
    /// The start is no point of the problem, by [`Problem::is_point`](crate::Problem::is_point) or
    /// [`BorderedProblem::is_point`](crate::BorderedProblem::is_point).
    #[error("the start is no point of the problem: check how many numbers it has")]
    InvalidStart,
    /// A residual is infinite or NaN where the search starts.
    #[error("residual {} is {value} at the start: check the data and the start values", row + 1)]
    NonFiniteResidual {
        /// Row of the residual.
        row: usize,
        /// Its value.
        value: f64,
    },
    /// A derivative is infinite or NaN at a point whose residuals are finite.
    #[error("derivative of residual {} by direction {} is {value}", row + 1, column + 1)]
    NonFiniteJacobian {
        /// Row of the Jacobian.
        row: usize,
        /// Column of the Jacobian.
        column: usize,
        /// Its value.
        value: f64,
    },
    /// A residual of a block is infinite or NaN where the search starts.
    #[error(
        "residual {} of block {} is {value} at the start: check the data and the start values",
        row + 1, block + 1
    )]
    NonFiniteBlockResidual {
        /// The block.
        block: usize,
        /// Row of its pattern.
        row: usize,
        /// Its value.
        value: f64,
    },
    /// A derivative of a block's residual is infinite or NaN, at finite residuals.
    #[error("a derivative of residual {} of block {} is {value}", row + 1, block + 1)]
    NonFiniteBlockJacobian {
        /// The block.
        block: usize,
        /// Row of its pattern.
        row: usize,
        /// Its value.
        value: f64,
    },
    /// A pattern lists a direction that does not exist or is listed twice, or is missing.
    #[error(
        "row {} of pattern {} lists direction {direction} (counted from 0), which does not exist \
         or is listed twice, or a block refers to this pattern and it is missing",
        row + 1, pattern + 1
    )]
    InvalidPattern {
        /// Index of the pattern.
        pattern: usize,
        /// Row of the pattern.
        row: usize,
        /// The direction listed.
        direction: usize,
    },
    /// The numbers of the blocks' points cannot be shared out among the blocks.
    #[error("{numbers} numbers cannot be the points of {blocks} blocks of one length")]
    InvalidBlocks {
        /// Numbers given.
        numbers: usize,
        /// Number of blocks.
        blocks: usize,
    },
    /// A held block does not exist.
    #[error("there is no block {block}: the problem has {block_count}, counted from 0")]
    BlockOutOfRange {
        /// The index given.
        block: usize,
        /// Number of blocks of the problem.
        block_count: usize,
    },
    /// A held direction, or one with a prior, does not exist.
    #[error("there is no direction {index}: the problem has {tangent_dim}, counted from 0")]
    DirectionOutOfRange {
        /// The index given.
        index: usize,
        /// Number of tangent directions of the problem.
        tangent_dim: usize,
    },
    /// The scale of a robust loss is not positive and finite, or its blocks have no rows.
    #[error(
        "robust loss {} needs a positive scale and block_rows, got {scale} and {block_rows}",
        index + 1
    )]
    InvalidLoss {
        /// Position in [`Options::robust`](crate::Options::robust).
        index: usize,
        /// The scale given.
        scale: f64,
        /// The block size given.
        block_rows: usize,
    },
    /// A standard uncertainty of a prior is not positive, or its covariance not positive definite.
    #[error(
        "prior needs a positive finite standard uncertainty in row {}, got variance {variance}",
        row + 1
    )]
    InvalidPrior {
        /// Row of the prior.
        row: usize,
        /// Variance left for it once the rows before are known.
        variance: f64,
    },
    /// The search stopped before it met a tolerance.
    #[error(
        "not converged: cost {:.6e} after {} iterations; start closer or allow more iterations",
        report.final_cost, report.iterations
    )]
    NotConverged {
        /// The best point found.
        best: Box<Point>,
        /// How far the search came.
        report: Box<Report>,
    },
    /// No step lowers the cost although the Jacobian promises it.
    #[error(
        "stalled at cost {:.6e} with a gradient correlation of {:.1e}: the residuals do not \
         follow their Jacobian; compare them with check_jacobian",
        report.final_cost, report.gradient
    )]
    Stalled {
        /// The best point found.
        best: Box<Point>,
        /// How far the search came.
        report: Box<Report>,
    },
    /// The data leave a direction free: adding it changes no residual.
    #[error(
        "the data leave {} of {} directions free: {}; hold one, add a prior, or measure what \
         depends on it",
        directions.len(), report.parameters, Listed(directions)
    )]
    Unobservable {
        /// One per free direction.
        directions: Vec<FreeDirection>,
        /// One of many points with this cost.
        best: Box<Point>,
        /// How the search went.
        report: Box<Report>,
    },
}

struct Listed<'a>(&'a [FreeDirection]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, direction) in self.0.iter().enumerate() {
            write!(f, "{}{direction}", if i == 0 { "" } else { " and " })?;
        }
        Ok(())
    }
}
