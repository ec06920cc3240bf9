//! Matrices by rows, a few vectors of some rows at a time: sums stay in registers.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use pulp::Simd;

/// Rows are filled up with noughts to a multiple of so many numbers.
pub(super) const TILE: usize = 8;
/// Rows that are handled together: with two vectors of each, as many as there are registers for.
pub(super) const ROWS: usize = 6;

/// Rows of one width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<'a, S: Simd> {
    vectors: &'a [S::f64s],
    /// Vectors of a row.
    width: usize,
}

impl<'a, S: Simd> Rows<'a, S> {
    /// `width` is a multiple of [`TILE`].
    #[inline(always)]
    pub(super) fn new(numbers: &'a [f64], width: usize) -> Self {
        Self { vectors: S::as_simd_f64s(numbers).0, width: width / S::F64_LANES }
    }
}

/// `to ← to + a · from`, with the coefficients `a` and what they add to by rows; `from` has `depth`
/// rows or more, and where it is so many `rows_above` an upper triangle noughts below that.
#[inline(always)]
pub(super) fn add_product<S: Simd>(
    simd: S,
    a: &[f64],
    depth: usize,
    from: Rows<'_, S>,
    rows_above: Option<usize>,
    to: &mut [f64],
) {
    let width = from.width;
    if width == 0 || depth == 0 {
        return;
    }
    let to = S::as_mut_simd_f64s(to).0;
    for (a, to) in a.chunks(ROWS * depth).zip(to.chunks_mut(ROWS * width)) {
        let last = to.len() / width - 1;
        // Missing rows are the last one again.
        let rows: [&[f64]; ROWS] = std::array::from_fn(|i| &a[i.min(last) * depth..][..depth]);
        for at in (0..width).step_by(2) {
            let [left, right] = [at, (at + 1).min(width - 1)];
            // Below its diagonal there is nothing.
            let end = rows_above.map_or(depth, |rows| ((at + 2) * S::F64_LANES + rows).min(depth));
            let rows = rows.map(|row| &row[..end]);
            let mut sums = [[simd.splat_f64s(0.0); 2]; ROWS];
            for (i, sums) in sums.iter_mut().enumerate() {
                let row = &to[i.min(last) * width..][..width];
                *sums = [row[left], row[right]];
            }
            for (k, from) in (0..end).zip(from.vectors.chunks_exact(width)) {
                let from = [from[left], from[right]];
                for (sums, row) in sums.iter_mut().zip(rows) {
                    let factor = simd.splat_f64s(row[k]);
                    for (sum, from) in sums.iter_mut().zip(from) {
                        *sum = simd.mul_add_e_f64s(factor, from, *sum);
                    }
                }
            }
            for (sums, row) in sums.iter().zip(to.chunks_exact_mut(width)) {
                [row[left], row[right]] = *sums;
            }
        }
    }
}

/// Squares of `Σ factor · row` over given rows of two matrices, added up over all columns.
#[inline(always)]
pub(super) fn squares<S: Simd>(
    simd: S,
    first: &(impl Iterator<Item = (usize, f64)> + Clone, Rows<'_, S>),
    second: &(impl Iterator<Item = (usize, f64)> + Clone, Rows<'_, S>),
) -> f64 {
    let width = first.1.width;
    let mut squares = [simd.splat_f64s(0.0); TILE];
    let mut at = 0;
    while at < width {
        let (first, second, into) = (first.clone(), second.clone(), &mut squares);
        at += match width - at {
            1 => add_squares::<S, 1>(simd, first, second, at, into),
            2 | 3 => add_squares::<S, 2>(simd, first, second, at, into),
            4 | 5 => add_squares::<S, 4>(simd, first, second, at, into),
            6 | 7 => add_squares::<S, 6>(simd, first, second, at, into),
            _ => add_squares::<S, 8>(simd, first, second, at, into),
        };
    }
    let mut sums = [0.0; TILE];
    for (sum, square) in S::as_mut_simd_f64s(&mut sums).0.iter_mut().zip(squares) {
        *sum = square;
    }
    sums.iter().sum()
}

/// Of so many vectors of every row; their number.
#[inline(always)]
fn add_squares<S: Simd, const N: usize>(
    simd: S,
    first: (impl Iterator<Item = (usize, f64)>, Rows<'_, S>),
    second: (impl Iterator<Item = (usize, f64)>, Rows<'_, S>),
    at: usize,
    squares: &mut [S::f64s; TILE],
) -> usize {
    let mut sums = [simd.splat_f64s(0.0); N];
    for (row, factor) in first.0 {
        add_scaled(simd, &mut sums, factor, &first.1.vectors[row * first.1.width + at..][..N]);
    }
    for (row, factor) in second.0 {
        add_scaled(simd, &mut sums, factor, &second.1.vectors[row * second.1.width + at..][..N]);
    }
    for (n, sum) in sums.into_iter().enumerate() {
        let square = &mut squares[(at + n) % (TILE / S::F64_LANES)];
        *square = simd.mul_add_e_f64s(sum, sum, *square);
    }
    N
}

/// `to ← to + factor · from`. No closure: what the compiler does not inline of one goes without vectors.
#[inline(always)]
fn add_scaled<S: Simd>(simd: S, to: &mut [S::f64s], factor: f64, from: &[S::f64s]) {
    let factor = simd.splat_f64s(factor);
    for (to, from) in to.iter_mut().zip(from) {
        *to = simd.mul_add_e_f64s(factor, *from, *to);
    }
}
