//! The reduced matrix in tiles, and its rank update.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::lanes::LANES;
use super::program::{PANEL, Program};
use super::simd::mul_add;

type Tile = [[f64; PANEL]; PANEL];

/// Upper triangle of a symmetric matrix: for each panel of rows its tiles from the diagonal on.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    panels: usize,
    tiles: Vec<Tile>,
}

impl Panels {
    pub(super) fn new(panels: usize) -> Self {
        Self { panels, tiles: vec![[[0.0; PANEL]; PANEL]; panels * (panels + 1) / 2] }
    }

    pub(super) fn clear(&mut self) {
        self.tiles.fill([[0.0; PANEL]; PANEL]);
    }

    pub(super) fn add(&mut self, other: &Self) {
        let own = self.tiles.as_flattened_mut().as_flattened_mut();
        for (a, b) in own.iter_mut().zip(other.tiles.as_flattened().as_flattened()) {
            *a += b;
        }
    }

    /// Place of the diagonal tile of a panel of rows.
    #[inline(always)]
    fn start(&self, panel: usize) -> usize {
        panel * self.panels - panel * panel.saturating_sub(1) / 2
    }

    /// Entry of the matrix; the row is not below the column.
    pub(super) fn entry(&self, row: usize, column: usize) -> f64 {
        let (panel, other) = (row / PANEL, column / PANEL);
        self.tiles[self.start(panel) + other - panel][row % PANEL][column % PANEL]
    }
}

/// `M ← M − Yᵀ Y`, leaving out what is nought.
#[inline(always)]
pub(super) fn downdate<const FUSED: bool>(
    b: usize,
    program: &Program,
    y: &[[f64; PANEL]],
    m: &mut Panels,
) {
    let height = b * LANES;
    let panels = program.first.len();
    for p in 0..panels {
        let start = m.start(p);
        let (mut q, own) = (p, &y[p * height..][..height]);
        let tiles = &mut m.tiles[start..start + panels - p];
        let (pairs, rest) = tiles.as_chunks_mut::<2>();
        for [left, right] in pairs {
            let first = program.first[q].min(program.first[q + 1]);
            let from = first.max(program.first[p]) * LANES;
            let a = &own[from..];
            let (of_left, of_right) = y[q * height..][..2 * height].split_at(height);
            update_pair::<FUSED>(a, &of_left[from..], &of_right[from..], left, right);
            q += 2;
        }
        for tile in rest {
            let from = program.first[q].max(program.first[p]) * LANES;
            update::<FUSED>(&own[from..], &y[q * height..][from..height], tile);
        }
    }
}

#[inline(always)]
fn update_pair<const FUSED: bool>(
    a: &[[f64; PANEL]],
    left: &[[f64; PANEL]],
    right: &[[f64; PANEL]],
    left_out: &mut Tile,
    right_out: &mut Tile,
) {
    let (mut l, mut r) = (*left_out, *right_out);
    for ((a, x), y) in a.iter().zip(left).zip(right) {
        for i in 0..PANEL {
            for j in 0..PANEL {
                l[i][j] = mul_add::<FUSED>(-a[i], x[j], l[i][j]);
            }
            for j in 0..PANEL {
                r[i][j] = mul_add::<FUSED>(-a[i], y[j], r[i][j]);
            }
        }
    }
    (*left_out, *right_out) = (l, r);
}

#[inline(always)]
fn update<const FUSED: bool>(a: &[[f64; PANEL]], x: &[[f64; PANEL]], out: &mut Tile) {
    let mut tile = *out;
    for (a, x) in a.iter().zip(x) {
        for i in 0..PANEL {
            for j in 0..PANEL {
                tile[i][j] = mul_add::<FUSED>(-a[i], x[j], tile[i][j]);
            }
        }
    }
    *out = tile;
}
