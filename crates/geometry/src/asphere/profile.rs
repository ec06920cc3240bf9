use super::interval::Interval;

/// Sag as a function of `s = r²`: `z = c s/(1 + √(1 − q s)) + Σ A_2i s^i`, with `q = (1 + k) c²`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Profile {
    curvature: f64,
    squeeze: f64,
    /// `A4, A6, …`: entry i multiplies `s^(i+2)`.
    terms: Vec<f64>,
}

/// Sag with its first and second derivative by `s = r²`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<T> {
    pub(super) z: T,
    pub(super) dz: T,
    pub(super) ddz: T,
}

/// Sag with its first and second derivative by `r`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meridian<T> {
    pub(super) z: T,
    pub(super) slope: T,
    pub(super) bend: T,
}

impl Profile {
    pub(super) fn new(radius_mm: f64, conic: f64, terms: Vec<f64>) -> Self {
        let curvature = 1.0 / radius_mm;
        Self { curvature, squeeze: (1.0 + conic) * curvature * curvature, terms }
    }

    /// Distance from the axis at which the conic ends; infinite unless `k > −1`.
    pub(super) fn limit(&self) -> f64 {
        if self.squeeze > 0.0 { self.squeeze.sqrt().recip() } else { f64::INFINITY }
    }

    /// At one `s`; NaN beyond the conic's end.
    pub(super) fn jet(&self, s: f64) -> Jet<f64> {
        let conic = self.conic(s);
        let [mut q, mut dq, mut half_ddq] = [0.0; 3];
        for &term in self.terms.iter().rev() {
            half_ddq = half_ddq * s + dq;
            dq = dq * s + q;
            q = q * s + term;
        }
        Jet {
            z: conic.z + s * s * q,
            dz: conic.dz + s * (2.0 * q + s * dq),
            ddz: conic.ddz + 2.0 * q + s * (4.0 * dq + 2.0 * s * half_ddq),
        }
    }

    /// At one `r`; NaN beyond the conic's end.
    pub(super) fn meridian(&self, r: f64) -> Meridian<f64> {
        let s = r * r;
        let jet = self.jet(s);
        Meridian { z: jet.z, slope: 2.0 * r * jet.dz, bend: 2.0 * jet.dz + 4.0 * s * jet.ddz }
    }

    /// Bounds over a range of `s ≥ 0` within the conic: each part is monotone in `s`.
    pub(super) fn jet_over(&self, s: Interval) -> Jet<Interval> {
        let (lo, hi) = (self.conic(s.lo), self.conic(s.hi));
        let mut out = Jet {
            z: Interval::between(lo.z, hi.z),
            dz: Interval::between(lo.dz, hi.dz),
            ddz: Interval::between(lo.ddz, hi.ddz),
        };
        let mut power = Interval::point(1.0);
        let mut exponent = 2.0;
        for &term in &self.terms {
            let next = Interval { lo: power.lo * s.lo, hi: power.hi * s.hi };
            let after = Interval { lo: next.lo * s.lo, hi: next.hi * s.hi };
            out.z = out.z + after.scale(term);
            out.dz = out.dz + next.scale(exponent * term);
            out.ddz = out.ddz + power.scale(exponent * (exponent - 1.0) * term);
            power = next;
            exponent += 1.0;
        }
        out
    }

    /// Bounds over a range of `r ≥ 0` within the conic.
    pub(super) fn meridian_over(&self, r: Interval) -> Meridian<Interval> {
        let s = r.square();
        let jet = self.jet_over(s);
        Meridian {
            z: jet.z,
            slope: (r * jet.dz).scale(2.0),
            bend: jet.dz.scale(2.0) + (s * jet.ddz).scale(4.0),
        }
    }

    fn conic(&self, s: f64) -> Jet<f64> {
        let root = (1.0 - self.squeeze * s).sqrt();
        let dz = 0.5 * self.curvature / root;
        Jet {
            z: self.curvature * s / (1.0 + root),
            dz,
            ddz: 0.5 * dz * self.squeeze / (root * root),
        }
    }
}
