//! Least squares with up to six unknowns, row by row, without memory of the rows.

use crate::PoseParameter;

/// Number of parameters of a pose.
pub(crate) const MAX: usize = PoseParameter::ALL.len();

/// Upper triangle `R` of the rows seen so far, with `Qᵀ r` beside it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    n: usize,
    /// Row `k` holds columns `k..n`, and the right-hand side in column `MAX`.
    rows: [[f64; MAX + 1]; MAX],
}

/// Equations on their way into a triangle, by columns: taking in several at once costs one square
/// root a column, not one for each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    columns: [[f64; Block::ROWS]; MAX + 1],
    count: usize,
}

impl Block {
    const ROWS: usize = 8;

    pub(crate) fn new() -> Self {
        Self { columns: [[0.0; Self::ROWS]; MAX + 1], count: 0 }
    }

    fn of(row: &[f64; MAX + 1]) -> Self {
        let mut block = Self::new();
        block.push(row);
        block
    }

    /// Adds a row, the residual in column `MAX`; there must be room for it.
    pub(crate) fn push(&mut self, row: &[f64; MAX + 1]) {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column[self.count] = *value;
        }
        self.count += 1;
    }

    pub(crate) fn is_full(&self) -> bool {
        self.count == Self::ROWS
    }
}

/// Summed in pairs, so that a processor adds several at once.
fn dot(a: &[f64; Block::ROWS], b: &[f64; Block::ROWS]) -> f64 {
    let p = |i: usize| a[i] * b[i];
    ((p(0) + p(4)) + (p(2) + p(6))) + ((p(1) + p(5)) + (p(3) + p(7)))
}

impl Triangle {
    pub(crate) fn new(n: usize) -> Self {
        Self { n, rows: [[0.0; MAX + 1]; MAX] }
    }

    /// Takes in the equations `row · step = −residual` of a block (Householder), and empties it.
    pub(crate) fn take(&mut self, block: &mut Block) {
        for k in 0..self.n {
            let column = block.columns[k];
            let below = dot(&column, &column);
            if below == 0.0 {
                continue;
            }
            let kept = self.rows[k][k];
            // Whitened rows are far from the ends of the exponent range: no `hypot` is needed.
            let end = -(kept * kept + below).sqrt().copysign(kept);
            let lead = kept - end;
            let (per_lead, share) = (lead.recip(), -lead / end);
            let mirror = column.map(|v| v * per_lead);
            self.rows[k][k] = end;
            for j in (k + 1..self.n).chain([MAX]) {
                let other = &mut block.columns[j];
                let travel = share * (self.rows[k][j] + dot(&mirror, other));
                self.rows[k][j] -= travel;
                for (value, part) in other.iter_mut().zip(&mirror) {
                    *value -= travel * part;
                }
            }
        }
        *block = Block::new();
    }

    /// Half the squared length of the part of the residual that a full step removes.
    pub(crate) fn predicted(&self) -> f64 {
        0.5 * self.rows[..self.n].iter().map(|row| row[MAX] * row[MAX]).sum::<f64>()
    }

    /// Minimises `‖J step + r‖² + damping ‖D step‖²`, `D` being the lengths of the columns.
    ///
    /// A column of zeros takes no step.
    pub(crate) fn step(&self, damping: f64) -> [f64; MAX] {
        let mut damped = *self;
        if damping > 0.0 {
            let root = damping.sqrt();
            for k in 0..self.n {
                let length = (0..=k).map(|i| self.rows[i][k].powi(2)).sum::<f64>().sqrt();
                let mut row = [0.0; MAX + 1];
                row[k] = root * length;
                damped.take(&mut Block::of(&row));
            }
        }
        let mut step = [0.0; MAX];
        for k in (0..self.n).rev() {
            let known: f64 = (k + 1..self.n).map(|j| damped.rows[k][j] * step[j]).sum();
            let left = -damped.rows[k][MAX] - known;
            step[k] = if damped.rows[k][k] == 0.0 { 0.0 } else { left / damped.rows[k][k] };
        }
        step
    }

    /// Newton's step under damping, `second` being what `RᵀR` lacks.
    ///
    /// With `step = −R⁻¹ y` this is `(I + R⁻ᵀ (S + λ D²) R⁻¹) y = Qᵀ r`, which keeps the accuracy
    /// of `R`. `None` where the Hessian is not positive definite.
    pub(crate) fn newton(&self, second: &[[f64; MAX]; MAX], damping: f64) -> Option<[f64; MAX]> {
        let n = self.n;
        let damped = |k: usize| damping * (0..=k).map(|i| self.rows[i][k].powi(2)).sum::<f64>();
        // Columns of S, each solved by Rᵀ from the left; then rows, by Rᵀ again.
        let mut inner = [[0.0; MAX]; MAX];
        for j in 0..n {
            let extra = damped(j);
            let solved = self.solve_transposed(|i| {
                second[i.min(j)][i.max(j)] + if i == j { extra } else { 0.0 }
            })?;
            for i in 0..n {
                inner[i][j] = solved[i];
            }
        }
        for row in &mut inner[..n] {
            let copy = *row;
            *row = self.solve_transposed(|j| copy[j])?;
        }
        for (k, row) in inner[..n].iter_mut().enumerate() {
            row[k] += 1.0;
        }
        let mut y = cholesky_solve(&inner, n, |k| self.rows[k][MAX])?;
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|j| self.rows[k][j] * y[j]).sum();
            y[k] = (y[k] - known) / self.rows[k][k];
        }
        Some(y.map(|v| -v))
    }

    /// `R⁻ᵀ b`; `None` where `R` is singular.
    fn solve_transposed(&self, b: impl Fn(usize) -> f64) -> Option<[f64; MAX]> {
        let mut x = [0.0; MAX];
        for k in 0..self.n {
            let pivot = self.rows[k][k];
            if pivot == 0.0 {
                return None;
            }
            let known: f64 = (0..k).map(|i| self.rows[i][k] * x[i]).sum();
            x[k] = (b(k) - known) / pivot;
        }
        Some(x)
    }

    /// Entry of `R`.
    pub(crate) fn entry(&self, row: usize, column: usize) -> f64 {
        if row <= column { self.rows[row][column] } else { 0.0 }
    }
}

/// Solves `A x = b` for the leading `n × n` block of a symmetric `A`; `None` unless it is clearly
/// positive definite.
fn cholesky_solve(a: &[[f64; MAX]; MAX], n: usize, b: impl Fn(usize) -> f64) -> Option<[f64; MAX]> {
    let mut l = [[0.0; MAX]; MAX];
    let mut x = [0.0; MAX];
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let left = a[i][j] - known;
            if i == j {
                if left.is_nan() || left < MIN_PIVOT {
                    return None;
                }
                l[i][i] = left.sqrt();
            } else {
                l[i][j] = left / l[j][j];
            }
        }
        let known: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (b(i) - known) / l[i][i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    Some(x)
}

/// Least curvature of the cost along a direction, relative to Gauss-Newton's, that is trusted.
const MIN_PIVOT: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, SMatrix, Vector3};

    use super::*;

    /// Round-off of a few dozen operations on numbers of a few dozen.
    const EXACT: f64 = 1e-11;

    const ROWS: [[f64; 3]; 5] =
        [[2.0, -1.0, 3.0], [0.0, 4.0, 1.0], [5.0, 2.0, -2.0], [-1.0, 3.0, 1.0], [1.0, 1.0, 6.0]];
    const RESIDUALS: [f64; 5] = [1.0, -2.0, 0.5, 3.0, -4.0];

    fn triangle() -> Triangle {
        let (mut triangle, mut block) = (Triangle::new(3), Block::new());
        for (row, residual) in ROWS.iter().zip(RESIDUALS) {
            block.push(&[row[0], row[1], row[2], 0.0, 0.0, 0.0, residual]);
        }
        triangle.take(&mut block);
        triangle
    }

    /// `JᵀJ` and `Jᵀr`.
    fn normal() -> (Matrix3<f64>, Vector3<f64>) {
        let j = SMatrix::<f64, 5, 3>::from_fn(|i, k| ROWS[i][k]);
        (j.transpose() * j, j.transpose() * SMatrix::<f64, 5, 1>::from(RESIDUALS))
    }

    /// `(JᵀJ + λ D²) step = −Jᵀr`, `D` being the lengths of the columns.
    #[test]
    fn a_step_solves_the_damped_normal_equations() {
        let (square, gradient) = normal();
        for damping in [0.0, 0.3, 20.0] {
            let step = Vector3::from_column_slice(&triangle().step(damping)[..3]);
            let damped = square + Matrix3::from_diagonal(&(square.diagonal() * damping));
            assert!((damped * step + gradient).norm() < EXACT, "{damping}");
        }
    }

    /// `(JᵀJ + S + λ D²) step = −Jᵀr`.
    #[test]
    fn newtons_step_solves_the_equations_with_second_derivatives() {
        let (square, gradient) = normal();
        let second = Matrix3::new(0.5, -0.25, 1.0, -0.25, 2.0, 0.75, 1.0, 0.75, -1.5);
        let mut upper = [[0.0; MAX]; MAX];
        for i in 0..3 {
            for j in i..3 {
                upper[i][j] = second[(i, j)];
            }
        }
        for damping in [0.0, 0.3] {
            let step = triangle().newton(&upper, damping).unwrap();
            let step = Vector3::from_column_slice(&step[..3]);
            let damped = square + second + Matrix3::from_diagonal(&(square.diagonal() * damping));
            assert!((damped * step + gradient).norm() < EXACT, "{damping}");
        }
        // Downhill along no direction is no minimum.
        for (i, row) in upper.iter_mut().enumerate().take(3) {
            row[i] = -2.0 * square[(i, i)];
        }
        assert!(triangle().newton(&upper, 0.0).is_none());
    }
}
