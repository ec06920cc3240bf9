//! Orthogonal elimination, block by block: what rank and covariance are judged by.
//!
//! The search forms normal equations, which square the condition. Here each block's columns are
//! reflected to triangular form, and what remains of its rows adds to a triangle of the shared
//! columns.

use faer::MatRef;
use nalgebra::{DMatrix, DVector};

use super::BorderedProblem;
use super::block::{Place, Rows};
use super::program::Program;
use crate::qr::{apply, reflect};

/// Rows collected per shared column before they are reduced to a triangle.
const BATCH: usize = 8;

/// `J_b = Q R` and `Qᵀ J_s` of one block, with robustly weighted rows.
pub(super) struct BlockFactor {
    /// Reflectors on and below the diagonal, `R` above it.
    packed: DMatrix<f64>,
    pub(super) diagonal: DVector<f64>,
    /// `Qᵀ J_s`, free shared columns in the program's order.
    pub(super) rotated: DMatrix<f64>,
    /// Lengths of the columns of `J_b`.
    pub(super) lengths: DVector<f64>,
    /// As evaluated.
    pub(super) by_block: DMatrix<f64>,
}

impl<P: BorderedProblem> Place<'_, P> {
    /// Factors one block. A held block has no columns of its own.
    pub(super) fn factor(&self, numbers: &mut Rows, block: usize) -> BlockFactor {
        let program = self.program;
        let compiled = program.compiled(block);
        numbers.linearise(*self, compiled, block);
        let numbers = numbers.split(compiled.limits);
        let rows = compiled.limits.rows;
        let columns = if program.is_held(block) { 0 } else { program.block_dim };
        let mut by_block = DMatrix::zeros(rows, columns);
        // Rows of zeros make a wide matrix square.
        let height = rows.max(columns);
        let mut rotated = DMatrix::zeros(height, program.free.len());
        for (i, row) in compiled.rows.iter().enumerate() {
            if columns > 0 {
                for at in row.by_block.clone() {
                    by_block[(i, compiled.block_columns[at])] = numbers.by_block[at];
                }
            }
            for entry in &compiled.entries[row.entries.clone()] {
                rotated[(i, entry.column - 1)] = numbers.by_shared[entry.value];
            }
        }
        BlockFactor::new(by_block, rotated)
    }

    /// Triangle of the shared columns, and their lengths.
    pub(super) fn shared(&self) -> SharedFactor {
        let n = self.program.free.len();
        let mut shared = SharedFactor::new(n);
        let mut numbers = Rows::new(self.program.limits);
        for block in 0..self.program.block_count {
            let factor = self.factor(&mut numbers, block);
            shared.add_lengths(&factor.rotated);
            let skipped = factor.diagonal.len();
            for row in factor.rotated.row_iter().skip(skipped) {
                shared.push(row.iter().copied());
            }
        }
        // The reflections keep lengths, so those of the rotated columns are those of J_s.
        let (residuals, jacobian) = self.shared_rows();
        for row in jacobian.row_iter().take(residuals.len()) {
            for (k, v) in row.iter().enumerate() {
                shared.squares[k] += v * v;
            }
            shared.push(row.iter().copied());
        }
        shared.reduce();
        shared
    }

    /// Residuals that depend on the shared point alone, and their derivative by free columns.
    pub(super) fn shared_rows(&self) -> (DVector<f64>, DMatrix<f64>) {
        let Program { shared_dim, free, .. } = self.program;
        let rows = self.problem.shared_residual_count();
        let mut residuals = DVector::zeros(rows);
        let mut numbers = vec![0.0; rows * shared_dim];
        if rows > 0 {
            let out = residuals.as_mut_slice();
            self.problem.linearise_shared(&self.point.shared, out, &mut numbers);
        }
        let jacobian = DMatrix::from_fn(rows, free.len(), |i, k| numbers[i * shared_dim + free[k]]);
        (residuals, jacobian)
    }
}

impl BlockFactor {
    fn new(by_block: DMatrix<f64>, mut rotated: DMatrix<f64>) -> Self {
        let (rows, columns) = by_block.shape();
        let lengths = DVector::from_fn(columns, |k, _| by_block.column(k).norm());
        let mut packed = DMatrix::zeros(rows.max(columns), columns);
        packed.rows_mut(0, rows).copy_from(&by_block);
        let height = packed.nrows();
        let mut diagonal = DVector::zeros(columns);
        for k in 0..columns {
            let (head, rest) = packed.as_mut_slice().split_at_mut((k + 1) * height);
            let reflector = &mut head[k * height + k..];
            diagonal[k] = reflect(reflector);
            rest.chunks_exact_mut(height).for_each(|column| apply(reflector, &mut column[k..]));
            for column in rotated.as_mut_slice().chunks_exact_mut(height) {
                apply(reflector, &mut column[k..]);
            }
        }
        Self { packed, diagonal, rotated, lengths, by_block }
    }

    /// `R`.
    pub(super) fn triangle(&self) -> DMatrix<f64> {
        let n = self.diagonal.len();
        DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => self.packed[(i, j)],
            std::cmp::Ordering::Equal => self.diagonal[i],
            std::cmp::Ordering::Greater => 0.0,
        })
    }

    /// `R⁻¹ Q₁ᵀ J_s`: minus the block's step for a step of each shared column.
    pub(super) fn coupling(&self) -> DMatrix<f64> {
        let mut coupling = self.rotated.rows(0, self.diagonal.len()).into_owned();
        self.triangle().solve_upper_triangular_mut(&mut coupling);
        coupling
    }

    /// `Q₂ Q₂ᵀ J_s`: the shared columns without what the block's span of them.
    pub(super) fn projected(&self) -> DMatrix<f64> {
        let mut projected = self.rotated.clone();
        projected.rows_mut(0, self.diagonal.len()).fill(0.0);
        let height = projected.nrows().max(1);
        for column in projected.as_mut_slice().chunks_exact_mut(height) {
            for k in (0..self.diagonal.len()).rev() {
                apply(&self.packed.as_slice()[k * height + k..(k + 1) * height], &mut column[k..]);
            }
        }
        projected
    }
}

/// `R` of the shared columns, as rows are added.
pub(super) struct SharedFactor {
    /// The triangle, then rows not yet reduced.
    stack: DMatrix<f64>,
    filled: usize,
    squares: Vec<f64>,
}

impl SharedFactor {
    fn new(n: usize) -> Self {
        Self { stack: DMatrix::zeros((1 + BATCH) * n.max(1), n), filled: n, squares: vec![0.0; n] }
    }

    fn add_lengths(&mut self, columns: &DMatrix<f64>) {
        for (square, column) in self.squares.iter_mut().zip(columns.column_iter()) {
            *square += column.norm_squared();
        }
    }

    fn push(&mut self, row: impl Iterator<Item = f64>) {
        if self.filled == self.stack.nrows() {
            self.reduce();
        }
        for (k, value) in row.enumerate() {
            self.stack[(self.filled, k)] = value;
        }
        self.filled += 1;
    }

    /// Reduces all rows to the triangle.
    fn reduce(&mut self) {
        let n = self.stack.ncols();
        if n == 0 || self.filled == n {
            return;
        }
        self.stack.rows_range_mut(self.filled..).fill(0.0);
        let rows = self.stack.nrows();
        let view = MatRef::from_column_major_slice(self.stack.as_slice(), rows, n);
        let qr = view.qr();
        let triangle = DMatrix::from_fn(n, n, |i, j| if i <= j { qr.R()[(i, j)] } else { 0.0 });
        self.stack.rows_mut(0, n).copy_from(&triangle);
        self.filled = n;
    }

    /// The triangle.
    pub(super) fn triangle(&self) -> DMatrix<f64> {
        self.stack.rows(0, self.stack.ncols()).into_owned()
    }

    /// Lengths of the shared columns; 1 for a column of zeros.
    pub(super) fn lengths(&self) -> DVector<f64> {
        let length = |s: &f64| if *s > 0.0 { s.sqrt() } else { 1.0 };
        DVector::from_iterator(self.squares.len(), self.squares.iter().map(length))
    }
}
