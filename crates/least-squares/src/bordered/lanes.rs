//! Four blocks side by side, one per lane of a vector register.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::simd::mul_add;

/// Blocks that are handled together.
pub(super) const LANES: usize = 4;

/// One number of each of four blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// `self · other + sum`.
    #[inline(always)]
    pub(super) fn mul_add<const FUSED: bool>(self, other: Self, sum: Self) -> Self {
        let mut out = sum;
        for lane in 0..LANES {
            out.0[lane] = mul_add::<FUSED>(self.0[lane], other.0[lane], sum.0[lane]);
        }
        out
    }

    /// `from − self · other`.
    #[inline(always)]
    pub(super) fn mul_sub_from<const FUSED: bool>(self, other: Self, from: Self) -> Self {
        let mut out = from;
        for lane in 0..LANES {
            out.0[lane] = mul_add::<FUSED>(-self.0[lane], other.0[lane], from.0[lane]);
        }
        out
    }

    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        let mut out = self;
        for lane in 0..LANES {
            out.0[lane] *= other.0[lane];
        }
        out
    }

    #[inline(always)]
    pub(super) fn over(self, other: Self) -> Self {
        let mut out = self;
        for lane in 0..LANES {
            out.0[lane] /= other.0[lane];
        }
        out
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        let mut out = self;
        for lane in 0..LANES {
            out.0[lane] = out.0[lane].sqrt();
        }
        out
    }

    /// The lesser of each two; `other` holds no NaN.
    #[inline(always)]
    pub(super) fn least(self, other: Self) -> Self {
        let mut out = self;
        for lane in 0..LANES {
            let (a, b) = (self.0[lane], other.0[lane]);
            out.0[lane] = if b < a { b } else { a };
        }
        out
    }

    /// Itself where `share` is above the limit, nought elsewhere.
    #[inline(always)]
    pub(super) fn where_above(self, share: Self, limit: f64) -> Self {
        let mut out = self;
        for lane in 0..LANES {
            // Not `<=`, so that NaN counts as below.
            out.0[lane] = if share.0[lane] > limit { self.0[lane] } else { 0.0 };
        }
        out
    }

    pub(super) fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }
}
