//! One interval of `M·E'' + D·E' + K·E = f`, with time counted in intervals.

use crate::{ForceImpedanceError, ImpedanceParameters};

/// Roots of the characteristic equation nearer to each other than this, relative to their mean,
/// are left to the series: their difference has lost digits.
const SEPARATED: f64 = 0.1;
/// Norm at which 14 terms of the exponential series leave `0.25¹⁵/15! = 1e-21`.
const SERIES_NORM: f64 = 0.25;
const SERIES_TERMS: u32 = 14;

/// `(E, v) ← Φ (E, v) + Γ f + Γ' f_before`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// Row by row; mm, mm/s.
    pub(crate) phi: [[f64; 2]; 2],
    /// Share of the force error at this sample.
    pub(crate) now: [f64; 2],
    /// Share of the force error at the sample before.
    pub(crate) before: [f64; 2],
}

impl Step {
    #[inline]
    pub(crate) fn advance(&self, e: f64, v: f64, f: f64, f_before: f64) -> [f64; 2] {
        let [[p11, p12], [p21, p22]] = self.phi;
        [
            p11 * e + p12 * v + self.now[0] * f + self.before[0] * f_before,
            p21 * e + p22 * v + self.now[1] * f + self.before[1] * f_before,
        ]
    }

    pub(crate) fn is_finite(&self) -> bool {
        let all = [self.phi[0], self.phi[1], self.now, self.before];
        all.iter().flatten().all(|v| v.is_finite())
    }

    /// From time in intervals to seconds.
    fn in_seconds(phi: [[f64; 2]; 2], now: [f64; 2], before: [f64; 2], interval_s: f64) -> Self {
        let t = interval_s;
        Self {
            phi: [[phi[0][0], phi[0][1] * t], [phi[1][0] / t, phi[1][1]]],
            now: [now[0], now[1] / t],
            before: [before[0], before[1] / t],
        }
    }
}

/// Coefficients with time in intervals: `E'' + a1·E' + a0·E = b·f`.
struct Scaled {
    a0: f64,
    a1: f64,
    b: f64,
}

impl Scaled {
    fn of(p: &ImpedanceParameters, interval_s: f64) -> Self {
        let m = p.mass_ns2_per_mm();
        let b = interval_s * interval_s / m;
        Self { a0: p.stiffness_n_per_mm * b, a1: p.damping_ns_per_mm * interval_s / m, b }
    }
}

/// The exact solution for a force error held over the interval.
pub(crate) fn exact_hold(
    p: &ImpedanceParameters,
    interval_s: f64,
) -> Result<Step, ForceImpedanceError> {
    let s = Scaled::of(p, interval_s);
    let half = 0.5 * s.a1;
    let discriminant = half * half - s.a0;
    if s.a1 > 2.0 && discriminant > (SEPARATED * half) * (SEPARATED * half) {
        return Ok(by_roots(&s, half, libm::sqrt(discriminant), interval_s));
    }
    let limit = core::f64::consts::PI;
    if s.a0 >= limit * limit {
        let per_s = libm::sqrt(s.a0) / interval_s;
        return Err(ForceImpedanceError::TooFastForSampling {
            natural_hz: per_s / core::f64::consts::TAU,
            nyquist_hz: 0.5 / interval_s,
        });
    }
    Ok(by_series(&s, interval_s))
}

/// Two real roots well apart, the slow one without cancellation.
fn by_roots(s: &Scaled, half: f64, root: f64, interval_s: f64) -> Step {
    let fast = -(half + root);
    let slow = -s.a0 / (half + root);
    let gap = slow - fast;
    let (of_slow, of_fast) = (libm::exp(slow), libm::exp(fast));
    // ∫₀¹ e^{λt} dt.
    let mean = |l: f64| if l == 0.0 { 1.0 } else { libm::expm1(l) / l };
    let h = (of_slow - of_fast) / gap;
    let phi = [
        [(slow * of_fast - fast * of_slow) / gap, h],
        [-s.a0 * h, (slow * of_slow - fast * of_fast) / gap],
    ];
    let now = [s.b * (mean(slow) - mean(fast)) / gap, s.b * h];
    Step::in_seconds(phi, now, [0.0; 2], interval_s)
}

/// Exponential of the system with its input beside it, by series and squaring.
fn by_series(s: &Scaled, interval_s: f64) -> Step {
    // The input is scaled to one, so that its size takes no part in the norm.
    let norm = 1.0 + s.a0 + s.a1;
    let mut halvings = 0;
    let mut share = 1.0;
    while norm * share > SERIES_NORM && halvings < 64 {
        share *= 0.5;
        halvings += 1;
    }
    let a = [[0.0, share, 0.0], [-s.a0 * share, -s.a1 * share, share], [0.0; 3]];
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut sum = identity;
    // Horner: I + A(I + A/2(I + A/3(…))).
    for k in (1..=SERIES_TERMS).rev() {
        let scaled = product(&a, &sum).map(|row| row.map(|v| v / f64::from(k)));
        sum = identity;
        for (row, more) in sum.iter_mut().zip(scaled) {
            for (v, m) in row.iter_mut().zip(more) {
                *v += m;
            }
        }
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    let phi = [[sum[0][0], sum[0][1]], [sum[1][0], sum[1][1]]];
    Step::in_seconds(phi, [s.b * sum[0][2], s.b * sum[1][2]], [0.0; 2], interval_s)
}

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let [b0, b1, b2] = *b;
    a.map(|[x, y, z]| {
        [
            x * b0[0] + y * b1[0] + z * b2[0],
            x * b0[1] + y * b1[1] + z * b2[1],
            x * b0[2] + y * b1[2] + z * b2[2],
        ]
    })
}

/// `x ← (I − A/2)⁻¹ ((I + A/2) x + B/2 (f + f_before))`.
pub(crate) fn bilinear(p: &ImpedanceParameters, interval_s: f64) -> Step {
    let s = Scaled::of(p, interval_s);
    // (I − A/2)⁻¹ with A = [0 1; −a0 −a1].
    let (c, d) = (0.5 * s.a0, 1.0 + 0.5 * s.a1);
    let determinant = d + 0.5 * c;
    let inverse = [[d / determinant, 0.5 / determinant], [-c / determinant, 1.0 / determinant]];
    let forward = [[1.0, 0.5], [-c, 1.0 - 0.5 * s.a1]];
    let entry = |i: usize, j: usize| inverse[i][0] * forward[0][j] + inverse[i][1] * forward[1][j];
    let phi = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
    let input = [0.5 * s.b * inverse[0][1], 0.5 * s.b * inverse[1][1]];
    Step::in_seconds(phi, input, input, interval_s)
}
