//! Orbit centres: exactness, spin, gate and awkward records.

use std::f64::consts::TAU;

use ft_center::{Contact, FtCenterError, Orbit, OrbitOptions, Sample, solve_orbit};
use nalgebra::{Point2, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::simulator::{CONTACT, Colour, Head, Z0_MM, record, wrench_at};

/// Round-off of a fit over 600 samples at 30 mm, conditioned like the frequency: 2⁻⁵² · 30 · 600.
const EXACT_TOL_MM: f64 = 1e-11;

/// The noise around a line is the mean logarithm of some 88 bins of power, pairs of which are correlated;
/// each has a standard deviation of 0.8: 12 % of the power, 6 % of its root, and four times that.
const NOISE_TOL: f64 = 0.24;

const CENTER: Point2<f64> = Point2::new(12.0, -7.0);

fn solve(record: &[Sample]) -> Orbit {
    solve_orbit(record, &CONTACT, &OrbitOptions::default()).unwrap()
}

#[test]
fn recovers_centre_spin_and_wobble_without_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for spin_hz in [0.3, 1.7, 1.7345, 4.9] {
        for sense in [1.0, -1.0] {
            let head = Head { spin_hz: sense * spin_hz, load_ripple: 0.0, ..Head::default() };
            // 9.99 s: no whole number of turns.
            let record = record(CENTER, &head, &Colour::NONE, 1000, 100.0, &mut rng);
            let orbit = solve(&record);
            assert!((orbit.center_mm - CENTER).norm() < EXACT_TOL_MM);
            let wobble = orbit.wobble.unwrap();
            assert!((wobble.spin_hz - head.spin_hz).abs() < 1e-9, "{}", wobble.spin_hz);
            assert!((wobble.radius_mm - head.wobble_mm).abs() < 1e-9);
            assert!((orbit.free_moment_nmm - head.couple_nmm).abs() < 1e-8);
        }
    }
}

#[test]
fn the_mean_of_part_of_a_turn_is_not_the_centre() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let head = Head { spin_hz: 0.25, load_ripple: 0.0, ..Head::default() };
    let record = record(CENTER, &head, &Colour::NONE, 1000, 100.0, &mut rng);
    let points = record.iter().map(|s| {
        let at = ft_center::center_of_pressure(&s.wrench, Z0_MM, 1.0).unwrap();
        at.position_mm.coords
    });
    let mean = points.sum::<Vector2<f64>>() / 1000.0;
    assert!((mean - CENTER.coords).norm() > 0.05, "the mean is as good: nothing is tested");
    assert!((solve(&record).center_mm - CENTER).norm() < EXACT_TOL_MM);
}

#[test]
fn the_mean_wrench_acts_at_the_centre_and_reacts_like_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let record = record(CENTER, &Head::default(), &Colour::WHITE, 600, 40.0, &mut rng);
    let orbit = solve(&record);
    let at = ft_center::center_of_pressure(&orbit.mean_wrench, Z0_MM, 1.0).unwrap();
    assert!((at.position_mm - orbit.center_mm).norm() < EXACT_TOL_MM);

    let bias = Vector3::new(30.0, -50.0, 0.0);
    let mut biased = record.clone();
    for s in &mut biased {
        s.wrench.torque_nmm += bias;
    }
    let mut mean = orbit.mean_wrench;
    mean.torque_nmm += bias;
    let moved = ft_center::center_of_pressure(&mean, Z0_MM, 1.0).unwrap().position_mm;
    let error = (moved - solve(&biased).center_mm).norm();
    // The bias moves the centre by 1.5 mm; its harmonics are all that is left.
    assert!(error < 1e-3, "{error} mm");
}

#[test]
fn uneven_times_do_no_harm() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let head = Head::default();
    let mut time_s = 0.0;
    let record: Vec<_> = (0..800)
        .map(|_| {
            time_s += rng.random_range(0.005..0.045);
            let angle = TAU * head.spin_hz * time_s;
            let at = CENTER + head.wobble_mm * Vector2::new(angle.cos(), angle.sin());
            Sample { time_s, wrench: wrench_at(at, Vector3::new(0.0, 0.0, -40.0), 0.0) }
        })
        .collect();
    let orbit = solve(&record);
    assert!((orbit.center_mm - CENTER).norm() < EXACT_TOL_MM);
    assert!((orbit.wobble.unwrap().spin_hz - head.spin_hz).abs() < 1e-9);
}

#[test]
fn an_ellipse_gives_both_semi_axes() {
    let record: Vec<_> = (0..1000)
        .map(|i| {
            let time_s = f64::from(i) * 0.01;
            let angle = TAU * 2.2 * time_s;
            let at = CENTER + Vector2::new(1.5 * angle.cos(), 0.5 * angle.sin());
            Sample { time_s, wrench: wrench_at(at, Vector3::new(0.0, 0.0, 40.0), 0.0) }
        })
        .collect();
    let wobble = solve(&record).wobble.unwrap();
    assert!((wobble.semi_axes_mm[0] - 1.5).abs() < 1e-9);
    assert!((wobble.semi_axes_mm[1] - 0.5).abs() < 1e-9);
    assert!(wobble.spin_hz > 0.0);
}

#[test]
fn noise_alone_has_no_spin() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let head = Head { wobble_mm: 0.0, load_ripple: 0.0, ..Head::default() };
    let found = (0..200)
        .filter(|i| {
            let colour = if i % 2 == 0 { Colour::WHITE } else { Colour::COLOURED };
            let record = record(CENTER, &head, &colour, 300, 20.0, &mut rng);
            solve(&record).wobble.is_some()
        })
        .count();
    // Expected 0.2 at most at a chance of 1e-3 each; five or more happen once in 1e6 times.
    assert!(found < 5, "{found} spins out of noise");
}

#[test]
fn a_given_spin_is_kept_and_needs_a_turn() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let head = Head { spin_hz: 0.15, load_ripple: 0.0, ..Head::default() };
    let record = record(CENTER, &head, &Colour::NONE, 1000, 100.0, &mut rng);
    let given = |spin_hz| OrbitOptions { spin_hz: Some(spin_hz), ..OrbitOptions::default() };
    let orbit = solve_orbit(&record, &CONTACT, &given(0.15)).unwrap();
    // One turn and a half: conditioned worse than many turns.
    assert!((orbit.center_mm - CENTER).norm() < 1e-10);
    let wobble = orbit.wobble.unwrap();
    assert!((wobble.spin_hz.abs() - 0.15).abs() < f64::EPSILON && wobble.spin_std_hz == 0.0);
    let error = solve_orbit(&record, &CONTACT, &given(0.05)).unwrap_err();
    assert!(matches!(error, FtCenterError::TooFewTurns { turns } if turns < 0.5));
    assert!(matches!(
        solve_orbit(&record, &CONTACT, &given(-1.0)),
        Err(FtCenterError::NotPositive { setting: "spin_hz", .. })
    ));
}

#[test]
fn samples_under_the_gate_do_not_count() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut record = record(CENTER, &Head::default(), &Colour::WHITE, 600, 40.0, &mut rng);
    let clean = solve(&record);
    // Lifted for two seconds, the sensor reading nothing but its noise far off.
    for s in &mut record[200..280] {
        s.wrench = wrench_at(Point2::new(900.0, 900.0), Vector3::new(0.0, 0.0, -0.5), 0.0);
    }
    let gated = solve(&record);
    assert_eq!((gated.contact_samples, gated.gated_samples), (520, 80));
    let moved = (gated.center_mm - clean.center_mm).norm();
    assert!(moved < 0.05, "{moved} mm");
}

#[test]
fn the_default_gate_follows_the_load() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let contact = Contact { z0_mm: Z0_MM, min_fz_n: None };
    for load_n in [0.4, 40.0, 4000.0] {
        let head =
            Head { load_n, load_ripple: 0.0, lateral_n: Vector2::zeros(), ..Head::default() };
        let record = record(CENTER, &head, &Colour::NONE, 200, 20.0, &mut rng);
        let orbit = solve_orbit(&record, &contact, &OrbitOptions::default()).unwrap();
        assert!((orbit.min_fz_n - 0.2 * load_n).abs() < 1e-12 * load_n);
        assert_eq!(orbit.contact_samples, 200);
    }
}

/// A fifth of the load that 95 % of the samples do not exceed: neither spikes nor a head that is off the
/// platform for part of the time move it.
#[test]
fn the_default_gate_knows_neither_spikes_nor_pauses() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let contact = Contact { z0_mm: Z0_MM, min_fz_n: None };
    let head = Head { load_ripple: 0.0, ..Head::default() };
    let mut record = record(CENTER, &head, &Colour::NONE, 200, 20.0, &mut rng);
    // 4 % and 40 %.
    for s in &mut record[12..20] {
        s.wrench.force_n *= 50.0;
        s.wrench.torque_nmm *= 50.0;
    }
    for s in &mut record[100..180] {
        s.wrench.force_n.z = -0.02 * head.load_n;
    }
    let orbit = solve_orbit(&record, &contact, &OrbitOptions::default()).unwrap();
    assert!((orbit.min_fz_n - 0.2 * head.load_n).abs() < 1e-12 * head.load_n);
    assert_eq!((orbit.contact_samples, orbit.gated_samples), (120, 80));
}

/// Cramér and Rao for a circle in white noise (Rife and Boorstyn 1974): `σ/√n` for the radius and
/// `√12` times that over `2π r T` for the frequency, σ being the noise of each axis of a point.
#[test]
fn a_circle_is_as_uncertain_as_white_noise_leaves_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let head = Head { load_ripple: 0.0, lateral_n: Vector2::zeros(), ..Head::default() };
    for (load_n, samples) in [(40.0, 600_u32), (10.0, 600), (40.0, 2400)] {
        let head = Head { load_n, ..head };
        let noise = Colour { white_moment_nmm: 2.0, ..Colour::NONE };
        let n = samples as usize;
        let record = record(CENTER, &head, &noise, n, 40.0, &mut rng);
        let wobble = solve(&record).wobble.unwrap();
        let radius_std_mm = 2.0 / load_n / f64::from(samples).sqrt();
        let ratio = wobble.radius_std_mm / radius_std_mm;
        assert!((ratio - 1.0).abs() < NOISE_TOL, "{ratio}");
        let turned_mm = TAU * wobble.radius_mm * record[n - 1].time_s;
        let spin_std_hz = 12.0f64.sqrt() * wobble.radius_std_mm / turned_mm;
        assert!((wobble.spin_std_hz / spin_std_hz - 1.0).abs() < 1e-12);
    }
}

#[test]
fn too_few_samples_in_contact_are_counted() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut record = record(CENTER, &Head::default(), &Colour::WHITE, 50, 40.0, &mut rng);
    for s in &mut record[7..] {
        s.wrench.force_n.z = -1.0;
    }
    let error = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap_err();
    let expected =
        FtCenterError::TooFewContactSamples { contact: 7, given: 50, needed: 8, min_fz_n: 5.0 };
    assert_eq!(error, expected);
    let empty = solve_orbit(&[], &CONTACT, &OrbitOptions::default()).unwrap_err();
    assert!(matches!(empty, FtCenterError::TooFewContactSamples { contact: 0, given: 0, .. }));
    let gate = Contact { min_fz_n: None, ..CONTACT };
    let empty = solve_orbit(&[], &gate, &OrbitOptions::default()).unwrap_err();
    assert!(matches!(empty, FtCenterError::TooFewContactSamples { contact: 0, given: 0, .. }));
}

#[test]
fn few_samples_still_have_an_uncertainty() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    let head = Head { wobble_mm: 0.0, ..Head::default() };
    let orbit = solve(&record(CENTER, &head, &Colour::WHITE, 8, 40.0, &mut rng));
    assert!(orbit.wobble.is_none());
    assert!(orbit.covariance_mm2.determinant() > 0.0);
    assert!((orbit.center_mm - CENTER).norm() < 0.2);
}

#[test]
fn a_constant_record_is_exact_and_says_so() {
    let wrench = wrench_at(CENTER, Vector3::new(1.0, 2.0, -40.0), 9.0);
    let record: Vec<_> = (0..100).map(|i| Sample { time_s: f64::from(i) * 0.1, wrench }).collect();
    let orbit = solve(&record);
    assert!((orbit.center_mm - CENTER).norm() < EXACT_TOL_MM);
    assert!(orbit.covariance_mm2.trace() < EXACT_TOL_MM * EXACT_TOL_MM);
    assert!(orbit.wobble.is_none());
}

#[test]
fn time_must_increase() {
    let wrench = wrench_at(CENTER, Vector3::new(1.0, 2.0, -40.0), 9.0);
    let mut record: Vec<_> =
        (0..20).map(|i| Sample { time_s: f64::from(i) * 0.1, wrench }).collect();
    record.swap(4, 5);
    let error = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap_err();
    assert!(matches!(error, FtCenterError::TimeNotIncreasing { index: 5, .. }), "{error}");
    for s in &mut record {
        s.time_s = 3.0;
    }
    let error = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap_err();
    assert!(matches!(error, FtCenterError::TimeNotIncreasing { index: 1, .. }), "{error}");
}

#[test]
fn pushing_and_pulling_is_no_press() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut record = record(CENTER, &Head::default(), &Colour::WHITE, 100, 40.0, &mut rng);
    record[17].wrench.force_n.z = 60.0;
    assert_eq!(solve(&record).contact_samples, 99, "one spike is left out");
    for s in &mut record[40..80] {
        s.wrench.force_n.z *= -1.0;
    }
    let error = solve_orbit(&record, &CONTACT, &OrbitOptions::default()).unwrap_err();
    assert_eq!(error, FtCenterError::MixedSign { positive: 41, negative: 59, min_fz_n: 5.0 });
}

#[test]
fn either_sign_of_a_press_gives_the_same_centre() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let record = record(CENTER, &Head::default(), &Colour::COLOURED, 300, 20.0, &mut rng);
    let reaction: Vec<_> = record.iter().map(|s| Sample { wrench: -s.wrench, ..*s }).collect();
    let (down, up) = (solve(&record), solve(&reaction));
    assert!((down.center_mm - up.center_mm).norm() < EXACT_TOL_MM);
    assert!((down.covariance_mm2 - up.covariance_mm2).norm() < 1e-12);
}
