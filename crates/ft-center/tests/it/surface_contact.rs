//! Contact on plane, sphere and asphere.

use ft_center::{CoupleAxis, FtCenterError, center_of_pressure, contact_on_surface};
use geometry::{Asphere, AsphereShape, Plane, Sphere, Surface, Wrench};
use nalgebra::{Isometry3, Point3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Round-off of a line that starts 1e4 mm away: 1e4 mm · 2⁻⁵² · 20 operations.
const EXACT_TOL_MM: f64 = 5e-11;

/// Workpiece 120 mm above the sensor, turned about z.
fn placed() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(4.0, -3.0, -120.0), Vector3::z() * 0.3)
}

/// Wrench on the sensor of a force and a couple at a point, all given in the workpiece frame.
fn wrench(at: &Point3<f64>, force_n: Vector3<f64>, couple_nmm: Vector3<f64>) -> Wrench {
    let mut wrench = Wrench::of_force(force_n, at);
    wrench.torque_nmm += couple_nmm;
    wrench.in_frame(&placed().inverse())
}

fn assert_finds(
    surface: &dyn Surface,
    at: Point3<f64>,
    normal: Unit<Vector3<f64>>,
    rng: &mut ChaCha8Rng,
) {
    let slip = Vector3::from_fn(|_, _| rng.random_range(-8.0..8.0));
    let force = normal.into_inner() * -40.0 + (slip - normal.into_inner() * slip.dot(&normal));
    let couple = 150.0;
    let wrench = wrench(&at, force, normal.into_inner() * couple);
    let found = contact_on_surface(&wrench, surface, &placed(), CoupleAxis::Normal, 1.0).unwrap();
    assert!((found.point_mm - at).norm() < EXACT_TOL_MM, "{}", found.point_mm - at);
    assert!((found.couple_nmm - couple).abs() < 1e-8);
    assert!((found.normal_force_n - 40.0).abs() < 1e-11);
    let across = (force + normal.into_inner() * 40.0).norm();
    assert!((found.tangential_force_n - across).abs() < 1e-10);
}

#[test]
fn finds_the_point_on_every_surface() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let sphere = Sphere::new(Point3::new(0.0, 0.0, -200.0), 200.0).unwrap();
    let bowl = Asphere::new(AsphereShape::on_axis(480.0, -1.0, vec![1e-9], 100.0)).unwrap();
    let dome = Asphere::new(AsphereShape::on_axis(-300.0, 0.2, vec![], 100.0)).unwrap();
    let plane = Plane::new(Point3::origin(), Vector3::new(0.05, -0.02, 1.0)).unwrap();
    for _ in 0..100 {
        let (x, y): (f64, f64) = (rng.random_range(-30.0..30.0), rng.random_range(-30.0..30.0));
        for asphere in [&bowl, &dome] {
            let at = Point3::new(x, y, asphere.sag_mm(x, y).unwrap());
            assert_finds(asphere, at, asphere.normal(x, y).unwrap(), &mut rng);
        }
        let up = (200.0f64.powi(2) - x * x - y * y).sqrt();
        let at = Point3::new(x, y, up - 200.0);
        let out = Unit::new_normalize(Vector3::new(x, y, up));
        assert_finds(&sphere, at, out, &mut rng);
        let n = plane.normal();
        let at = Point3::new(x, y, -(n.x * x + n.y * y) / n.z);
        assert_finds(&plane, at, n, &mut rng);
    }
}

#[test]
fn on_a_level_plane_it_is_the_centre_of_pressure() {
    let plane = Plane::new(Point3::new(0.0, 0.0, 30.0), Vector3::z()).unwrap();
    let wrench = Wrench {
        force_n: Vector3::new(4.0, -6.0, -35.0),
        torque_nmm: Vector3::new(320.0, -110.0, 500.0),
    };
    let flat = center_of_pressure(&wrench, 30.0, 1.0).unwrap();
    let identity = Isometry3::identity();
    let curved = contact_on_surface(&wrench, &plane, &identity, CoupleAxis::Normal, 1.0).unwrap();
    assert!((curved.point_mm.xy() - flat.position_mm).norm() < EXACT_TOL_MM);
    assert!((curved.couple_nmm - flat.free_moment_nmm).abs() < 1e-9);
    let axis = CoupleAxis::Axis(Vector3::z_axis());
    let spindle = contact_on_surface(&wrench, &plane, &identity, axis, 1.0).unwrap();
    assert!((spindle.point_mm - curved.point_mm).norm() < EXACT_TOL_MM);
}

#[test]
fn the_plain_line_of_action_is_dragged_by_friction() {
    let sphere = Sphere::new(Point3::new(0.0, 0.0, -200.0), 200.0).unwrap();
    let top = Point3::origin();
    let wrench = wrench(&top, Vector3::new(3.0, 0.0, -40.0), Vector3::z() * 150.0);
    let plain = contact_on_surface(&wrench, &sphere, &placed(), CoupleAxis::Force, 1.0).unwrap();
    // couple × lateral force / force²
    let drag_mm = 150.0 * 3.0 / (40.0f64.powi(2) + 9.0);
    let missed = (plain.point_mm - top).norm();
    assert!((missed - drag_mm).abs() < 0.02 * drag_mm, "{missed} mm");
    let full = contact_on_surface(&wrench, &sphere, &placed(), CoupleAxis::Normal, 1.0).unwrap();
    assert!((full.point_mm - top).norm() < EXACT_TOL_MM);
}

#[test]
fn a_pull_a_miss_and_a_light_touch_are_errors() {
    let dome = Asphere::new(AsphereShape::on_axis(-300.0, 0.0, vec![], 60.0)).unwrap();
    let contact = |wrench: &Wrench| {
        contact_on_surface(wrench, &dome, &placed(), CoupleAxis::Normal, 1.0).unwrap_err()
    };
    let pull = wrench(&Point3::origin(), Vector3::new(0.0, 0.0, 40.0), Vector3::zeros());
    assert!(matches!(contact(&pull), FtCenterError::NoContact { .. }));
    let light = wrench(&Point3::origin(), Vector3::new(0.0, 0.0, -0.5), Vector3::zeros());
    assert!(matches!(contact(&light), FtCenterError::NoContact { .. }));
    let beside =
        wrench(&Point3::new(90.0, 0.0, 0.0), Vector3::new(0.0, 0.0, -40.0), Vector3::zeros());
    assert!(matches!(contact(&beside), FtCenterError::Surface(_)));
    let nan = Wrench { force_n: Vector3::new(f64::NAN, 0.0, -40.0), ..light };
    assert!(matches!(contact(&nan), FtCenterError::NotFinite { .. }));
}

/// Too light is what lies under the least force; what has it is a touch.
#[test]
fn the_least_force_is_a_touch() {
    let plane = Plane::new(Point3::origin(), Vector3::z()).unwrap();
    let at = Point3::new(3.0, -2.0, 0.0);
    let touch = Wrench::of_force(Vector3::new(0.0, 0.0, -8.0), &at);
    let identity = Isometry3::identity();
    let contact =
        |least_n: f64| contact_on_surface(&touch, &plane, &identity, CoupleAxis::Normal, least_n);
    let found = contact(8.0).unwrap();
    assert!((found.point_mm - at).norm() < EXACT_TOL_MM);
    assert!(matches!(contact(8.0f64.next_up()), Err(FtCenterError::NoContact { .. })));
}
