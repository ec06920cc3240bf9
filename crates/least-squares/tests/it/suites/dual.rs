//! Forward-mode derivatives of the suites' models: exact to rounding, written once per model.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Most parameters of any suite problem (Osborne 2).
pub const MAX_PARAMETERS: usize = 11;

/// A value with its gradient by the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    pub value: f64,
    pub slope: [f64; MAX_PARAMETERS],
}

impl Dual {
    pub fn constant(value: f64) -> Self {
        Self { value, slope: [0.0; MAX_PARAMETERS] }
    }

    pub fn parameters(values: &[f64]) -> Vec<Self> {
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

    pub fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }

    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    pub fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    pub fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    pub fn atan(self) -> Self {
        self.chain(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }

    pub fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }

    pub fn powi(self, n: i32) -> Self {
        self.chain(self.value.powi(n), f64::from(n) * self.value.powi(n - 1))
    }

    pub fn square(self) -> Self {
        self * self
    }

    /// `self` to a power that is itself a function of the parameters; `self` is positive.
    pub fn powd(self, power: Self) -> Self {
        let value = self.value.powf(power.value);
        let by_base = power.value * self.value.powf(power.value - 1.0);
        let by_power = if self.value == 0.0 { 0.0 } else { value * self.value.ln() };
        let mut slope = self.slope.map(|s| by_base * s);
        for (total, s) in slope.iter_mut().zip(power.slope) {
            *total += by_power * s;
        }
        Self { value, slope }
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<T: Into<Dual>> Add<T> for Dual {
    type Output = Self;
    fn add(self, other: T) -> Self {
        let other = other.into();
        let mut slope = self.slope;
        slope.iter_mut().zip(other.slope).for_each(|(a, b)| *a += b);
        Self { value: self.value + other.value, slope }
    }
}

impl<T: Into<Dual>> Sub<T> for Dual {
    type Output = Self;
    fn sub(self, other: T) -> Self {
        self + -other.into()
    }
}

impl<T: Into<Dual>> Mul<T> for Dual {
    type Output = Self;
    fn mul(self, other: T) -> Self {
        let other = other.into();
        let mut slope = self.slope.map(|s| s * other.value);
        slope.iter_mut().zip(other.slope).for_each(|(a, b)| *a += self.value * b);
        Self { value: self.value * other.value, slope }
    }
}

impl<T: Into<Dual>> Div<T> for Dual {
    type Output = Self;
    fn div(self, other: T) -> Self {
        let other = other.into();
        let value = self.value / other.value;
        let mut slope = self.slope.map(|s| s / other.value);
        slope.iter_mut().zip(other.slope).for_each(|(a, b)| *a -= value / other.value * b);
        Self { value, slope }
    }
}
