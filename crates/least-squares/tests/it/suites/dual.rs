//! Forward-mode derivatives of the suites' models: exact to rounding, written once per model.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Most parameters of any suite problem (Osborne 2).
pub(crate) const MAX_PARAMETERS: usize = 11;

/// A value with its gradient by the parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual {
    pub(crate) value: f64,
    pub(crate) slope: [f64; MAX_PARAMETERS],
}

impl Dual {
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, slope: [0.0; MAX_PARAMETERS] }
    }

    pub(crate) fn parameters(values: &[f64]) -> Vec<Self> {
        let mut parameters: Vec<_> = values.iter().map(|v| Self::constant(*v)).collect();
        for (i, p) in parameters.iter_mut().enumerate() {
            p.slope[i] = 1.0;
        }
        parameters
    }

    /// `f(self)` where `f` has this value and this derivative.
    fn chain(self, value: f64, derivative: f64) -> Self {
        Self { value, slope: self.slope.map(|s| derivative * s) }
    }

    pub(crate) fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }

    pub(crate) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    pub(crate) fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    pub(crate) fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    pub(crate) fn atan(self) -> Self {
        self.chain(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }

    pub(crate) fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }

    pub(crate) fn powi(self, n: i32) -> Self {
        self.chain(self.value.powi(n), f64::from(n) * self.value.powi(n - 1))
    }

    pub(crate) fn square(self) -> Self {
        self * self
    }

    /// `self` to a power that is itself a function of the parameters; `self` is positive.
    pub(crate) fn powd(self, power: Self) -> Self {
        let value = self.value.powf(power.value);
        let by_base = power.value * self.value.powf(power.value - 1.0);
        let by_power = if self.value == 0.0 { 0.0 } else { value * self.value.ln() };
        combine(value, (self, by_base), (power, by_power))
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

/// `value` with the gradient `by_a ∇a + by_b ∇b`.
fn combine(value: f64, (a, by_a): (Dual, f64), (b, by_b): (Dual, f64)) -> Dual {
    let slope = std::array::from_fn(|i| by_a * a.slope[i] + by_b * b.slope[i]);
    Dual { value, slope }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<T: Into<Self>> Add<T> for Dual {
    type Output = Self;
    fn add(self, other: T) -> Self {
        let other = other.into();
        combine(self.value + other.value, (self, 1.0), (other, 1.0))
    }
}

impl<T: Into<Self>> Sub<T> for Dual {
    type Output = Self;
    fn sub(self, other: T) -> Self {
        let other = other.into();
        combine(self.value - other.value, (self, 1.0), (other, -1.0))
    }
}

impl<T: Into<Self>> Mul<T> for Dual {
    type Output = Self;
    fn mul(self, other: T) -> Self {
        let other = other.into();
        combine(self.value * other.value, (self, other.value), (other, self.value))
    }
}

impl<T: Into<Self>> Div<T> for Dual {
    type Output = Self;
    fn div(self, other: T) -> Self {
        let other = other.into();
        let quotient = self.value / other.value;
        combine(quotient, (self, other.value.recip()), (other, -quotient / other.value))
    }
}
