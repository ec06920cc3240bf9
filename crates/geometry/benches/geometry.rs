//! Time per call of exp, log, Jacobians, closest point and ray hit.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use geometry::nalgebra::{Point3, Vector3, Vector6};
use geometry::{Asphere, AsphereShape, Line, Nurbs, Surface, se3, so3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Inputs taken in turn, so that no branch is learnt by heart.
const N_INPUTS: usize = 1024;

fn twists(angle_rad: f64) -> Vec<Vector6<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let scale = Vector6::new(500.0, 500.0, 500.0, angle_rad, angle_rad, angle_rad);
    let unit = |_, _| rng.random_range(-1.0..1.0);
    let mut unit = unit;
    (0..N_INPUTS).map(|_| Vector6::from_fn(&mut unit).component_mul(&scale)).collect()
}

fn groups(criterion: &mut Criterion) {
    for (regime, angle_rad) in [("1e-6 rad", 1e-6), ("1 rad", 1.0)] {
        let twists = twists(angle_rad);
        let poses: Vec<_> = twists.iter().map(se3::exp).collect();
        let mut next = (0..N_INPUTS).cycle();
        let mut take = move || next.next().expect("cycles");
        let mut group = criterion.benchmark_group("se3");
        group.bench_function(BenchmarkId::new("exp", regime), |b| {
            b.iter(|| se3::exp(black_box(&twists[take()])));
        });
        group.bench_function(BenchmarkId::new("log", regime), |b| {
            b.iter(|| se3::log(black_box(&poses[take()])));
        });
        group.bench_function(BenchmarkId::new("left_jacobian", regime), |b| {
            b.iter(|| se3::left_jacobian(black_box(&twists[take()])));
        });
        group.bench_function(BenchmarkId::new("left_jacobian_inverse", regime), |b| {
            b.iter(|| se3::left_jacobian_inverse(black_box(&twists[take()])));
        });
        group.finish();
        let rotations: Vec<_> = twists.iter().map(|t| t.fixed_rows::<3>(3).into_owned()).collect();
        criterion.bench_function(&format!("so3/exp/{regime}"), |b| {
            b.iter(|| so3::exp(black_box(&rotations[take()])));
        });
    }
}

fn shapes() -> [(&'static str, AsphereShape); 3] {
    let terms = vec![3e-6, -2.5e-8, 1.2e-10, -2e-13];
    [
        ("paraboloid R480 D100", AsphereShape::on_axis(480.0, -1.0, vec![], 100.0)),
        ("lens R-21 D24 A4..A10", AsphereShape::on_axis(-21.0, -0.7, terms, 24.0)),
        ("sphere R25 D49", AsphereShape::on_axis(25.0, 0.0, vec![], 49.0)),
    ]
}

/// Points of the surface moved by up to `away_mm` in every direction.
fn queries(asphere: &Asphere, away_mm: f64) -> Vec<Point3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let side = 0.35 * asphere.shape().diameter_mm;
    let mut query = || {
        let (x, y) = (rng.random_range(-side..side), rng.random_range(-side..side));
        let z = asphere.sag_mm(x, y).expect("within the aperture");
        let off = Vector3::from_fn(|_, _| rng.random_range(-away_mm..away_mm));
        Point3::new(x, y, z) + off
    };
    (0..N_INPUTS).map(|_| query()).collect()
}

fn aspheres(criterion: &mut Criterion) {
    for (name, shape) in shapes() {
        let asphere = Asphere::new(shape.clone()).expect("valid shape");
        let mut next = (0..N_INPUTS).cycle();
        let mut take = move || next.next().expect("cycles");
        let mut group = criterion.benchmark_group("asphere");
        // A form error, a probe's ball, and past centres of curvature, where all feet are sought.
        let far_mm = 2.0 * shape.radius_mm.abs();
        for (kind, away_mm) in [("1 um", 1e-3), ("3 mm", 3.0), ("2 R", far_mm)] {
            let queries = queries(&asphere, away_mm);
            let id = BenchmarkId::new(format!("closest_point {kind} away"), name);
            group.bench_function(id, |b| {
                b.iter(|| asphere.closest_point(black_box(&queries[take()])));
            });
        }
        let rays: Vec<_> = queries(&asphere, 0.1)
            .into_iter()
            .map(|p| {
                let tilt = Vector3::new(0.01 * p.x, -0.3, -1.0);
                Line::new(p - tilt * 50.0, tilt).expect("has a direction")
            })
            .collect();
        group.bench_function(BenchmarkId::new("first_hit", name), |b| {
            b.iter(|| asphere.first_hit(black_box(&rays[take()])));
        });
        group.bench_function(BenchmarkId::new("new", name), |b| {
            b.iter(|| Asphere::new(black_box(shape.clone())));
        });
        group.finish();
    }
}

/// Balls of 3 mm on nets as CAD programs write them, 600 mm wide.
fn nurbs(criterion: &mut Criterion) {
    for count in [30_u32, 100, 300] {
        let at = |k: u32| 600.0 * (f64::from(k) / f64::from(count - 1) - 0.5);
        let height =
            |x: f64, y: f64| 20.0 * (x / 90.0).sin() * (y / 110.0).cos() + 0.3 * (x / 7.0).sin();
        let points: Vec<Point3<f64>> = (0..count * count)
            .map(|k| [at(k % count), at(k / count)])
            .map(|[x, y]| Point3::new(x, y, height(x, y)))
            .collect();
        let knots =
            || [Nurbs::clamped_knots(3, count as usize), Nurbs::clamped_knots(3, count as usize)];
        let weights = vec![1.0; points.len()];
        let new = || Nurbs::new([3, 3], knots(), &points, &weights).expect("a surface");
        let surface = new();
        let [[_, last], _] = surface.domain();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut ball = || {
            let [u, v] = [0; 2].map(|_| rng.random_range(0.02 * last..0.98 * last));
            surface.offset_point(u, v, 3.0).expect("within the knots")
        };
        let balls: Vec<Point3<f64>> = (0..N_INPUTS).map(|_| ball()).collect();
        let mut next = (0..N_INPUTS).cycle();
        let mut take = move || next.next().expect("cycles");
        let mut group = criterion.benchmark_group("nurbs");
        group.sample_size(10);
        let name = format!("{count} x {count}");
        group.bench_function(BenchmarkId::new("closest_point 3 mm away", &name), |b| {
            b.iter(|| surface.closest_point(black_box(&balls[take()])));
        });
        group.bench_function(BenchmarkId::new("new", &name), |b| b.iter(&new));
        group.finish();
    }
}

criterion_group!(benches, groups, aspheres, nurbs);
criterion_main!(benches);
