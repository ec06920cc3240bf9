//! The classical F test.

use nalgebra::DVector;

use crate::algebra::basis::Basis;
use crate::algebra::f_tail::f_tail;
use crate::count::count;

/// F test of one candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Significance {
    /// F statistic of the classical test.
    pub(crate) f_statistic: f64,
    /// Directions tested.
    pub(crate) directions: usize,
    /// Degrees of freedom left.
    pub(crate) dof: usize,
    /// Residual sum of squares that the candidate takes away.
    pub(crate) explained: f64,
    /// Mean square left.
    pub(crate) variance: f64,
    /// Largest of the p-values that apply.
    pub(crate) p_value: f64,
}

pub(crate) fn f_test(
    residual: &DVector<f64>,
    base_dim: usize,
    added: &Basis,
) -> Option<Significance> {
    let rows = residual.len();
    f_test_of(added.explained(residual), added.dim(), residual.norm_squared(), rows, base_dim)
}

/// The F test of so many directions that explain a part of the square of a residual with so many
/// rows, beside a base of that dimension; `None` where nothing is tested or nothing left.
pub(crate) fn f_test_of(
    explained: f64,
    directions: usize,
    square: f64,
    rows: usize,
    base_dim: usize,
) -> Option<Significance> {
    let dof = rows.checked_sub(base_dim + directions)?;
    if directions == 0 || dof == 0 {
        return None;
    }
    let left = (square - explained).max(0.0);
    let variance = left / count(dof);
    let f_statistic = explained / count(directions) / variance;
    let p_value = f_tail(f_statistic, count(directions), count(dof));
    Some(Significance { f_statistic, directions, dof, explained, variance, p_value })
}
