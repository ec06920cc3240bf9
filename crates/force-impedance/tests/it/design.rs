//! The design card against closed forms and against loops that are run.

use std::f64::consts::PI;

use force_impedance::{
    Discretisation, ForceImpedanceError, Impedance, ImpedanceParameters, LoopSettings,
    ReferenceMode, design_point, margins_at, recommend,
};

const T: f64 = 1e-3;

fn settings(delay_s: f64, lag_s: f64, mode: ReferenceMode) -> LoopSettings {
    LoopSettings { interval_s: T, delay_s, lag_s, discretisation: Discretisation::ExactHold, mode }
}

fn parameters(mass_kg: f64, damping: f64, stiffness: f64) -> ImpedanceParameters {
    ImpedanceParameters { mass_kg, damping_ns_per_mm: damping, stiffness_n_per_mm: stiffness }
}

/// Without mass or spring the loop is an integrator with one sample of wait: `L = g/(z − 1)` with
/// `g = K_e T/D`, unstable at g = 2, phase margin π/2 − ω/2 at 2 sin(ω/2) = g.
#[test]
fn an_integrator_has_the_margins_of_the_textbook() {
    let light = parameters(1e-6, 10.0, 0.0);
    for g in [0.2, 0.5, 1.5] {
        let contact = g * 10.0 / T;
        let s = settings(0.0, 0.0, ReferenceMode::Rebased);
        let point = design_point(light, &s, contact).unwrap();
        assert!((point.gain_margin_ratio - 2.0 / g).abs() < 1e-3, "{point:?}");
        let omega = 2.0 * (g / 2.0).asin();
        let phase = PI / 2.0 - omega / 2.0;
        assert!((point.phase_margin_rad.unwrap() - phase).abs() < 1e-3, "{point:?}");
        assert!((point.delay_margin_s.unwrap() - phase / omega * T).abs() < 1e-5);
    }
}

/// The loop written out sample by sample, with a delay that is no multiple of the interval and a
/// lag integrated in fine steps; the largest excursion late over early tells growth from decay.
fn grows(p: ImpedanceParameters, s: &LoopSettings, contact: f64, extra_delay_s: f64) -> bool {
    const FINE: usize = 200;
    let impedance = Impedance::new(p, T, s.discretisation).unwrap();
    let (mut e, mut v, mut before) = (0.0, 0.0, 0.0);
    let mut sent = Vec::new();
    let mut stands = 1e-3;
    let mut peaks = [0.0_f64; 2];
    let n = 6000_usize;
    for k in 0..n {
        let error = -contact * stands;
        let from = if s.mode == ReferenceMode::Rebased { e } else { 0.0 };
        let [moved, speed] = impedance.advance(e - from, v, error, before);
        (e, v, before) = (from + moved, speed, error);
        sent.push(e);
        for i in 0..FINE {
            let t = (k as f64 + (i as f64 + 0.5) / FINE as f64) * T - s.delay_s - extra_delay_s;
            let input = if t < 0.0 { 0.0 } else { sent[(t / T) as usize] };
            let share = if s.lag_s > 0.0 { (-T / FINE as f64 / s.lag_s).exp() } else { 0.0 };
            stands = share * stands + (1.0 - share) * input;
        }
        let half = usize::from(k > n / 2);
        if k % (n / 2) > n / 4 {
            peaks[half] = peaks[half].max(stands.abs());
        }
        if stands.abs() > 1e3 {
            return true;
        }
    }
    peaks[1] > peaks[0]
}

/// Factor, or added delay, at which a run begins to grow.
fn found(low: f64, high: f64, grows: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (low, high);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Bisection of ten steps over ± 30 %, a run of 6000 samples, lags in two hundred steps: 1 %.
#[test]
fn margins_are_where_runs_begin_to_grow() {
    const TOL: f64 = 0.01;
    for (delay_s, lag_s, mode, p) in [
        (0.0, 0.0, ReferenceMode::Rebased, parameters(2.0, 2.0, 0.0)),
        (1.7e-3, 4e-3, ReferenceMode::Rebased, parameters(5.0, 1.5, 0.0)),
        (2.4e-3, 3e-3, ReferenceMode::Absolute, parameters(1.0, 1.0, 20.0)),
    ] {
        let s = settings(delay_s, lag_s, mode);
        let contact = 60.0;
        let point = design_point(p, &s, contact).unwrap();
        assert!(point.stable, "{point:?}");
        let m = point.gain_margin_ratio;
        let gain = found(0.7 * m, 1.3 * m, |f| grows(p, &s, f * contact, 0.0));
        assert!((gain / m - 1.0).abs() < TOL, "gain margin {m}, found {gain}");
        if let Some(m) = point.delay_margin_s {
            // Between whole samples the loop does not see an instant's delay: one sample of room.
            let delay = found(0.7 * m, 1.3 * m, |d| grows(p, &s, contact, d));
            assert!((delay - m).abs() < TOL * m + T, "delay margin {m}, found {delay}");
        }
    }
}

#[test]
fn the_steady_error_and_the_response_are_those_of_a_run() {
    let p = parameters(1.0, 2.0, 40.0);
    let s = settings(1e-3, 2e-3, ReferenceMode::Absolute);
    let point = design_point(p, &s, 60.0).unwrap();
    assert!((point.steady_error_ratio - 0.4).abs() < 1e-12);
    // Two time constants (D/(K + K_e) = 20 ms) and what waits: four of them to 2 %.
    assert!((0.05..0.12).contains(&point.settling_s.unwrap()), "{point:?}");
    let bouncy = design_point(parameters(20.0, 0.3, 0.0), &s, 60.0).unwrap();
    assert!(bouncy.overshoot_ratio.is_none_or(|o| o > 0.5), "{bouncy:?}");
}

#[test]
fn a_recommendation_keeps_its_margins_on_every_contact() {
    for (delay_s, lag_s) in [(0.0, 0.0), (2e-3, 8e-3), (0.5e-3, 30e-3)] {
        let s = settings(delay_s, lag_s, ReferenceMode::Rebased);
        let found = recommend(&s, [10.0, 10_000.0], 0.5).unwrap();
        for contact in [10.0, 100.0, 1000.0, 10_000.0] {
            let point = design_point(found.parameters, &s, contact).unwrap();
            let margins = margins_at(found.parameters, &s, contact).unwrap();
            assert!(point.stable && margins.is_comfortable(), "{point:?}");
        }
        let met = found.met_from_n_per_mm.unwrap();
        let there = design_point(found.parameters, &s, met * 1.02).unwrap();
        assert!(there.settling_s.unwrap() <= 0.51, "{there:?}");
        if met > 10.0 {
            let softer = design_point(found.parameters, &s, met / 1.1).unwrap();
            assert!(softer.settling_s.unwrap() > 0.5, "{softer:?}");
        }
        // A narrow range leaves time to spare: it is used for margin.
        let narrow = recommend(&s, [900.0, 1100.0], 2.0).unwrap();
        assert_eq!(narrow.met_from_n_per_mm, Some(900.0));
        let point = design_point(narrow.parameters, &s, 1100.0).unwrap();
        assert!(point.gain_margin_ratio > 4.0, "{point:?}");
    }
}

#[test]
fn impossible_designs_are_refused() {
    let s = settings(0.0, 0.0, ReferenceMode::Rebased);
    let p = parameters(1.0, 1.0, 0.0);
    for bad in [0.0, -1.0, f64::NAN] {
        assert!(design_point(p, &s, bad).is_err());
        assert!(recommend(&s, [bad, 100.0], 1.0).is_err());
        assert!(recommend(&s, [10.0, 100.0], bad).is_err());
    }
    assert!(recommend(&s, [100.0, 10.0], 1.0).is_err());
    let slow = LoopSettings { delay_s: 2.0, ..s };
    let e = design_point(p, &slow, 10.0).unwrap_err();
    assert!(matches!(e, ForceImpedanceError::InvalidSetting { setting: "delay_s", .. }));
}
