//! Time of compensating a million touches on smooth surfaces, and by measured normals.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use geometry::{Asphere, AsphereShape, Polynomial};
use nalgebra::{Point3, Vector3};
use probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};

const TIP_MM: f64 = 3.0;
const N_TOUCHES: u32 = 1_000_000;
const N_MICRO: u32 = 100_000;

/// Balls on the bowl z = (x² + y²)/240, over a sunflower of Φ96, 4 µm high.
fn touches(n: u32) -> Vec<BallTouch> {
    let ball = |i: u32| {
        let radius = 48.0 * (f64::from(i) / f64::from(n)).sqrt();
        let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        let normal = Vector3::new(-x / 120.0, -y / 120.0, 1.0).normalize();
        BallTouch::new(Point3::new(x, y, (x * x + y * y) / 240.0) + normal * (TIP_MM + 4e-3), 1e-3)
    };
    (0..n).map(ball).collect()
}

fn million(criterion: &mut Criterion) {
    let asphere = Asphere::new(AsphereShape::on_axis(120.0, -1.0, vec![], 100.0))
        .expect("the paraboloid is sound");
    let polynomial = Polynomial::new(1.0, [(2, 0, 1.0 / 240.0), (0, 2, 1.0 / 240.0)])
        .expect("the polynomial is sound");
    let touches = touches(N_TOUCHES);
    let mut group = criterion.benchmark_group("touches by the nominal normal");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(N_TOUCHES)));
    for (name, nominal) in [
        ("asphere", Nominal::new(Arc::new(asphere), Side::Along)),
        ("polynomial", Nominal::new(Arc::new(polynomial), Side::Along)),
    ] {
        group.bench_function(name, |bencher| {
            bencher
                .iter(|| compensate(&nominal, TIP_MM, black_box(&touches), NormalSource::Nominal));
        });
    }
    group.finish();
}

fn measured_normals(criterion: &mut Criterion) {
    let asphere = Asphere::new(AsphereShape::on_axis(120.0, -1.0, vec![], 100.0))
        .expect("the paraboloid is sound");
    let nominal = Nominal::new(Arc::new(asphere), Side::Along);
    let mut touches = touches(N_MICRO);
    for touch in &mut touches {
        touch.micro_mm = (0..8)
            .map(|k| {
                let (sin, cos) = (0.785 * f64::from(k)).sin_cos();
                touch.center_mm + Vector3::new(0.2 * cos, 0.2 * sin, 0.0)
            })
            .collect();
    }
    let mut group = criterion.benchmark_group("touches by a measured normal");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(N_MICRO)));
    for (name, source) in
        [("micro-plane", NormalSource::MicroPlane), ("quadric", NormalSource::Quadric)]
    {
        group.bench_function(name, |bencher| {
            bencher.iter(|| compensate(&nominal, TIP_MM, black_box(&touches), source));
        });
    }
    group.finish();
}

criterion_group!(benches, million, measured_normals);
criterion_main!(benches);
