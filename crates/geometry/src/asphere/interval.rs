use std::ops::{Add, Mul};

/// Closed interval `[lo, hi]`: the range a quantity takes over a cell.
///
/// Not rounded outwards; users leave a margin of round-off where they exclude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) lo: f64,
    pub(super) hi: f64,
}

impl Interval {
    /// Between two values in any order.
    pub(super) fn between(a: f64, b: f64) -> Self {
        Self { lo: a.min(b), hi: a.max(b) }
    }

    pub(super) fn point(value: f64) -> Self {
        Self { lo: value, hi: value }
    }

    pub(super) fn contains_zero(self, margin: f64) -> bool {
        self.lo <= margin && self.hi >= -margin
    }

    /// Largest absolute value.
    pub(super) fn magnitude(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// Smallest absolute value.
    pub(super) fn mignitude(self) -> f64 {
        if self.contains_zero(0.0) { 0.0 } else { self.lo.abs().min(self.hi.abs()) }
    }

    pub(super) fn square(self) -> Self {
        Self { lo: self.mignitude().powi(2), hi: self.magnitude().powi(2) }
    }

    pub(super) fn scale(self, factor: f64) -> Self {
        Self::between(self.lo * factor, self.hi * factor)
    }

    pub(super) fn midpoint(self) -> f64 {
        0.5 * (self.lo + self.hi)
    }

    pub(super) fn width(self) -> f64 {
        self.hi - self.lo
    }

    /// Lower and upper half.
    pub(super) fn halves(self) -> [Self; 2] {
        let middle = self.midpoint();
        [Self { lo: self.lo, hi: middle }, Self { lo: middle, hi: self.hi }]
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { lo: self.lo + other.lo, hi: self.hi + other.hi }
    }
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let [a, b] = [self.lo * other.lo, self.lo * other.hi];
        let [c, d] = [self.hi * other.lo, self.hi * other.hi];
        Self { lo: a.min(b).min(c).min(d), hi: a.max(b).max(c).max(d) }
    }
}
