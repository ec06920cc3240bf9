//! Cholesky factors of four small matrices side by side.
//!
//! Triangles are packed by rows: entry `(r, c)` is at `r (r + 1) / 2 + c`.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::lanes::Lanes;
use super::program::PANEL;

/// Share of a diagonal entry, left by the rows before it, that is rounding.
const ROUNDING: f64 = 1e-15;

/// Place of the first entry of a row.
#[inline(always)]
pub(super) const fn row_start(row: usize) -> usize {
    row * (row + 1) / 2
}

/// Overwrites triangles by their factors, with the reciprocals of the factors' diagonals on the
/// diagonal. The diagonals are raised by the factor `1 + damping` before.
///
/// Returns the least share of a diagonal entry that the rows before leave of it. A row that
/// they determine, where that share is nought or rounding, is cut off: its reciprocal is nought.
#[inline(always)]
pub(super) fn factor<const FUSED: bool>(n: usize, a: &mut [Lanes], damping: f64) -> f64 {
    let mut least = Lanes::splat(1.0);
    let raised = Lanes::splat(1.0 + damping);
    let a = &mut a[..row_start(n)];
    for r in 0..n {
        let (above, row) = a.split_at_mut(row_start(r));
        let row = &mut row[..=r];
        for c in 0..r {
            let other = &above[row_start(c)..][..=c];
            let mut left = row[c];
            for k in 0..c {
                left = row[k].mul_sub_from::<FUSED>(other[k], left);
            }
            row[c] = left.times(other[c]);
        }
        let whole = row[r].times(raised);
        let mut left = whole;
        for value in &row[..r] {
            left = value.mul_sub_from::<FUSED>(*value, left);
        }
        let share = left.over(whole);
        // Of NaN and of an entry of nought too.
        let good = |value: Lanes| value.where_above(share, ROUNDING);
        least = least.least(good(share));
        row[r] = good(Lanes::splat(1.0).over(left.sqrt()));
    }
    least.0.into_iter().fold(1.0, f64::min)
}

/// Overwrites `x` by `L⁻¹ x`.
#[inline(always)]
pub(super) fn forward<const FUSED: bool>(factor: &[Lanes], x: &mut [Lanes]) {
    let mut start = 0;
    for r in 0..x.len() {
        let row = &factor[start..][..=r];
        start += r + 1;
        let (known, rest) = x.split_at_mut(r);
        let mut left = rest[0];
        for (f, k) in row.iter().zip(known) {
            left = f.mul_sub_from::<FUSED>(*k, left);
        }
        rest[0] = left.times(row[r]);
    }
}

/// The same for as many columns as a panel has, by rows from `first` on.
#[inline(always)]
pub(super) fn forward_panel<const FUSED: bool>(
    factor: &[Lanes],
    first: usize,
    x: &mut [[Lanes; PANEL]],
) {
    let mut start = row_start(first);
    for r in 0..x.len() {
        let row = &factor[start + first..][..=r];
        start += first + r + 1;
        let (known, rest) = x.split_at_mut(r);
        let mut left = rest[0];
        for (f, known) in row.iter().zip(known) {
            for c in 0..PANEL {
                left[c] = f.mul_sub_from::<FUSED>(known[c], left[c]);
            }
        }
        for value in &mut left {
            *value = value.times(row[r]);
        }
        rest[0] = left;
    }
}

/// Overwrites `x` by `L⁻ᵀ x`.
#[inline(always)]
pub(super) fn backward<const FUSED: bool>(factor: &[Lanes], x: &mut [Lanes]) {
    for r in (0..x.len()).rev() {
        let row = &factor[row_start(r)..][..=r];
        let known = x[r].times(row[r]);
        x[r] = known;
        for (x, f) in x[..r].iter_mut().zip(row) {
            *x = f.mul_sub_from::<FUSED>(known, *x);
        }
    }
}
