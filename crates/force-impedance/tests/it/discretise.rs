//! The step of the impedance against an integration of its differential equation.

use force_impedance::{Discretisation, ForceImpedanceError, Impedance, ImpedanceParameters};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Twenty thousand Runge-Kutta steps leave (1/20000)⁴ of truncation and 20000·2⁻⁵³ of round-off;
/// relative to the response itself.
const INTEGRATION_TOL: f64 = 1e-10;
const N_SUBSTEPS: u32 = 20_000;

fn parameters(mass_kg: f64, damping: f64, stiffness: f64) -> ImpedanceParameters {
    ImpedanceParameters { mass_kg, damping_ns_per_mm: damping, stiffness_n_per_mm: stiffness }
}

/// Classic fourth-order Runge-Kutta of `m·E'' + d·E' + k·E = f` over one interval.
fn integrated(p: &ImpedanceParameters, t: f64, start: [f64; 2], f: f64) -> [f64; 2] {
    let m = p.mass_kg / 1000.0;
    let rate = |[e, v]: [f64; 2]| [v, (f - p.damping_ns_per_mm * v - p.stiffness_n_per_mm * e) / m];
    let h = t / f64::from(N_SUBSTEPS);
    let moved = |x: [f64; 2], r: [f64; 2], s: f64| [x[0] + s * r[0], x[1] + s * r[1]];
    let mut x = start;
    for _ in 0..N_SUBSTEPS {
        let a = rate(x);
        let b = rate(moved(x, a, h / 2.0));
        let c = rate(moved(x, b, h / 2.0));
        let d = rate(moved(x, c, h));
        for i in 0..2 {
            x[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }
    x
}

/// Underdamped, critical, overdamped, without a spring, nearly without mass.
const CASES: [[f64; 3]; 9] = [
    [2.0, 0.05, 5.0],
    [1.0, 0.2, 10.0],
    [1.0, 0.200_000_001, 10.0],
    [1.0, 0.2, 0.0],
    [0.5, 3.0, 40.0],
    [0.5, 3.0, 0.0],
    [0.02, 0.4, 2.0],
    [5.0, 250.0, 100.0],
    [1e3, 0.01, 1e-3],
];

#[test]
fn the_exact_hold_is_exact() {
    let t = 1e-3;
    for [mass, damping, stiffness] in CASES {
        let p = parameters(mass, damping, stiffness);
        let step = Impedance::new(p, t, Discretisation::ExactHold).unwrap();
        for start in [[0.0, 0.0], [0.3, -20.0]] {
            let found = step.advance(start[0], start[1], 12.0, 0.0);
            let expected = integrated(&p, t, start, 12.0);
            for i in 0..2 {
                let scale = expected[i].abs().max(start[i].abs());
                let error = (found[i] - expected[i]).abs() / scale;
                assert!(error < INTEGRATION_TOL, "{p:?} {start:?} {i}: {error:e}");
            }
        }
    }
}

/// A step of an interval is two steps of half of it: also where the roots nearly meet, and far
/// beyond what an integration can follow.
#[test]
fn two_halves_make_a_whole() {
    const TOL: f64 = 1e-12;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    for _ in 0..2000 {
        let mass = 10f64.powf(rng.random_range(-4.0..3.0));
        let damping = 10f64.powf(rng.random_range(-2.0..4.0));
        let stiffness = 10f64.powf(rng.random_range(-3.0..3.0));
        let p = parameters(mass, damping, stiffness);
        let Ok(whole) = Impedance::new(p, 2e-3, Discretisation::ExactHold) else { continue };
        let half = Impedance::new(p, 1e-3, Discretisation::ExactHold).unwrap();
        let [e, v] = half.advance(0.1, 3.0, 7.0, 0.0);
        let twice = half.advance(e, v, 7.0, 0.0);
        let once = whole.advance(0.1, 3.0, 7.0, 0.0);
        for (scale, i) in [(0.1, 0), (3.0 + 7.0 / damping, 1)] {
            let error = (once[i] - twice[i]).abs() / scale;
            assert!(error < TOL, "{p:?} {i}: {error:e}");
        }
    }
}

/// Both rules have the same fixed point, and the trapezoidal rule is of second order.
#[test]
fn the_bilinear_rule_converges_to_the_exact_one() {
    let p = parameters(2.0, 0.3, 5.0);
    let error = |n: u32| {
        let t = 0.02 / f64::from(n);
        let exact = Impedance::new(p, t, Discretisation::ExactHold).unwrap();
        let rule = Impedance::new(p, t, Discretisation::Bilinear).unwrap();
        let (mut a, mut b) = ([0.0, 0.0], [0.0, 0.0]);
        for _ in 0..n {
            a = exact.advance(a[0], a[1], 10.0, 10.0);
            b = rule.advance(b[0], b[1], 10.0, 10.0);
        }
        (a[0] - b[0]).abs()
    };
    let order = (error(20) / error(40)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
    let rule = Impedance::new(p, 1e-3, Discretisation::Bilinear).unwrap();
    let [e, v] = rule.advance(2.0, 0.0, 10.0, 10.0);
    assert!((e - 2.0).abs() < 1e-14 && v.abs() < 1e-11);
}

#[test]
fn impossible_impedances_are_refused() {
    let refuse = |p, t| Impedance::new(p, t, Discretisation::ExactHold).unwrap_err();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refuse(parameters(bad, 1.0, 1.0), 1e-3);
        refuse(parameters(1.0, bad, 1.0), 1e-3);
        refuse(parameters(1.0, 1.0, 1.0), bad);
    }
    refuse(parameters(1.0, 1.0, -1.0), 1e-3);
    assert!(Impedance::new(parameters(1.0, 1.0, 0.0), 1e-3, Discretisation::ExactHold).is_ok());
    // 1 g on 100 N/mm rings at 1.6 kHz.
    let e = refuse(parameters(1e-3, 1e-6, 100.0), 1e-3);
    assert!(matches!(e, ForceImpedanceError::TooFastForSampling { .. }), "{e}");
    let huge = parameters(1e-300, 1e300, 1e300);
    assert!(Impedance::new(huge, 1e-3, Discretisation::ExactHold).is_err());
    assert!(Impedance::new(huge, 1e-3, Discretisation::Bilinear).is_err());
}

/// Force in another unit: mass, damping, stiffness and force are as many times larger, and the motion
/// is the same to the last digit, powers of two being exact.
#[test]
fn the_unit_of_force_does_not_matter() {
    for rule in [Discretisation::ExactHold, Discretisation::Bilinear] {
        for [mass, damping, stiffness] in CASES {
            let step = |unit: f64| {
                let p = parameters(mass * unit, damping * unit, stiffness * unit);
                let step = Impedance::new(p, 1e-3, rule).unwrap();
                step.advance(0.3, -20.0, 12.0 * unit, 11.0 * unit).map(f64::to_bits)
            };
            for unit in [2f64.powi(-20), 2f64.powi(20)] {
                assert_eq!(step(unit), step(1.0), "{rule:?} {mass} {damping} {stiffness}");
            }
        }
    }
}
