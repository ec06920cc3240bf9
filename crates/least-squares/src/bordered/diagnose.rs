//! Where a number is not finite.

use super::block::{Place, Rows};
use super::{BlockRows, BorderedPoint, BorderedProblem};
use crate::SolveError;

/// The first residual, then the first derivative, that is infinite or NaN.
pub(super) fn all_finite<P: BorderedProblem>(
    place: Place<'_, P>,
) -> Result<(), SolveError<BorderedPoint>> {
    let Place { problem, program, point, .. } = place;
    let mut rows = Rows::new(program.limits);
    for block in 0..program.block_count {
        let compiled = program.compiled(block);
        rows.evaluate(place, compiled, block);
        let BlockRows { residuals, by_block, by_shared } = rows.split(compiled.limits);
        // Finite numbers whose squares overflow count as infinite.
        if let Some(row) = residuals.iter().position(|r| !is_usable(*r)) {
            let value = residuals[row];
            return Err(SolveError::NonFiniteBlockResidual { block, row, value });
        }
        for (row, listed) in compiled.rows.iter().enumerate() {
            let own = by_block[listed.by_block.clone()].iter().copied();
            let entries = &compiled.entries[listed.entries.clone()];
            let shared = entries.iter().map(|e| by_shared[e.value]);
            if let Some(value) = own.chain(shared).find(|v| !is_usable(*v)) {
                return Err(SolveError::NonFiniteBlockJacobian { block, row, value });
            }
        }
    }
    let rows = problem.shared_residual_count();
    let mut residuals = vec![0.0; rows];
    let mut jacobian = vec![0.0; rows * program.shared_dim];
    if rows > 0 {
        problem.linearise_shared(&point.shared, &mut residuals, &mut jacobian);
    }
    if let Some(row) = residuals.iter().position(|r| !is_usable(*r)) {
        return Err(SolveError::NonFiniteResidual { row, value: residuals[row] });
    }
    if let Some(at) = jacobian.iter().position(|v| !is_usable(*v)) {
        let (row, column) = (at / program.shared_dim, at % program.shared_dim);
        return Err(SolveError::NonFiniteJacobian { row, column, value: jacobian[at] });
    }
    Ok(())
}

fn is_usable(value: f64) -> bool {
    (value * value).is_finite()
}
