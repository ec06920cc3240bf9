//! Pivoted Householder factorisation on contiguous columns, and damped steps from its factor.
//!
//! The iteration has its own because a library call costs more than the arithmetic here: see
//! `benches/dense.rs`, which times it beside the factorisations of `faer` and `nalgebra`.

use nalgebra::{DMatrix, DVector};

/// Share of a column's length, left by the columns before it, that is rounding.
const DEPENDENT: f64 = 1e-14;
/// Share of its last exact value from which a running remainder has to be computed anew.
const STALE: f64 = 1e-3;

/// `A P = Q R` with `Q` as reflectors, dependent columns last.
pub(crate) struct Qr {
    /// Reflectors on and below the diagonal, `R` above it; at least as many rows as columns.
    packed: DMatrix<f64>,
    /// Diagonal of `R`.
    diagonal: DVector<f64>,
    /// Column of `A` for each column of `R`.
    order: Vec<usize>,
    /// Columns that the ones before them do not span.
    rank: usize,
    /// Squared length left of each column, over its whole; and when last computed exactly.
    remaining: Vec<[f64; 2]>,
    /// Scratch of [`Qr::solve_damped`]: rows of the damped factor as columns.
    rows: DMatrix<f64>,
    /// The row of `√λ D` being rotated into the factor.
    incoming: DVector<f64>,
    /// Right-hand side, then solution, in the order of the columns of `R`.
    solution: DVector<f64>,
}

impl Qr {
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        Self {
            packed: DMatrix::zeros(rows.max(columns), columns),
            diagonal: DVector::zeros(columns),
            order: Vec::with_capacity(columns),
            rank: 0,
            remaining: Vec::with_capacity(columns),
            rows: DMatrix::zeros(columns, columns),
            incoming: DVector::zeros(columns),
            solution: DVector::zeros(columns),
        }
    }

    /// Factors `a`, whose columns have the given lengths; rows of zeros stand in for those that
    /// a wide matrix lacks.
    pub(crate) fn factor(&mut self, a: &DMatrix<f64>, lengths: &DVector<f64>) {
        let columns = a.ncols();
        self.packed.fill(0.0);
        self.packed.rows_mut(0, a.nrows()).copy_from(a);
        self.order.clear();
        self.order.extend(0..columns);
        self.remaining.clear();
        self.remaining.extend(lengths.iter().map(|l| [if *l > 0.0 { 1.0 } else { 0.0 }; 2]));
        self.rank = (0..columns).find(|&k| !self.eliminate(k, lengths)).unwrap_or(columns);
        for k in self.rank..columns {
            self.diagonal[k] = 0.0;
            self.packed.column_mut(k).rows_range_mut(self.rank..).fill(0.0);
        }
    }

    /// Brings the most independent column to place `k` and reflects it; false if none is left.
    fn eliminate(&mut self, k: usize, lengths: &DVector<f64>) -> bool {
        let largest = |best: usize, j: usize| {
            if self.remaining[j][0] > self.remaining[best][0] { j } else { best }
        };
        let pivot = (k..self.order.len()).fold(k, largest);
        if self.remaining[pivot][0] <= DEPENDENT * DEPENDENT {
            return false;
        }
        self.packed.swap_columns(k, pivot);
        self.order.swap(k, pivot);
        self.remaining.swap(k, pivot);
        let height = self.packed.nrows();
        let (head, rest) = self.packed.as_mut_slice().split_at_mut((k + 1) * height);
        let reflector = &mut head[k * height + k..];
        self.diagonal[k] = reflect(reflector);
        for (i, column) in rest.chunks_exact_mut(height).enumerate() {
            apply(reflector, &mut column[k..]);
            let j = k + 1 + i;
            let length = lengths[self.order[j]];
            let [left, exact] = &mut self.remaining[j];
            *left -= (column[k] / length).powi(2);
            if *left <= STALE * *exact {
                let tail = &column[k + 1..];
                *left = dot(tail, tail) / (length * length);
                *exact = *left;
            }
        }
        true
    }

    /// Overwrites the leading rows of `v` with `Qᵀ v`, nought where no column leads; `v` has as
    /// many rows as `A`, or more.
    pub(crate) fn q_transpose_mul(&self, v: &mut DVector<f64>) {
        let height = self.packed.nrows().max(1);
        let reflectors = self.packed.as_slice().chunks_exact(height).take(self.rank);
        for (k, column) in reflectors.enumerate() {
            apply(&column[k..], &mut v.as_mut_slice()[k..]);
        }
        v.rows_range_mut(self.rank..self.order.len()).fill(0.0);
    }

    /// Solves `min ‖A x + r‖² + λ‖D x‖²` by Givens rotations (Moré 1978, section 3).
    ///
    /// `b` holds the leading rows of `Qᵀ r`. A dependent column takes no step where `λ` is
    /// nought.
    pub(crate) fn solve_damped(
        &mut self,
        b: &DVector<f64>,
        damping: f64,
        scale: &DVector<f64>,
        x: &mut DVector<f64>,
    ) {
        let n = self.order.len();
        for k in 0..n {
            self.rows[(k, k)] = self.diagonal[k];
            for j in k + 1..n {
                self.rows[(j, k)] = self.packed[(k, j)];
            }
            self.solution[k] = -b[k];
        }
        let root = damping.sqrt();
        if root > 0.0 {
            for k in 0..n {
                self.rotate_in(k, root * scale[self.order[k]]);
            }
        }
        for k in (0..n).rev() {
            let row = self.rows.column(k);
            let known: f64 = (k + 1..n).map(|j| row[j] * self.solution[j]).sum();
            let left = self.solution[k] - known;
            self.solution[k] = if left == 0.0 { 0.0 } else { left / row[k] };
            x[self.order[k]] = self.solution[k];
        }
    }

    /// Rotates the row `value · e_first` into the factor.
    fn rotate_in(&mut self, first: usize, value: f64) {
        let n = self.order.len();
        self.incoming.fill(0.0);
        self.incoming[first] = value;
        let mut incoming_rhs = 0.0;
        for k in first..n {
            if self.incoming[k] == 0.0 {
                continue;
            }
            let length = self.rows[(k, k)].hypot(self.incoming[k]);
            let (cos, sin) = (self.rows[(k, k)] / length, self.incoming[k] / length);
            for j in k..n {
                let (kept, new) = (self.rows[(j, k)], self.incoming[j]);
                self.rows[(j, k)] = cos * kept + sin * new;
                self.incoming[j] = cos * new - sin * kept;
            }
            let kept = self.solution[k];
            self.solution[k] = cos * kept + sin * incoming_rhs;
            incoming_rhs = cos * incoming_rhs - sin * kept;
        }
    }
}

/// Scalar product in eight interleaved sums, which the compiler turns into vector code.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (a_blocks, a_rest) = a.as_chunks::<LANES>();
    let (b_blocks, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (x, y) in a_blocks.iter().zip(b_blocks) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

/// Turns `column` into the reflector that zeroes all but its first entry; returns that entry.
pub(crate) fn reflect(column: &mut [f64]) -> f64 {
    let norm = dot(column, column).sqrt();
    if norm == 0.0 {
        return 0.0;
    }
    let signed = if column[0] < 0.0 { -norm } else { norm };
    let inverse = 1.0 / signed;
    for v in column.iter_mut() {
        *v *= inverse;
    }
    column[0] += 1.0;
    -signed
}

/// Reflects another column by it.
pub(crate) fn apply(reflector: &[f64], column: &mut [f64]) {
    if reflector[0] == 0.0 {
        return;
    }
    let factor = -dot(reflector, column) / reflector[0];
    for (c, r) in column.iter_mut().zip(reflector) {
        *c += factor * r;
    }
}
