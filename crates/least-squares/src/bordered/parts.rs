//! Uncertainty of blocks, in room that is used again.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use nalgebra::DMatrix;
use pulp::Simd;

use super::BorderedProblem;
use super::block::{Place, Rows, Scratch, add_products};
use super::lanes::{LANES, Lanes};
use super::program::{Compiled, Group, PANEL, Program};
use super::simd::{Task, dispatch, mul_add};
use super::strips::{self, TILE};
use super::triangle::{self, row_start};

/// Columns of a covariance that are added up side by side.
const COLUMNS: usize = 12;

/// Uncertainty of a few blocks, worked out side by side.
#[derive(Debug)]
pub struct BlockParts {
    scratch: Scratch,
    /// `J_bᵀ [r J_s]` by panel and block direction.
    columns: Vec<[Lanes; PANEL]>,
    /// Inverse of the factor of `V`, packed by rows.
    inverse: Vec<Lanes>,
    /// `V⁻¹`, by rows.
    own: Vec<Lanes>,
    /// Of each row what the block's own directions bring to its leverage.
    by_own: Vec<Lanes>,
    /// `−V⁻¹ J_bᵀ [r J_s]` of a panel's columns.
    panel: Vec<[Lanes; PANEL]>,
    /// The same of one block after the other, by rows.
    solved: Vec<f64>,
    each: [BlockPart; LANES],
}

/// Uncertainty of one block.
///
/// A step of the block has the covariance `own + along·alongᵀ`. With the step of another block it
/// has `along·alongᵀ` of the two.
#[derive(Debug)]
pub struct BlockPart {
    own: Vec<f64>,
    along: Vec<f64>,
    /// Width of rows by shared columns.
    width: usize,
    residual_count: usize,
    residuals: Vec<f64>,
    leverages: Vec<f64>,
}

impl BlockParts {
    pub(super) fn new(program: &Program) -> Self {
        let (b, panels) = (program.block_dim, program.first.len());
        let width = program.free.len().next_multiple_of(TILE);
        let rows = program.limits.rows;
        Self {
            scratch: Scratch::new(program),
            columns: vec![[Lanes::ZERO; PANEL]; program.starts[panels]],
            inverse: vec![Lanes::ZERO; row_start(b)],
            own: vec![Lanes::ZERO; b * b],
            by_own: vec![Lanes::ZERO; rows],
            panel: vec![[Lanes::ZERO; PANEL]; b],
            solved: vec![0.0; LANES * b * panels * PANEL],
            each: std::array::from_fn(|_| BlockPart {
                own: vec![0.0; b * b],
                along: vec![0.0; b * width],
                width,
                residual_count: 0,
                residuals: vec![0.0; rows],
                leverages: vec![0.0; rows],
            }),
        }
    }

    /// Uncertainty of one of the blocks that were filled last, counted from nought.
    ///
    /// # Panics
    ///
    /// If it is not below four.
    #[must_use]
    pub fn nth(&self, nth: usize) -> &BlockPart {
        &self.each[nth]
    }

    /// Number of the variables that [`BlockPart::along`] is by.
    #[must_use]
    pub fn width(&self) -> usize {
        self.each[0].width
    }

    /// From normal equations; `root` is the inverse triangle of the shared columns by rows, under one
    /// of noughts for the residual's column, filled up with noughts.
    pub(super) fn fill<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        root: &[f64],
        group: &Group,
    ) {
        dispatch(Fill { parts: self, place, root, group });
    }

    /// By reflections, of one block; `inverse` is the inverse triangle of the shared columns.
    pub(super) fn fill_orthogonally<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        inverse: &DMatrix<f64>,
        block: usize,
    ) {
        let (b, n) = (place.program.block_dim, place.program.free.len());
        let part = &mut self.each[0];
        let rows = self.scratch.rows_of(0);
        let factor = place.factor(rows, block);
        part.take_residuals(rows, place.program.compiled(block));
        let width = factor.diagonal.len();
        let mut of_block = DMatrix::identity(width, width);
        factor.triangle().solve_upper_triangular_mut(&mut of_block);
        let spanned = &factor.by_block * &of_block;
        let left = factor.projected() * inverse;
        for (i, leverage) in part.leverages[..part.residual_count].iter_mut().enumerate() {
            *leverage = spanned.row(i).norm_squared() + left.row(i).norm_squared();
        }
        part.own.fill(0.0);
        part.along.fill(0.0);
        if width == 0 {
            return;
        }
        let own = &of_block * of_block.transpose();
        let along = factor.coupling() * inverse;
        for i in 0..b {
            for j in 0..b {
                part.own[i * b + j] = own[(i, j)];
            }
            for j in 0..n {
                part.along[i * part.width + j] = -along[(i, j)];
            }
        }
    }
}

impl BlockPart {
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

    /// Whitened residuals, multiplied by the roots of their robust weights.
    #[must_use]
    pub fn residuals(&self) -> &[f64] {
        &self.residuals[..self.residual_count]
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
            dispatch(Combine { part: self, b, a: coefficients, covariance, along: derivative });
        }
    }

    fn take_residuals(&mut self, rows: &Rows, compiled: &Compiled) {
        self.residual_count = compiled.limits.rows;
        let residuals = rows.residuals(self.residual_count);
        self.residuals[..self.residual_count].copy_from_slice(residuals);
    }
}

/// Fills the parts of a group.
struct Fill<'a, P> {
    parts: &'a mut BlockParts,
    place: Place<'a, P>,
    root: &'a [f64],
    group: &'a Group,
}

impl<P: BorderedProblem> Task for Fill<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd, const FUSED: bool>(self, simd: S) {
        // The compiler unrolls the loops over a block's directions where it knows their number.
        match self.place.program.block_dim {
            6 => self.fill::<S, FUSED>(simd, 6),
            12 => self.fill::<S, FUSED>(simd, 12),
            b => self.fill::<S, FUSED>(simd, b),
        }
    }
}

impl<P: BorderedProblem> Fill<'_, P> {
    #[inline(always)]
    fn fill<S: Simd, const FUSED: bool>(self, simd: S, b: usize) {
        let Self { parts, place, root, group } = self;
        let program = place.program;
        let compiled = program.compiled(group.blocks[0]);
        parts.scratch.linearise(place, compiled, group);
        for (lane, part) in parts.each[..group.count].iter_mut().enumerate() {
            part.take_residuals(parts.scratch.rows_of(lane), compiled);
            part.along.fill(0.0);
        }
        if group.is_held {
            parts.own.fill(Lanes::ZERO);
        } else {
            parts.scratch.form_own::<FUSED>(b, compiled, group);
            parts.columns.fill([Lanes::ZERO; PANEL]);
            let columns = parts.columns.as_flattened_mut();
            add_products::<FUSED>(&compiled.coupling, &parts.scratch.values, columns);
            triangle::factor::<FUSED>(b, &mut parts.scratch.own, 0.0);
            parts.invert::<FUSED>(b);
            parts.solve::<FUSED>(b, program);
        }
        parts.lever_by_own::<FUSED>(b, compiled);
        for lane in 0..group.count {
            parts.hand_out(b, lane);
            if !group.is_held {
                let depth = program.first.len() * PANEL;
                let part = &mut parts.each[lane];
                let solved = &parts.solved[lane * b * depth..][..b * depth];
                let root = strips::Rows::new(root, part.width);
                strips::add_product(simd, solved, depth, root, Some(1), &mut part.along);
            }
            parts.lever(simd, compiled, root, lane);
        }
    }
}

/// Adds `A·own·Aᵀ` and `A·along`.
struct Combine<'a> {
    part: &'a BlockPart,
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
        let Self { part, a, covariance, along, .. } = self;
        let from = strips::Rows::new(&part.along, part.width);
        strips::add_product(simd, a, b, from, None, along);
        let rows = a.len() / b;
        for (row, sums) in a.chunks_exact(b).zip(covariance.chunks_exact_mut(rows.max(1))) {
            // Some columns of `A·own` at a time: sums side by side do not wait for each other.
            for first in (0..b).step_by(COLUMNS) {
                let columns = first..(first + COLUMNS).min(b);
                let mut products = [0.0; COLUMNS];
                for (value, own) in row.iter().zip(part.own.chunks_exact(b)) {
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
    /// `V⁻¹` from the factor of `V`.
    #[inline(always)]
    fn invert<const FUSED: bool>(&mut self, b: usize) {
        let Self { scratch, inverse, own, .. } = self;
        for r in 0..b {
            let row = &scratch.own[row_start(r)..][..=r];
            let (known, left) = inverse.split_at_mut(row_start(r));
            for c in 0..r {
                let mut sum = Lanes::ZERO;
                for k in c..r {
                    sum = row[k].mul_sub_from::<FUSED>(known[row_start(k) + c], sum);
                }
                left[c] = sum.times(row[r]);
            }
            left[r] = row[r];
        }
        for i in 0..b {
            for j in 0..=i {
                let mut sum = Lanes::ZERO;
                for r in i..b {
                    let row = &inverse[row_start(r)..][..=r];
                    sum = row[i].mul_add::<FUSED>(row[j], sum);
                }
                own[i * b + j] = sum;
                own[j * b + i] = sum;
            }
        }
    }

    /// `−V⁻¹ J_bᵀ [r J_s]`, handed out to the blocks.
    #[inline(always)]
    fn solve<const FUSED: bool>(&mut self, b: usize, program: &Program) {
        let Self { columns, own, panel, solved, .. } = self;
        let width = program.first.len() * PANEL;
        for (p, &first) in program.first.iter().enumerate() {
            let columns = &columns[program.starts[p]..program.starts[p + 1]];
            for (own, sums) in own.chunks_exact(b).zip(&mut *panel) {
                let mut left = [Lanes::ZERO; PANEL];
                for (own, columns) in own[first..].iter().zip(columns) {
                    for c in 0..PANEL {
                        left[c] = own.mul_sub_from::<FUSED>(columns[c], left[c]);
                    }
                }
                *sums = left;
            }
            // Apart from the sums, which the compiler would transpose at every step.
            for (r, [c0, c1, c2, c3]) in panel.iter().enumerate() {
                for lane in 0..LANES {
                    let out = &mut solved[(lane * b + r) * width + p * PANEL..][..PANEL];
                    out.copy_from_slice(&[c0.0[lane], c1.0[lane], c2.0[lane], c3.0[lane]]);
                }
            }
        }
    }

    /// Part of the leverages that is `J_b own J_bᵀ`.
    #[inline(always)]
    fn lever_by_own<const FUSED: bool>(&mut self, b: usize, compiled: &Compiled) {
        let Self { scratch, own, by_own, .. } = self;
        let by_block = &scratch.values[compiled.limits.rows..][..compiled.limits.by_block];
        for (row, by_own) in compiled.rows.iter().zip(by_own) {
            let columns = &compiled.block_columns[row.by_block.clone()];
            let values = &by_block[row.by_block.clone()];
            let mut sum = Lanes::ZERO;
            for (column, value) in columns.iter().zip(values) {
                let own = &own[column * b..][..b];
                let mut product = Lanes::ZERO;
                for (other, value) in columns.iter().zip(values) {
                    product = own[*other].mul_add::<FUSED>(*value, product);
                }
                sum = value.mul_add::<FUSED>(product, sum);
            }
            *by_own = sum;
        }
    }

    /// Hands one block its `own`.
    #[inline(always)]
    fn hand_out(&mut self, b: usize, lane: usize) {
        for (to, from) in self.each[lane].own.iter_mut().zip(&self.own[..b * b]) {
            *to = from.0[lane];
        }
    }

    /// Leverages of one block: to those by its own directions the squares of what is left of `J_s`, times
    /// the root.
    #[inline(always)]
    fn lever<S: Simd>(&mut self, simd: S, compiled: &Compiled, root: &[f64], lane: usize) {
        let Self { scratch, by_own, each, .. } = self;
        let BlockPart { along, leverages, width, .. } = &mut each[lane];
        let numbers = scratch.rows_of(lane).split(compiled.limits);
        let root = strips::Rows::new(root, *width);
        let along = strips::Rows::new(along, *width);
        for ((row, by_own), leverage) in compiled.rows.iter().zip(by_own).zip(leverages) {
            let entries = compiled.entries[row.entries.clone()].iter();
            let entries = entries.map(|entry| (entry.column, numbers.by_shared[entry.value]));
            let columns = &compiled.block_columns[row.by_block.clone()];
            let values = &numbers.by_block[row.by_block.clone()];
            let by_block = columns.iter().copied().zip(values.iter().copied());
            let squares = strips::squares(simd, &(entries, root), &(by_block, along));
            *leverage = by_own.0[lane] + squares;
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
