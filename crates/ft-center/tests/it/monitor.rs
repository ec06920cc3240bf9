//! The live monitor against the same samples solved afterwards.

use ft_center::{
    ContactStatus, CoupleAxis, FtCenterError, Monitor, MonitorOptions, Platform, Sample,
    center_of_pressure,
};
use geometry::Sphere;
use nalgebra::{Isometry3, Point2, Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulator::{Colour, Head, Z0_MM, record, wrench_at};

const CENTER: Point2<f64> = Point2::new(12.0, -7.0);

fn monitor(options: MonitorOptions) -> Monitor {
    Monitor::new(Platform::Plane { z0_mm: Z0_MM }, options).unwrap()
}

fn at(time_s: f64, fz_n: f64) -> Sample {
    Sample { time_s, wrench: wrench_at(CENTER, Vector3::new(0.0, 0.0, fz_n), 0.0) }
}

#[test]
fn each_point_is_that_of_the_formula() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut monitor = monitor(MonitorOptions::default());
    for sample in record(CENTER, &Head::default(), &Colour::WHITE, 200, 100.0, &mut rng) {
        let reading = monitor.update(&sample);
        let expected = center_of_pressure(&sample.wrench, Z0_MM, 1.0).unwrap();
        assert_eq!(reading.status, ContactStatus::Contact);
        let point = reading.point_mm.unwrap();
        assert_eq!(point, Point3::new(expected.position_mm.x, expected.position_mm.y, Z0_MM));
        assert!((reading.free_moment_nmm - expected.free_moment_nmm).abs() < f64::EPSILON);
    }
}

#[test]
fn the_filter_settles_on_the_centre() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut monitor = monitor(MonitorOptions { filter_s: 3.0, ..MonitorOptions::default() });
    let head = Head { load_ripple: 0.0, ..Head::default() };
    let samples = record(CENTER, &head, &Colour::NONE, 2000, 100.0, &mut rng);
    let last = samples.iter().map(|s| monitor.update(s)).last().unwrap();
    let error = (last.center_mm.unwrap().xy() - CENTER).norm();
    // A first-order low pass leaves wobble/(2π spin filter) of the wobble.
    let ripple_mm = 0.8 / (std::f64::consts::TAU * 1.7 * 3.0);
    assert!(error < 1.1 * ripple_mm, "{error} mm");
    assert!((last.contact_time_s - 19.99).abs() < 1e-9);
}

#[test]
fn contact_is_taken_lost_and_taken_again() {
    let mut monitor = monitor(MonitorOptions::default());
    let mut status = |time_s, fz_n| monitor.update(&at(time_s, fz_n)).status;
    assert_eq!(status(0.0, -1.0), ContactStatus::NoContact);
    assert_eq!(status(0.1, -4.5), ContactStatus::NoContact);
    assert_eq!(status(0.2, -5.5), ContactStatus::Contact);
    assert_eq!(status(0.3, -4.5), ContactStatus::Contact, "hysteresis");
    assert_eq!(status(0.4, -3.5), ContactStatus::ContactLost);
    assert_eq!(status(0.5, -3.5), ContactStatus::NoContact);
    assert_eq!(status(0.6, 6.0), ContactStatus::Contact, "either sign");
}

#[test]
fn a_lost_contact_holds_the_centre_and_a_new_one_starts_afresh() {
    let mut monitor = monitor(MonitorOptions::default());
    let first = monitor.update(&at(0.0, -40.0)).center_mm.unwrap();
    let held = monitor.update(&at(0.1, 0.0));
    assert_eq!((held.point_mm, held.center_mm), (None, Some(first)));
    assert!(held.contact_time_s == 0.0);
    let elsewhere = Point2::new(50.0, 60.0);
    let wrench = wrench_at(elsewhere, Vector3::new(0.0, 0.0, -40.0), 0.0);
    let fresh = monitor.update(&Sample { time_s: 0.2, wrench });
    assert!((fresh.center_mm.unwrap().xy() - elsewhere).norm() < 1e-12);
}

#[test]
fn bad_samples_are_ignored_and_said() {
    let mut monitor = monitor(MonitorOptions::default());
    let good = monitor.update(&at(1.0, -40.0));
    let mut nan = at(1.1, -40.0);
    nan.wrench.torque_nmm.z = f64::NAN;
    let mut infinite = at(1.1, -40.0);
    infinite.wrench.force_n = Vector3::new(f64::INFINITY, f64::NEG_INFINITY, -40.0);
    for bad in [nan, infinite, at(1.0, -40.0), at(0.5, -40.0), at(f64::NAN, -40.0)] {
        let reading = monitor.update(&bad);
        assert_eq!(reading.status, ContactStatus::InvalidSample);
        assert_eq!((reading.point_mm, reading.center_mm), (None, good.center_mm));
    }
    assert_eq!(monitor.update(&at(1.2, -40.0)).status, ContactStatus::Contact);
}

#[test]
fn a_workpiece_is_followed_and_may_be_missed() {
    let sphere = Sphere::new(Point3::new(0.0, 0.0, -200.0), 200.0).unwrap();
    let platform = Platform::Workpiece {
        surface: Box::new(sphere),
        workpiece_from_sensor: Isometry3::translation(0.0, 0.0, -120.0),
        couple_axis: CoupleAxis::Normal,
    };
    let mut monitor = Monitor::new(platform, MonitorOptions::default()).unwrap();
    let top = Sample {
        time_s: 0.0,
        wrench: geometry::Wrench::of_force(
            Vector3::new(0.0, 0.0, -40.0),
            &Point3::new(0.0, 0.0, 120.0),
        ),
    };
    let reading = monitor.update(&top);
    assert!(reading.point_mm.unwrap().coords.norm() < 1e-10);
    let mut beside = top;
    beside.time_s = 0.1;
    beside.wrench.torque_nmm.x = 300.0 * -40.0;
    assert_eq!(monitor.update(&beside).status, ContactStatus::OffWorkpiece);
}

#[test]
fn settings_are_checked() {
    let plane = || Platform::Plane { z0_mm: Z0_MM };
    let with = |options| Monitor::new(plane(), options).unwrap_err();
    let options = MonitorOptions::default();
    assert!(matches!(
        with(MonitorOptions { filter_s: 0.0, ..options }),
        FtCenterError::NotPositive { setting: "filter_s", .. }
    ));
    assert!(matches!(
        with(MonitorOptions { lift_fz_n: 9.0, ..options }),
        FtCenterError::LiftAboveTouch { .. }
    ));
    let nowhere = Monitor::new(Platform::Plane { z0_mm: f64::NAN }, options).unwrap_err();
    assert!(matches!(nowhere, FtCenterError::InvalidHeight { .. }));
}
