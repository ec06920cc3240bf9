//! Time of the exact pose from nine touches of a paraboloid, R = 480 mm, Φ100 (document [D]).

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use geometry::{AsphereShape, EulerAngles};
use nalgebra::{Matrix2, Point2, Point3, Vector3};
use pose_icp::{LateralPrior, Part, PoseOptions, PoseStart, Tip, Touch, fit_pose};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Poses whose mean time is taken, so that no lucky start decides.
const N_SCENES: usize = 64;
const SIGMA_MM: f64 = 1e-3;

struct Scene {
    touches: Vec<Touch>,
    start: PoseStart,
    options: PoseOptions,
}

fn scene(rng: &mut ChaCha8Rng, sides: bool) -> Scene {
    let mut tilt = || rng.random_range(-10e-3..10e-3);
    let angles = EulerAngles { alpha_rad: tilt(), beta_rad: tilt(), gamma_rad: 0.0 };
    let pose = PoseStart { position_mm: Vector3::new(-499.3, -474.6, -284.9), angles };
    let machine_from_workpiece = pose.machine_from_workpiece();
    let mut noise = || -> f64 { StandardNormal.sample(rng) };
    let mut at = vec![[0.0, 0.0]];
    for radius in [20.0, 40.0] {
        at.extend([[radius, 0.0], [0.0, radius], [-radius, 0.0], [0.0, -radius]]);
    }
    let touches = at
        .iter()
        .map(|&[x, y]| {
            let normal = Vector3::new(-x / 480.0, -y / 480.0, 1.0).normalize();
            let center = Point3::new(x, y, (x * x + y * y) / 960.0) + normal * 3.0;
            let noise = Vector3::new(noise(), noise(), noise()) * SIGMA_MM;
            Touch::new(machine_from_workpiece * center + noise, SIGMA_MM)
        })
        .collect();
    let start = PoseStart::level(
        pose.position_mm + Vector3::from_fn(|_, _| rng.random_range(-5.0..5.0)),
        0.0,
    );
    let lateral = sides.then(|| LateralPrior {
        at_z_mm: pose.position_mm.z,
        center_mm: Point2::new(pose.position_mm.x, pose.position_mm.y),
        covariance_mm2: Matrix2::identity() * (0.5 * SIGMA_MM * SIGMA_MM),
    });
    let tip = Tip { radius_mm: 3.0, ..Tip::default() };
    Scene { touches, start, options: PoseOptions { tip, lateral, ..PoseOptions::default() } }
}

fn nine_touches(criterion: &mut Criterion) {
    let part = Part::asphere(AsphereShape::on_axis(480.0, -1.0, vec![], 100.0))
        .expect("the paraboloid is sound");
    for (name, sides) in [("and side touches", true), ("alone", false)] {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let scenes: Vec<Scene> = (0..N_SCENES).map(|_| scene(&mut rng, sides)).collect();
        let mut next = scenes.iter().cycle();
        criterion.bench_function(&format!("pose from nine touches {name}"), |bencher| {
            bencher.iter(|| {
                let scene = next.next().expect("a cycle does not end");
                fit_pose(&part, black_box(&scene.touches), &scene.start, &scene.options)
            });
        });
    }
}

criterion_group!(benches, nine_touches);
criterion_main!(benches);
