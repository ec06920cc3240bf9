//! Cholesky factors of small matrices, in place, by rows.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::simd::mul_add;

/// Share of a diagonal entry, left by the rows before it, that is rounding.
const ROUNDING: f64 = 1e-15;

/// Overwrites the lower triangle of `a` by its factor and `inverse_diagonal` by the reciprocals
/// of the factor's diagonal. The diagonal of `a` is raised by the factor `1 + damping` before.
///
/// Returns the least share of a diagonal entry that the rows before leave of it. A row that
/// they determine, where that share is nought or rounding, is cut off: its reciprocal is nought.
#[inline(always)]
pub(super) fn factor<const FUSED: bool>(
    n: usize,
    a: &mut [f64],
    inverse_diagonal: &mut [f64],
    damping: f64,
) -> f64 {
    let mut least = 1.0_f64;
    for c in 0..n {
        let (above, below) = a.split_at_mut((c + 1) * n);
        let row = &mut above[c * n..];
        let entry = row[c] * (1.0 + damping);
        let mut left = entry;
        for known in &row[..c] {
            left = mul_add::<FUSED>(-known, *known, left);
        }
        let share = left / entry;
        // Not `<=`, so that NaN and an entry of nought are cut off too.
        let is_good = share > ROUNDING;
        least = least.min(if is_good { share } else { 0.0 });
        let inverse = if is_good { 1.0 / left.sqrt() } else { 0.0 };
        inverse_diagonal[c] = inverse;
        row[c] = left * inverse;
        for other in below.chunks_exact_mut(n) {
            let mut sum = other[c];
            for (a, b) in other[..c].iter().zip(&row[..c]) {
                sum = mul_add::<FUSED>(-a, *b, sum);
            }
            other[c] = sum * inverse;
        }
    }
    least
}

/// Overwrites `x` by the solution of `L Lᵀ x = x`; nought where a row was cut off.
#[inline(always)]
pub(super) fn solve<const FUSED: bool>(
    n: usize,
    factor: &[f64],
    inverse_diagonal: &[f64],
    x: &mut [f64],
) {
    for r in 0..n {
        let mut left = x[r];
        for c in 0..r {
            left = mul_add::<FUSED>(-factor[r * n + c], x[c], left);
        }
        x[r] = left * inverse_diagonal[r];
    }
    for r in (0..n).rev() {
        let known = x[r] * inverse_diagonal[r];
        x[r] = known;
        for c in 0..r {
            x[c] = mul_add::<FUSED>(-factor[r * n + c], known, x[c]);
        }
    }
}
