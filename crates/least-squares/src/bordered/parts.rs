//! Uncertainty of one block, in room that is used again.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use nalgebra::DMatrix;
use pulp::Simd;

use super::BorderedProblem;
use super::block::{Place, Rows};
use super::program::{Compiled, Program};
use super::simd::{Task, dispatch, mul_add};
use super::strips::{self, TILE};
use super::triangle::row_start;

/// Columns of a covariance that are added up side by side.
const COLUMNS: usize = 4;

/// Uncertainty of one block.
///
/// A step of the block has the covariance `own + along·alongᵀ`. With the step of another block it
/// has `along·alongᵀ` of the two.
#[derive(Debug)]
pub struct BlockParts {
    rows: Rows,
    /// Packed triangle of `V = J_bᵀ J_b`, then its factor, with the reciprocals of its diagonal.
    factor: Vec<f64>,
    /// Inverse of the factor, `block_dim × block_dim` by rows.
    inverse: Vec<f64>,
    /// `J_bᵀ J_s` by columns.
    coupling: Vec<f64>,
    /// `−V⁻¹ J_bᵀ J_s` by rows.
    solved: Vec<f64>,
    own: Vec<f64>,
    along: Vec<f64>,
    residual_count: usize,
    leverages: Vec<f64>,
    /// Width of rows by shared columns.
    width: usize,
}

impl BlockParts {
    pub(super) fn new(program: &Program) -> Self {
        let (b, width) = (program.block_dim, program.free.len().next_multiple_of(TILE));
        Self {
            rows: Rows::new(program.limits),
            factor: vec![0.0; row_start(b)],
            inverse: vec![0.0; b * b],
            coupling: vec![0.0; b * width],
            solved: vec![0.0; b * width],
            own: vec![0.0; b * b],
            along: vec![0.0; b * width],
            residual_count: 0,
            leverages: vec![0.0; program.limits.rows],
            width,
        }
    }

    /// Covariance of the block's step where the shared point is known, `block_dim × block_dim` by
    /// rows; zero where the block is held.
    #[must_use]
    pub fn own(&self) -> &[f64] {
        &self.own
    }

    /// How the block's step follows independent variables of unit variance that all blocks share, by
    /// rows of [`BlockParts::width`]; zero where the block is held.
    #[must_use]
    pub fn along(&self) -> &[f64] {
        &self.along
    }

    /// Number of the variables that [`BlockParts::along`] is by.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whitened residuals, multiplied by the roots of their robust weights.
    #[must_use]
    pub fn residuals(&self) -> &[f64] {
        self.rows.residuals(self.residual_count)
    }

    /// Leverage of each residual, as [`leverages`](super::BorderedCovariance::leverages) gives it.
    #[must_use]
    pub fn leverages(&self) -> &[f64] {
        &self.leverages[..self.residual_count]
    }

    /// Adds what the block brings to the covariance of `A·step`, with the coefficients `A` by rows:
    /// `A·own·Aᵀ` to `covariance` and `A·along` to `derivative`, both by rows.
    pub fn add_combined(
        &self,
        coefficients: &[f64],
        covariance: &mut [f64],
        derivative: &mut [f64],
    ) {
        let b = self.own.len().isqrt();
        if b > 0 {
            dispatch(Combine { parts: self, b, a: coefficients, covariance, along: derivative });
        }
    }

    /// From normal equations; `root` is the inverse triangle of the shared columns by rows, which are
    /// filled up with noughts.
    pub(super) fn fill<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        root: &[f64],
        block: usize,
    ) {
        dispatch(Fill { parts: self, place, root, block });
    }

    /// By reflections; `inverse` is the inverse triangle of the shared columns.
    pub(super) fn fill_orthogonally<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        inverse: &DMatrix<f64>,
        block: usize,
    ) {
        let (b, n) = (place.program.block_dim, place.program.free.len());
        self.residual_count = place.program.compiled(block).limits.rows;
        let factor = place.factor(&mut self.rows, block);
        let width = factor.diagonal.len();
        let mut of_block = DMatrix::identity(width, width);
        factor.triangle().solve_upper_triangular_mut(&mut of_block);
        let spanned = &factor.by_block * &of_block;
        let left = factor.projected() * inverse;
        for (i, leverage) in self.leverages[..self.residual_count].iter_mut().enumerate() {
            *leverage = spanned.row(i).norm_squared() + left.row(i).norm_squared();
        }
        self.own.fill(0.0);
        self.along.fill(0.0);
        if width == 0 {
            return;
        }
        let own = &of_block * of_block.transpose();
        let along = factor.coupling() * inverse;
        for i in 0..b {
            for j in 0..b {
                self.own[i * b + j] = own[(i, j)];
            }
            for j in 0..n {
                self.along[i * self.width + j] = -along[(i, j)];
            }
        }
    }
}

/// Fills the parts of one block.
struct Fill<'a, P> {
    parts: &'a mut BlockParts,
    place: Place<'a, P>,
    root: &'a [f64],
    block: usize,
}

impl<P: BorderedProblem> Task for Fill<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd, const FUSED: bool>(self, simd: S) {
        let Self { parts, place, root, block } = self;
        let program = place.program;
        let compiled = program.compiled(block);
        parts.residual_count = compiled.limits.rows;
        parts.rows.linearise(place, compiled, block);
        if program.is_held(block) {
            parts.own.fill(0.0);
            parts.along.fill(0.0);
        } else {
            // The compiler unrolls the loops over a block's directions where it knows their number.
            match program.block_dim {
                6 => parts.solve::<S, FUSED>(simd, 6, compiled, root),
                12 => parts.solve::<S, FUSED>(simd, 12, compiled, root),
                b => parts.solve::<S, FUSED>(simd, b, compiled, root),
            }
        }
        parts.lever::<S, FUSED>(simd, program.block_dim, compiled, root);
    }
}

/// Adds `A·own·Aᵀ` and `A·along`.
struct Combine<'a> {
    parts: &'a BlockParts,
    b: usize,
    a: &'a [f64],
    covariance: &'a mut [f64],
    along: &'a mut [f64],
}

impl Task for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd, const FUSED: bool>(self, simd: S) {
        match self.b {
            6 => self.add::<S, FUSED>(simd, 6),
            12 => self.add::<S, FUSED>(simd, 12),
            b => self.add::<S, FUSED>(simd, b),
        }
    }
}

impl Combine<'_> {
    #[inline(always)]
    fn add<S: Simd, const FUSED: bool>(self, simd: S, b: usize) {
        let Self { parts, a, covariance, along, .. } = self;
        let from = strips::Rows::new(&parts.along, parts.width);
        strips::add_product(simd, a, b, from, false, along);
        let rows = a.len() / b;
        for (row, sums) in a.chunks_exact(b).zip(covariance.chunks_exact_mut(rows.max(1))) {
            // Some columns of `A·own` at a time: sums side by side do not wait for each other.
            for first in (0..b).step_by(COLUMNS) {
                let columns = first..(first + COLUMNS).min(b);
                let mut products = [0.0; COLUMNS];
                for (value, own) in row.iter().zip(parts.own.chunks_exact(b)) {
                    add_scaled::<FUSED>(&mut products, *value, &own[columns.clone()]);
                }
                for (sum, other) in sums.iter_mut().zip(a.chunks_exact(b)) {
                    for (product, other) in products.iter().zip(&other[columns.clone()]) {
                        *sum = mul_add::<FUSED>(*product, *other, *sum);
                    }
                }
            }
        }
    }
}

impl BlockParts {
    /// `V⁻¹` and `−V⁻¹ J_bᵀ J_s` times the root.
    #[inline(always)]
    fn solve<S: Simd, const FUSED: bool>(
        &mut self,
        simd: S,
        b: usize,
        compiled: &Compiled,
        root: &[f64],
    ) {
        self.multiply::<FUSED>(b, compiled);
        self.factor::<FUSED>(b);
        let Self { factor, inverse, coupling, solved, own, along, width, .. } = self;
        for (r, row) in solved.chunks_exact_mut((*width).max(1)).enumerate() {
            for (to, column) in row.iter_mut().zip(coupling.chunks_exact(b)) {
                *to = -column[r];
            }
        }
        strips::solve(simd, b, factor, solved);
        along.fill(0.0);
        strips::add_product(simd, solved, *width, strips::Rows::new(root, *width), true, along);
        inverse.fill(0.0);
        for r in 0..b {
            let row = &factor[row_start(r)..][..=r];
            let (known, rest) = inverse.split_at_mut(r * b);
            let left = &mut rest[..b];
            left[r] = 1.0;
            for (f, known) in row.iter().zip(known.chunks_exact(b)) {
                add_scaled::<FUSED>(left, -f, known);
            }
            scale(left, row[r]);
        }
        own.fill(0.0);
        for (r, row) in inverse.chunks_exact(b).enumerate() {
            for (own, value) in own.chunks_exact_mut(b).zip(&row[..=r]) {
                add_scaled::<FUSED>(own, *value, row);
            }
        }
    }

    /// `V` and `J_bᵀ J_s`.
    #[inline(always)]
    fn multiply<const FUSED: bool>(&mut self, b: usize, compiled: &Compiled) {
        self.factor.fill(0.0);
        self.coupling.fill(0.0);
        let numbers = self.rows.split(compiled.limits);
        for row in &compiled.rows {
            let directions = &compiled.block_columns[row.by_block.clone()];
            let values = &numbers.by_block[row.by_block.clone()];
            for (p, (direction, value)) in directions.iter().zip(values).enumerate() {
                for (other, factor) in directions[..=p].iter().zip(values) {
                    let at = row_start(*direction.max(other)) + direction.min(other);
                    let sum = &mut self.factor[at];
                    *sum = mul_add::<FUSED>(*value, *factor, *sum);
                }
            }
            let meets_all = directions.iter().copied().eq(0..b);
            for entry in &compiled.entries[row.entries.clone()] {
                let by_shared = numbers.by_shared[entry.value];
                let column = &mut self.coupling[(entry.column - 1) * b..][..b];
                if meets_all {
                    add_scaled::<FUSED>(column, by_shared, values);
                    continue;
                }
                for (direction, value) in directions.iter().zip(values) {
                    column[*direction] = mul_add::<FUSED>(*value, by_shared, column[*direction]);
                }
            }
        }
    }

    /// Overwrites `V` by its factor.
    #[inline(always)]
    fn factor<const FUSED: bool>(&mut self, b: usize) {
        for r in 0..b {
            let (above, row) = self.factor.split_at_mut(row_start(r));
            let row = &mut row[..=r];
            for c in 0..r {
                let other = &above[row_start(c)..][..=c];
                let mut left = row[c];
                for k in 0..c {
                    left = mul_add::<FUSED>(-row[k], other[k], left);
                }
                row[c] = left * other[c];
            }
            let mut left = row[r];
            for value in &row[..r] {
                left = mul_add::<FUSED>(-value, *value, left);
            }
            row[r] = left.sqrt().recip();
        }
    }

    /// Leverages: `J_b own J_bᵀ` and the squares of what is left of `J_s`, times the root.
    #[inline(always)]
    fn lever<S: Simd, const FUSED: bool>(
        &mut self,
        simd: S,
        b: usize,
        compiled: &Compiled,
        root: &[f64],
    ) {
        let Self { rows, own, along, leverages, width, .. } = self;
        let numbers = rows.split(compiled.limits);
        let root = strips::Rows::new(root, *width);
        let along = strips::Rows::new(along, *width);
        for (row, leverage) in compiled.rows.iter().zip(leverages) {
            let entries = compiled.entries[row.entries.clone()].iter();
            let entries = entries.map(|entry| (entry.column - 1, numbers.by_shared[entry.value]));
            let columns = &compiled.block_columns[row.by_block.clone()];
            let values = &numbers.by_block[row.by_block.clone()];
            let by_block = columns.iter().copied().zip(values.iter().copied());
            let squares = strips::squares(simd, &(entries, root), &(by_block, along));
            let mut sum = 0.0;
            for (column, value) in columns.iter().zip(values) {
                let own = &own[column * b..][..b];
                let mut product = 0.0;
                for (other, value) in columns.iter().zip(values) {
                    product = mul_add::<FUSED>(own[*other], *value, product);
                }
                sum = mul_add::<FUSED>(*value, product, sum);
            }
            *leverage = sum + squares;
        }
    }
}

/// `to ← to + factor · from`.
#[inline(always)]
fn add_scaled<const FUSED: bool>(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = mul_add::<FUSED>(factor, *from, *to);
    }
}

#[inline(always)]
fn scale(row: &mut [f64], factor: f64) {
    for value in row {
        *value *= factor;
    }
}
