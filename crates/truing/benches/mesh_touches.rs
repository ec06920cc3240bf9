//! Time of compensating a million touches on a mesh of a million triangles.

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use truing::pose_icp::{Holes, MeshSurface, TriangleMesh};
use truing::probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};

const TIP_MM: f64 = 3.0;
const N_TOUCHES: u32 = 1_000_000;
/// Cells along a side; two triangles each.
const N_CELLS: u32 = 708;
/// Half the side of the part.
const REACH_MM: f64 = 50.0;

fn height(x: f64, y: f64) -> f64 {
    (x * x + y * y) / 240.0
}

fn mesh() -> MeshSurface {
    let side = N_CELLS + 1;
    let place = |i: u32| REACH_MM * (2.0 * f64::from(i) / f64::from(N_CELLS) - 1.0);
    let vertex = |v: u32| {
        let (x, y) = (place(v % side), place(v / side));
        Point3::new(x, y, height(x, y))
    };
    let vertices_mm = (0..side * side).map(vertex).collect();
    let cell = |c: u32| {
        let a = c / N_CELLS * side + c % N_CELLS;
        [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
    };
    let faces = (0..N_CELLS * N_CELLS).flat_map(cell).collect();
    MeshSurface::new(&TriangleMesh { vertices_mm, faces }, Holes::Refuse)
        .expect("the mesh is sound")
}

fn million(criterion: &mut Criterion) {
    let nominal = Nominal::new(Arc::new(mesh()), Side::Along);
    let ball = |i: u32| {
        let radius = 48.0 * (f64::from(i) / f64::from(N_TOUCHES)).sqrt();
        let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        let normal = Vector3::new(-x / 120.0, -y / 120.0, 1.0).normalize();
        BallTouch::new(Point3::new(x, y, height(x, y)) + normal * (TIP_MM + 4e-3), 1e-3)
    };
    let touches: Vec<BallTouch> = (0..N_TOUCHES).map(ball).collect();
    let mut group = criterion.benchmark_group("touches on a mesh of 1e6 triangles");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(N_TOUCHES)));
    group.bench_function("nominal normal", |bencher| {
        bencher.iter(|| compensate(&nominal, TIP_MM, black_box(&touches), NormalSource::Nominal));
    });
    group.finish();
}

criterion_group!(benches, million);
criterion_main!(benches);
