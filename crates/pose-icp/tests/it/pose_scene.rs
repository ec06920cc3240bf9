//! A touched paraboloid, written apart from the crate: the set-up of document [D].

use geometry::{AsphereShape, EulerAngles};
use nalgebra::{Point3, Rotation3, Vector3};
use pose_icp::{EdgeTouches, Part, PoseStart, Tip, Touch};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Vertex radius and aperture of the mirror of [D].
pub(crate) const RADIUS_MM: f64 = 480.0;
pub(crate) const DIAMETER_MM: f64 = 100.0;
pub(crate) const TIP_MM: f64 = 3.0;

pub(crate) fn paraboloid() -> Part {
    Part::asphere(AsphereShape::on_axis(RADIUS_MM, -1.0, vec![], DIAMETER_MM))
        .expect("the paraboloid is sound")
}

pub(crate) fn tip() -> Tip {
    Tip { radius_mm: TIP_MM, ..Tip::default() }
}

/// Centre, four points at k·D/4 and four at k·D/2, k = 0.8, where [D] touches.
pub(crate) fn nine_points() -> Vec<[f64; 2]> {
    let (inner, outer) = (0.8 * DIAMETER_MM / 4.0, 0.8 * DIAMETER_MM / 2.0);
    let mut points = vec![[0.0, 0.0]];
    for radius in [inner, outer] {
        points.extend([[radius, 0.0], [0.0, radius], [-radius, 0.0], [0.0, -radius]]);
    }
    points
}

/// A pose as a machine operator leaves it: anywhere, tilted by up to 10 mrad.
pub(crate) fn random_pose(rng: &mut ChaCha8Rng) -> PoseStart {
    let mut tilt = || rng.random_range(-10e-3..10e-3);
    let angles = EulerAngles { alpha_rad: tilt(), beta_rad: tilt(), gamma_rad: 0.3 };
    let position_mm =
        Vector3::new(-499.3, -474.6, -284.9) + Vector3::from_fn(|_, _| rng.random_range(-5.0..5.0));
    PoseStart { position_mm, angles }
}

/// Where the ball's centre is when it touches the paraboloid above (x, y) of the workpiece.
pub(crate) fn center_over(pose: &PoseStart, x: f64, y: f64, tip_mm: f64) -> Point3<f64> {
    let surface = Vector3::new(x, y, (x * x + y * y) / (2.0 * RADIUS_MM));
    let normal = Vector3::new(-x / RADIUS_MM, -y / RADIUS_MM, 1.0).normalize();
    to_machine(pose, surface + normal * tip_mm)
}

pub(crate) fn to_machine(pose: &PoseStart, workpiece_mm: Vector3<f64>) -> Point3<f64> {
    let a = pose.angles;
    let rotation = Rotation3::from_euler_angles(a.alpha_rad, a.beta_rad, a.gamma_rad);
    Point3::from(rotation * workpiece_mm + pose.position_mm)
}

/// Touches with independent noise in x, y and z.
pub(crate) fn touches(
    pose: &PoseStart,
    at: &[[f64; 2]],
    sigma_mm: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<Touch> {
    at.iter()
        .map(|&[x, y]| {
            let noise: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
            let center_mm = center_over(pose, x, y, TIP_MM) + noise * sigma_mm;
            Touch::new(center_mm, sigma_mm.max(1e-6))
        })
        .collect()
}

/// Touches of the cylindrical side, 8 mm below the vertex, and of the centre.
pub(crate) fn edge(pose: &PoseStart, sigma_mm: f64, rng: &mut ChaCha8Rng) -> EdgeTouches {
    let gamma = pose.angles.gamma_rad;
    let reach = 0.5 * DIAMETER_MM + TIP_MM;
    // The operator touches along the machine's axes, so turn them into the workpiece.
    let side = |x: f64, y: f64, rng: &mut ChaCha8Rng| {
        let (sin, cos) = gamma.sin_cos();
        let local = Vector3::new(cos * x + sin * y, -sin * x + cos * y, -8.0);
        let noise: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(rng));
        to_machine(pose, local) + noise * sigma_mm
    };
    let sides_mm = [
        side(0.0, -reach, rng),
        side(reach, 0.0, rng),
        side(0.0, reach, rng),
        side(-reach, 0.0, rng),
    ];
    let center_mm = center_over(pose, 0.0, 0.0, TIP_MM);
    EdgeTouches { sides_mm, center_mm, sigma_mm: sigma_mm.max(1e-6) }
}
