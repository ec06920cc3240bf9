//! First pass: eliminates the blocks of a chunk and adds up what is left for the shared point.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::block::Scratch;
use super::program::{Compiled, Program, TILE};
use super::simd::{Task, mul_add};
use super::{BorderedPoint, BorderedProblem};
use crate::RobustRows;

/// Rows of the reduced matrix that the rank update handles together.
const TILE_ROWS: usize = 4;

/// What a chunk of blocks adds to the reduced normal equations, and its scratch.
pub(super) struct Sums {
    /// Upper triangle of `[r J_s]ᵀ[r J_s] − Yᵀ Y`, by rows of the program's width; where tiles
    /// cross the diagonal, also some below it.
    pub(super) reduced: Vec<f64>,
    /// Diagonal of `J_sᵀ J_s`.
    pub(super) diagonal: Vec<f64>,
    /// `Σ ρ`.
    pub(super) twice_cost: f64,
    /// `g_bᵀ V⁻¹ g_b`: twice what the blocks alone promise.
    pub(super) promised: f64,
    /// Least share of a block's diagonal entry that the elimination leaves.
    pub(super) least_pivot: f64,
    /// `Y = L⁻¹ [g_b W]`, by rows of the program's width.
    y: Vec<f64>,
}

impl Sums {
    pub(super) fn new(program: &Program) -> Self {
        let width = program.width;
        Self {
            reduced: vec![0.0; width * width],
            diagonal: vec![0.0; width],
            twice_cost: 0.0,
            promised: 0.0,
            least_pivot: 1.0,
            y: vec![0.0; program.block_dim * width],
        }
    }

    fn clear(&mut self) {
        self.reduced.fill(0.0);
        self.diagonal.fill(0.0);
        (self.twice_cost, self.promised, self.least_pivot) = (0.0, 0.0, 1.0);
    }

    /// Adds the sums of another chunk.
    pub(super) fn add(&mut self, other: &Self) {
        self.reduced.iter_mut().zip(&other.reduced).for_each(|(a, b)| *a += b);
        self.diagonal.iter_mut().zip(&other.diagonal).for_each(|(a, b)| *a += b);
        self.twice_cost += other.twice_cost;
        self.promised += other.promised;
        self.least_pivot = self.least_pivot.min(other.least_pivot);
    }
}

/// Eliminates the blocks from `first` on, as many as `blocks` holds.
pub(super) struct Eliminate<'a, P> {
    pub(super) problem: &'a P,
    pub(super) program: &'a Program,
    pub(super) robust: &'a [RobustRows],
    pub(super) point: &'a BorderedPoint,
    pub(super) blocks: std::ops::Range<usize>,
    pub(super) damping: f64,
    pub(super) scratch: &'a mut Scratch,
    pub(super) sums: &'a mut Sums,
}

impl<P: BorderedProblem> Task for Eliminate<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        // The compiler unrolls the loops over a block's directions where it knows their number.
        match self.program.block_dim {
            1 => self.eliminate::<FUSED>(1),
            2 => self.eliminate::<FUSED>(2),
            3 => self.eliminate::<FUSED>(3),
            6 => self.eliminate::<FUSED>(6),
            9 => self.eliminate::<FUSED>(9),
            12 => self.eliminate::<FUSED>(12),
            b => self.eliminate::<FUSED>(b),
        }
    }
}

impl<P: BorderedProblem> Eliminate<'_, P> {
    #[inline(always)]
    fn eliminate<const FUSED: bool>(self, b: usize) {
        let Self { problem, program, robust, point, blocks, damping, scratch, sums } = self;
        sums.clear();
        let block_len = point.block_len(program.block_count);
        for block in blocks {
            let compiled = &program.patterns[problem.pattern_of(block)];
            let local = &point.blocks[block * block_len..][..block_len];
            sums.twice_cost +=
                scratch.linearise(problem, compiled, robust, block, &point.shared, local);
            add_shared::<FUSED>(program.width, compiled, scratch, sums);
            if program.is_held(block) {
                continue;
            }
            scratch.form::<FUSED>(b, compiled, |i, residuals, _| residuals[i]);
            couple::<FUSED>(b, program.width, compiled, scratch, &mut sums.y);
            let least = scratch.factor::<FUSED>(b, damping);
            sums.least_pivot = sums.least_pivot.min(least);
            forward::<FUSED>(b, program, scratch, &mut sums.y);
            for row in sums.y.chunks_exact(program.width) {
                sums.promised = mul_add::<FUSED>(row[0], row[0], sums.promised);
            }
            downdate::<FUSED>(b, program, &sums.y, &mut sums.reduced);
        }
    }
}

/// Adds `[r J_s]ᵀ[r J_s]`.
#[inline(always)]
fn add_shared<const FUSED: bool>(
    width: usize,
    compiled: &Compiled,
    scratch: &Scratch,
    sums: &mut Sums,
) {
    for (row, r) in compiled.rows.iter().zip(&scratch.residuals) {
        let entries = &compiled.entries[row.entries.clone()];
        for (i, a) in entries.iter().enumerate() {
            let value = scratch.by_shared[a.value];
            sums.reduced[a.column] = mul_add::<FUSED>(*r, value, sums.reduced[a.column]);
            sums.diagonal[a.column] = mul_add::<FUSED>(value, value, sums.diagonal[a.column]);
            for b in &entries[i..] {
                let at = &mut sums.reduced[a.column * width + b.column];
                *at = mul_add::<FUSED>(value, scratch.by_shared[b.value], *at);
            }
        }
    }
}

/// `[g_b W]`, with `W = J_bᵀ J_s`.
#[inline(always)]
fn couple<const FUSED: bool>(
    b: usize,
    width: usize,
    compiled: &Compiled,
    scratch: &Scratch,
    y: &mut [f64],
) {
    y.fill(0.0);
    for (row, gradient) in scratch.step[..b].iter().enumerate() {
        y[row * width] = *gradient;
    }
    for row in &compiled.rows {
        let columns = &compiled.block_columns[row.by_block.clone()];
        let values = &scratch.by_block[row.by_block.clone()];
        for entry in &compiled.entries[row.entries.clone()] {
            let shared = scratch.by_shared[entry.value];
            for (&column, &value) in columns.iter().zip(values) {
                let at = &mut y[column * width + entry.column];
                *at = mul_add::<FUSED>(value, shared, *at);
            }
        }
    }
}

/// `Y ← L⁻¹ Y`, leaving out what is nought.
#[inline(always)]
fn forward<const FUSED: bool>(b: usize, program: &Program, scratch: &Scratch, y: &mut [f64]) {
    let width = program.width;
    for r in 0..b {
        let (above, below) = y.split_at_mut(r * width);
        let inverse = scratch.inverse_diagonal[r];
        let factor = &scratch.v[r * b..][..r];
        let tiles = below[..width].as_chunks_mut::<TILE>().0;
        for (t, (tile, &first)) in tiles.iter_mut().zip(&program.first).enumerate() {
            if first > r {
                continue;
            }
            for c in first..r {
                let known = &above[c * width + t * TILE..][..TILE];
                for z in 0..TILE {
                    tile[z] = mul_add::<FUSED>(-factor[c], known[z], tile[z]);
                }
            }
            for v in tile {
                *v *= inverse;
            }
        }
    }
}

/// `M ← M − Yᵀ Y` on and above the diagonal tiles, leaving out what is nought.
#[inline(always)]
fn downdate<const FUSED: bool>(b: usize, program: &Program, y: &[f64], reduced: &mut [f64]) {
    let width = program.width;
    for top in (0..width).step_by(TILE_ROWS) {
        let first_row = program.first[top / TILE];
        for t in top / TILE..width / TILE {
            let left = t * TILE;
            let mut tile = [[0.0; TILE]; TILE_ROWS];
            for (q, row) in tile.iter_mut().enumerate() {
                row.copy_from_slice(&reduced[(top + q) * width + left..][..TILE]);
            }
            for k in first_row.max(program.first[t])..b {
                let line = &y[k * width..][..width];
                let factors: &[f64; TILE_ROWS] =
                    line[top..].first_chunk().expect("the width is a multiple of the tile's");
                let values: &[f64; TILE] =
                    line[left..].first_chunk().expect("the width is a multiple of the tile's");
                for q in 0..TILE_ROWS {
                    for z in 0..TILE {
                        tile[q][z] = mul_add::<FUSED>(-factors[q], values[z], tile[q][z]);
                    }
                }
            }
            for (q, row) in tile.iter().enumerate() {
                reduced[(top + q) * width + left..][..TILE].copy_from_slice(row);
            }
        }
    }
}
