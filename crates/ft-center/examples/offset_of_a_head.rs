//! A head is sent to a place on the platform; where is it really, and how sure is that?
//!
//! Records are simulated with wobble, friction and noise that remembers; the example fails when the
//! offset it finds is not the one put in.

use std::f64::consts::TAU;

use ft_center::{
    Contact, FtCenterError, LocateOptions, OrbitOptions, Press, PressRole, Sample, locate,
    solve_presses,
};
use geometry::Wrench;
use nalgebra::{Point2, Point3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const Z0_MM: f64 = 30.0;
const OFFSET_MM: Vector2<f64> = Vector2::new(0.35, -0.20);

/// The sensor stands turned by 0.3 rad at (500, 200) in the machine.
fn to_sensor(machine_mm: Point2<f64>) -> Point2<f64> {
    let (sin, cos) = 0.3f64.sin_cos();
    let d = machine_mm - Point2::new(500.0, 200.0);
    Point2::new(cos * d.x - sin * d.y, sin * d.x + cos * d.y)
}

/// 30 s at 50 Hz, 2 N·mm of noise that forgets within 0.2 s.
fn record(center_mm: Point2<f64>, rng: &mut ChaCha8Rng) -> Vec<Sample> {
    let keep = (-0.02f64 / 0.2).exp();
    let mut slow = Vector3::zeros();
    (0..1500)
        .map(|i| {
            let time_s = 0.02 * f64::from(i);
            let (sin, cos) = (TAU * 1.7 * time_s).sin_cos();
            let at = center_mm + Vector2::new(0.8 * cos, 0.8 * sin);
            let force = Vector3::new(3.0, -1.0, -40.0 - 2.0 * sin);
            let mut wrench = Wrench::of_force(force, &Point3::new(at.x, at.y, Z0_MM));
            let fresh = Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal));
            slow = slow * keep + fresh * (2.0 * (1.0 - keep * keep).sqrt());
            wrench.torque_nmm += slow + Vector3::z() * 180.0;
            Sample { time_s, wrench }
        })
        .collect()
}

fn main() -> Result<(), FtCenterError> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut press = |name: &str, role, x_mm, y_mm, offset_mm: Vector2<f64>| {
        let machine_mm = Point2::new(x_mm, y_mm);
        let record = record(to_sensor(machine_mm + offset_mm), &mut rng);
        Press { name: name.to_owned(), role, machine_mm, record }
    };
    let known = Vector2::zeros();
    let presses = [
        press("a", PressRole::Frame, 470.0, 180.0, known),
        press("b", PressRole::Frame, 530.0, 180.0, known),
        press("c", PressRole::Frame, 530.0, 220.0, known),
        press("d", PressRole::Frame, 470.0, 220.0, known),
        press("head", PressRole::Locate, 500.0, 200.0, OFFSET_MM),
    ];
    let contact = Contact { z0_mm: Z0_MM, min_fz_n: None };
    let solved = solve_presses(&presses, &contact, &OrbitOptions::default())?;
    let located = locate(&solved, &contact, &LocateOptions::default())?;

    let head = &located.centers[4];
    let spin_hz = solved[4].orbit.wobble.map_or(0.0, |w| w.spin_hz);
    assert!((spin_hz - 1.7).abs() < 0.01, "spin {spin_hz} Hz");
    for axis in 0..2 {
        let std_mm = head.covariance_mm2[(axis, axis)].sqrt();
        let error_mm = head.offset_mm[axis] - OFFSET_MM[axis];
        assert!(std_mm < 0.05, "standard uncertainty {std_mm} mm");
        assert!(error_mm.abs() < 4.0 * std_mm, "off by {error_mm} mm, std {std_mm} mm");
    }
    Ok(())
}
