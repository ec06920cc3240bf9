//! Polynomials of one variable and their real roots.

use std::ops::ControlFlow;

/// Highest total degree of a term; freeform optics use some ten.
pub(crate) const MAX_DEGREE: usize = 24;

/// Coefficients, the constant first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Univariate {
    coefficients: [f64; MAX_DEGREE + 1],
    degree: usize,
}

/// Share of the largest coefficient below which a leading one is round-off.
const NOTHING: f64 = 1e-14;
/// Value, relative to the sum of magnitudes, at which an extremum touches zero.
const TOUCHES: f64 = 1e-14;

impl Univariate {
    pub(crate) fn linear([constant, slope]: [f64; 2]) -> Self {
        let mut coefficients = [0.0; MAX_DEGREE + 1];
        coefficients[0] = constant;
        coefficients[1] = slope;
        Self { coefficients, degree: 1 }
    }

    /// All powers of `constant + slope t`.
    pub(crate) fn powers(of: [f64; 2]) -> [Self; MAX_DEGREE + 1] {
        let mut one = Self { coefficients: [0.0; MAX_DEGREE + 1], degree: 0 };
        one.coefficients[0] = 1.0;
        let mut powers = [one; MAX_DEGREE + 1];
        for k in 1..=MAX_DEGREE {
            let before = powers[k - 1];
            let next = &mut powers[k];
            next.degree = k;
            next.coefficients[0] = of[0] * before.coefficients[0];
            for m in 1..=k {
                next.coefficients[m] =
                    of[0] * before.coefficients[m] + of[1] * before.coefficients[m - 1];
            }
        }
        powers
    }

    /// Takes away `factor · a · b`.
    pub(crate) fn subtract_product(&mut self, a: &Self, b: &Self, factor: f64) {
        for i in 0..=a.degree {
            for j in 0..=b.degree {
                self.coefficients[i + j] -= factor * a.coefficients[i] * b.coefficients[j];
            }
        }
    }

    /// Without leading zeros; `None` where nothing is left.
    pub(crate) fn trimmed(mut self, degree: usize) -> Option<Self> {
        let highest = degree.max(1);
        let largest = self.coefficients.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let is_something = |k: &usize| self.coefficients[*k].abs() > NOTHING * largest;
        self.degree = (0..=highest).rev().find(is_something)?;
        Some(self)
    }

    fn derivative(&self) -> Self {
        let mut out = Self { coefficients: [0.0; MAX_DEGREE + 1], degree: self.degree.max(1) - 1 };
        for k in 1..=self.degree {
            #[expect(clippy::cast_precision_loss, reason = "degrees are below 25")]
            let factor = k as f64;
            out.coefficients[k - 1] = factor * self.coefficients[k];
        }
        out
    }

    fn at(&self, t: f64) -> f64 {
        self.coefficients[..=self.degree].iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    fn magnitude_at(&self, t: f64) -> f64 {
        let t = t.abs();
        self.coefficients[..=self.degree].iter().rev().fold(0.0, |sum, c| sum * t + c.abs())
    }

    /// Cauchy's bound on the size of every root.
    fn bound(&self) -> f64 {
        let lead = self.coefficients[self.degree].abs();
        let largest = self.coefficients[..self.degree].iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        1.0 + largest / lead
    }

    /// Real roots, ascending, until `visit` breaks off; a double root comes once.
    ///
    /// Between the extrema, which are the roots of the derivative, there is at most one root each.
    pub(crate) fn each_root(&self, visit: &mut impl FnMut(f64) -> ControlFlow<()>) {
        let (roots, count) = self.roots();
        for root in &roots[..count] {
            if visit(*root).is_break() {
                return;
            }
        }
    }

    fn roots(&self) -> ([f64; MAX_DEGREE], usize) {
        // Derivatives by their degree.
        let mut chain = [*self; MAX_DEGREE + 1];
        for degree in (1..self.degree).rev() {
            chain[degree] = chain[degree + 1].derivative();
        }
        let mut extrema = ([0.0; MAX_DEGREE], 0);
        for polynomial in &chain[1..=self.degree] {
            extrema = polynomial.between(&extrema.0[..extrema.1]);
        }
        extrema
    }

    /// Roots, given the roots of the derivative.
    fn between(&self, extrema: &[f64]) -> ([f64; MAX_DEGREE], usize) {
        let (mut roots, mut count) = ([0.0; MAX_DEGREE], 0);
        let mut keep = |root: f64| {
            let is_new = count == 0 || roots[count - 1] < root;
            if is_new && count < MAX_DEGREE {
                roots[count] = root;
                count += 1;
            }
        };
        let bound = self.bound();
        let mut low = -bound;
        for &high in extrema.iter().chain([&bound]) {
            let (a, b) = (self.at(low), self.at(high));
            let touches = b.abs() <= TOUCHES * self.magnitude_at(high);
            if a.signum() * b.signum() < 0.0 && !touches {
                keep(self.bisect(low, high));
            }
            if touches && high < bound {
                keep(high);
            }
            low = high.max(low);
        }
        (roots, count)
    }

    /// The one root between two points of different sign.
    fn bisect(&self, mut low: f64, mut high: f64) -> f64 {
        let rising = self.at(high) > 0.0;
        let slope = self.derivative();
        let mut t = 0.5 * (low + high);
        // Newton where it stays inside, halving where it does not: the halvings alone suffice.
        for _ in 0..200 {
            let value = self.at(t);
            if value == 0.0 {
                return t;
            }
            if (value > 0.0) == rising {
                high = t;
            } else {
                low = t;
            }
            let newton = t - value / slope.at(t);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - t).abs() <= 2.0 * f64::EPSILON * t.abs() {
                return next;
            }
            t = next;
        }
        t
    }
}
