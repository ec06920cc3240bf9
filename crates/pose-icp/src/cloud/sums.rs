//! Sums over residual rows, always added in the same order.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use least_squares::Loss;
use nalgebra::{Matrix6, Vector6};

use super::kd_tree::LANES;

/// Entries of a symmetric 6 × 6 matrix, of its right-hand side, and of the two sums of squares.
const TERMS: usize = 21 + 6 + 2;

/// Normal equations of some residual rows, about the pivot.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    /// `Σ w Jᵀ J`, with `J = ∂r/∂ξ`.
    pub(crate) hessian: Matrix6<f64>,
    /// `Σ w Jᵀ r`.
    pub(crate) gradient: Vector6<f64>,
    /// `Σ r²` over the rows used, mm².
    pub(crate) squares_mm2: f64,
    /// `Σ ρ` in place of it, mm².
    pub(crate) losses_mm2: f64,
    /// Points that took part.
    pub(crate) n_used: usize,
    /// Their residual rows.
    pub(crate) n_rows: usize,
}

impl Sums {
    pub(crate) fn zero() -> Self {
        Self {
            hessian: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            squares_mm2: 0.0,
            losses_mm2: 0.0,
            n_used: 0,
            n_rows: 0,
        }
    }

    pub(crate) fn add(mut self, other: &Self) -> Self {
        self.hessian += other.hessian;
        self.gradient += other.gradient;
        self.squares_mm2 += other.squares_mm2;
        self.losses_mm2 += other.losses_mm2;
        self.n_used += other.n_used;
        self.n_rows += other.n_rows;
        self
    }
}

/// One residual row for each of a group of points; a lane that takes no part has weight zero.
pub(crate) struct Rows {
    /// `∂r/∂ξ`.
    pub(crate) jacobian: [[f64; LANES]; 6],
    pub(crate) residual: [f64; LANES],
    pub(crate) weight: [f64; LANES],
    pub(crate) loss: [f64; LANES],
}

impl Rows {
    pub(crate) const ZERO: Self = Self {
        jacobian: [[0.0; LANES]; 6],
        residual: [0.0; LANES],
        weight: [0.0; LANES],
        loss: [0.0; LANES],
    };
}

/// Sums per lane, for one pair of registers each.
pub(crate) struct LaneSums {
    terms: [[f64; LANES]; TERMS],
}

impl LaneSums {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self { terms: [[0.0; LANES]; TERMS] }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, rows: &Rows) {
        let mut term = 0;
        for i in 0..6 {
            let mut weighted = [0.0; LANES];
            for (l, weighted) in weighted.iter_mut().enumerate() {
                *weighted = rows.weight[l] * rows.jacobian[i][l];
            }
            for j in 0..=i {
                add_products(&mut self.terms[term], &weighted, &rows.jacobian[j]);
                term += 1;
            }
            add_products(&mut self.terms[21 + i], &weighted, &rows.residual);
        }
        for l in 0..LANES {
            let is_used = if rows.weight[l] > 0.0 { 1.0 } else { 0.0 };
            self.terms[27][l] += is_used * rows.residual[l] * rows.residual[l];
            self.terms[28][l] += rows.loss[l];
        }
    }

    pub(crate) fn total(&self, n_used: usize, n_rows: usize) -> Sums {
        let sum = |term: usize| self.terms[term].iter().sum::<f64>();
        let mut hessian = Matrix6::zeros();
        let mut term = 0;
        for i in 0..6 {
            for j in 0..=i {
                hessian[(i, j)] = sum(term);
                hessian[(j, i)] = hessian[(i, j)];
                term += 1;
            }
        }
        let gradient = Vector6::from_fn(|i, _| sum(21 + i));
        Sums { hessian, gradient, squares_mm2: sum(27), losses_mm2: sum(28), n_used, n_rows }
    }
}

#[inline(always)]
fn add_products(sums: &mut [f64; LANES], a: &[f64; LANES], b: &[f64; LANES]) {
    for lane in 0..LANES {
        sums[lane] += a[lane] * b[lane];
    }
}

/// Weight and loss (mm²) of a squared residual.
#[inline(always)]
pub(crate) fn weigh(loss: Option<Loss>, sigma_mm: f64, squared_mm2: f64) -> (f64, f64) {
    let Some(loss) = loss else { return (1.0, squared_mm2) };
    let variance = sigma_mm * sigma_mm;
    let (cost, weight) = loss.evaluate(squared_mm2 / variance);
    (weight, cost * variance)
}
