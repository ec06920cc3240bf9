//! Scalar coefficients of exp, log and their Jacobians; the only place they are computed.
//!
//! All are even functions of a rotation angle, finite at zero, and within 4 ε (ε = 2⁻⁵²) of the
//! true value for every angle from 0 to π; most hold to 2π. Where the textbook form cancels,
//! a power series or a half-angle form takes its place. A non-finite angle gives NaN.

use std::f64::consts::{FRAC_PI_2, PI};

/// `sin θ / θ`.
#[must_use]
pub fn sinc(angle_rad: f64) -> f64 {
    if angle_rad == 0.0 { 1.0 } else { angle_rad.sin() / angle_rad }
}

/// `(1 − cos θ) / θ²`, from `1 − cos θ = 2 sin²(θ/2)`.
#[must_use]
pub fn cosc(angle_rad: f64) -> f64 {
    let half = sinc(0.5 * angle_rad);
    0.5 * half * half
}

/// `(θ − sin θ) / θ³`.
#[must_use]
pub fn sinc_remainder(angle_rad: f64) -> f64 {
    let square = angle_rad * angle_rad;
    if square < 1.0 {
        horner(square, &SINC_REMAINDER)
    } else {
        (angle_rad - angle_rad.sin()) / (square * angle_rad)
    }
}

/// `(θ²/2 + cos θ − 1) / θ⁴`.
///
/// With `h = θ/2` the numerator is `2 (h − sin h)(h + sin h)`.
#[must_use]
pub fn cosc_remainder(angle_rad: f64) -> f64 {
    let half = 0.5 * angle_rad;
    0.125 * sinc_remainder(half) * (1.0 + sinc(half))
}

/// `(2 θ − 3 sin θ + θ cos θ) / (2 θ⁵)`, the last coefficient of the SE(3) Jacobian.
#[must_use]
pub fn quintic_remainder(angle_rad: f64) -> f64 {
    let square = angle_rad * angle_rad;
    if square < PI * PI {
        horner(square, &QUINTIC_REMAINDER)
    } else {
        let (sin, cos) = angle_rad.sin_cos();
        (angle_rad * (2.0 + cos) - 3.0 * sin) / (2.0 * square * square * angle_rad)
    }
}

/// `(θ/2) cot(θ/2)`.
///
#[must_use]
pub fn half_cot(angle_rad: f64) -> f64 {
    let half = 0.5 * angle_rad;
    half.cos() / sinc(half)
}

/// `(1 − (θ/2) cot(θ/2)) / θ²`, the coefficient of the inverse Jacobians; infinite at 2π.
///
/// With `h = θ/2` it is `j₁(h)/h / (4 sin h / h)`, `j₁` the spherical Bessel function.
#[must_use]
pub fn inverse_remainder(angle_rad: f64) -> f64 {
    let half = 0.5 * angle_rad;
    let square = half * half;
    let (sin, cos) = half.sin_cos();
    let bessel = if half.abs() <= FRAC_PI_2 {
        horner(square, &BESSEL)
    } else {
        (sin - half * cos) / (square * half)
    };
    let sinc = if half == 0.0 { 1.0 } else { sin / half };
    0.25 * bessel / sinc
}

/// `Σ (−1)^k θ^2k / (2k+3)!`; the first term left out is below 2⁻⁵⁵ of the sum for θ < 1.
const SINC_REMAINDER: [f64; 9] = series(3, 1.0, 0.0);

/// `Σ (−1)^k (k+1) θ^2k / (2k+5)!`; the first term left out is below 2⁻⁵⁵ of the sum for θ < π.
const QUINTIC_REMAINDER: [f64; 14] = series(5, 1.0, 1.0);

/// `Σ (−1)^k (2k+2) h^2k / (2k+3)!`; the first term left out is below 2⁻⁵⁵ of the sum for
/// h ≤ π/2.
const BESSEL: [f64; 11] = series(3, 2.0, 2.0);

/// `(−1)^k (constant + slope k) / (2k + first)!` for k below `N`.
const fn series<const N: usize>(first: u32, constant: f64, slope: f64) -> [f64; N] {
    let mut factorial = 1.0;
    let mut n = 1;
    while n <= first {
        factorial *= n as f64;
        n += 1;
    }
    let mut terms = [0.0; N];
    let mut k = 0;
    let mut sign = 1.0;
    let mut numerator = constant;
    while k < N {
        terms[k] = sign * numerator / factorial;
        factorial *= (n * (n + 1)) as f64;
        n += 2;
        k += 1;
        numerator += slope;
        sign = -sign;
    }
    terms
}

fn horner<const N: usize>(square: f64, terms: &[f64; N]) -> f64 {
    terms.iter().rev().fold(0.0, |sum, term| sum * square + term)
}
