//! What reliability says of a shift, where every figure has a closed form.

use frame_fit::{
    FrameFit, Noise, Options, PointPair, Reliability, SnoopingOptions, Transform, fit_frame,
    reliability,
};
use nalgebra::{Point, SVector, Vector2};

/// A dozen roundings, of readings that are about as large as their differences.
const EXACT_TOL: f64 = 1e-12;
/// Bisection to twelve digits of what is larger by up to 2⁶.
const LEVEL_TOL: f64 = 1e-9;

/// Points that are off a shift by `noise`, and what is said of them.
fn shifted<const D: usize>(
    noise: &[SVector<f64, D>],
    sigma_mm: f64,
    options: Noise,
    significance: f64,
) -> (FrameFit<D>, Vec<Reliability<D>>) {
    let pairs: Vec<PointPair<D>> = noise
        .iter()
        .enumerate()
        .map(|(k, off)| {
            let source =
                Point::from(SVector::from_fn(|i, _| (1.0 + k as f64).powf(1.0 + i as f64)));
            PointPair::isotropic(source, source + SVector::repeat(2.0) + off, sigma_mm)
        })
        .collect();
    let options = Options { noise: options, ..Options::of(Transform::Translation) };
    let fit = fit_frame(&pairs, &options).unwrap();
    // The level of each of n tests, of which none rejects with what is left of one.
    let family_significance = 1.0 - (1.0 - significance).powf(noise.len() as f64);
    let snooping = SnoopingOptions { family_significance, power: 0.8, max_removed: 0 };
    let judged = reliability(&pairs, &fit, &snooping).unwrap();
    (fit, judged)
}

const OFF_MM: [[f64; 2]; 3] = [[0.03, -0.01], [-0.02, 0.04], [0.01, -0.05]];

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
}

/// Each of n points shows 1 − 1/n of its bias. The drop of χ² has two degrees of freedom, whose tail is
/// `exp(−x/2)`, and against two others that of F is what is left over all.
#[test]
fn a_shift_of_three_points() {
    let off = OFF_MM.map(Vector2::from);
    let mean = (off[0] + off[1] + off[2]) / 3.0;
    let chi2_mm2 = off.iter().map(|o| (o - mean).norm_squared()).sum::<f64>();
    let shown: f64 = 2.0 / 3.0;
    let declared_mm: f64 = 0.025;
    for noise in [Noise::Declared, Noise::Estimated] {
        let (_, judged) = shifted(&off, declared_mm, noise, 0.05);
        // Four degrees of freedom.
        let sigma_mm = if noise == Noise::Declared { declared_mm } else { (chi2_mm2 / 4.0).sqrt() };
        for (point, off) in judged.iter().zip(&off) {
            let residual = off - mean;
            let drop = residual.norm_squared() / shown;
            let p_value = match noise {
                Noise::Declared => (-0.5 * drop / declared_mm.powi(2)).exp(),
                Noise::Estimated => 1.0 - drop / chi2_mm2,
            };
            assert_near(point.p_value, p_value, EXACT_TOL);
            assert_near(point.chi2_drop, drop / declared_mm.powi(2), EXACT_TOL);
            for axis in 0..2 {
                assert_near(point.redundancy[axis], shown, EXACT_TOL);
                assert_near(point.w[axis], residual[axis] / (sigma_mm * shown.sqrt()), EXACT_TOL);
                assert_near(point.bias_mm.unwrap()[axis], residual[axis] / shown, EXACT_TOL);
            }
        }
    }
}

/// The smallest bias that a test at 5 % finds with 80 %: non-centralities of χ² from tables of its
/// power, 9.6347 and 10.9026 with two and three degrees of freedom; of F with two against two,
/// `1 − β = (1 − α)·exp(−λα/2)` is left.
#[test]
fn the_detectable_bias_is_that_of_the_tables() {
    /// The last digit of the tables, halved by the root.
    const TABLE_TOL: f64 = 3e-6;
    let (alpha, beta, sigma_mm) = (0.05_f64, 0.8, 0.02);
    let plane = OFF_MM.map(Vector2::from);
    let space: Vec<SVector<f64, 3>> =
        [1.0, -3.0, 2.0, 0.5].map(|v| SVector::from([0.01 * v, -0.02 * v, 0.01])).to_vec();
    let detectable_sigmas = |lambda: f64, shown: f64| (lambda / shown).sqrt();

    let (_, judged) = shifted(&plane, sigma_mm, Noise::Declared, alpha);
    let expected = detectable_sigmas(9.634_685, 2.0 / 3.0) * sigma_mm;
    for point in &judged {
        assert_near(point.detectable_mm[0], expected, TABLE_TOL);
    }

    let (_, judged) = shifted(&space, sigma_mm, Noise::Declared, alpha);
    let expected = detectable_sigmas(10.902_563, 3.0 / 4.0) * sigma_mm;
    for point in &judged {
        assert_near(point.detectable_mm[2], expected, TABLE_TOL);
    }

    let (fit, judged) = shifted(&plane, sigma_mm, Noise::Estimated, alpha);
    let lambda = 2.0 / alpha * ((1.0 - alpha) / (1.0 - beta)).ln();
    let estimated_mm = sigma_mm * fit.variance_factor.unwrap().sqrt();
    let expected = detectable_sigmas(lambda, 2.0 / 3.0) * estimated_mm;
    for point in &judged {
        assert_near(point.detectable_mm[1], expected, LEVEL_TOL);
    }
}

/// Two points leave each other nothing to judge with where the noise is estimated.
#[test]
fn two_points_cannot_be_told_apart() {
    let off = [Vector2::new(0.01, 0.0), Vector2::new(-0.01, 0.02)];
    let (_, judged) = shifted(&off, 0.02, Noise::Estimated, 0.05);
    for point in judged {
        assert_eq!(point.p_value.to_bits(), 1.0_f64.to_bits());
        assert!(point.detectable_mm.iter().all(|d| d.is_infinite()), "{point:?}");
    }
}
