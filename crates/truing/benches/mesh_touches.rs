//! Time of compensating a million touches on a mesh of a million triangles.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use truing::pose_icp::{Holes, MeshSurface, TriangleMesh};
use truing::probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};

const TIP_MM: f64 = 3.0;
/// Lines of a scan, and touches of a line.
const N_LINES: u32 = 1000;
/// Touches in an order that visits the whole part again and again.
const N_SCATTERED: u32 = 100_000;
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

/// A ball 4 µm above the bowl.
fn touch(x: f64, y: f64) -> BallTouch {
    let normal = Vector3::new(-x / 120.0, -y / 120.0, 1.0).normalize();
    BallTouch::new(Point3::new(x, y, height(x, y)) + normal * (TIP_MM + 4e-3), 1e-3)
}

/// Line by line, as a machine scans: the next touch is beside the last.
fn scan() -> Vec<BallTouch> {
    let place = |i: u32| 0.96 * REACH_MM * (2.0 * f64::from(i) / f64::from(N_LINES - 1) - 1.0);
    (0..N_LINES).flat_map(|j| (0..N_LINES).map(move |i| touch(place(i), place(j)))).collect()
}

/// A sunflower from its middle: the next touch is somewhere else.
fn scattered() -> Vec<BallTouch> {
    let place = |i: u32| {
        let radius = 48.0 * (f64::from(i) / f64::from(N_SCATTERED)).sqrt();
        let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
        touch(radius * cos, radius * sin)
    };
    (0..N_SCATTERED).map(place).collect()
}

fn million(criterion: &mut Criterion) {
    let nominal = Nominal::new(Arc::new(mesh()), Side::Along);
    let mut group = criterion.benchmark_group("touches on a mesh of 1e6 triangles");
    // A pass takes seconds: ten of them, and no warming up beyond one.
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(1));
    for (name, touches) in [("line by line", scan()), ("scattered", scattered())] {
        group.throughput(Throughput::Elements(touches.len().try_into().expect("a million")));
        group.bench_function(name, |bencher| {
            bencher
                .iter(|| compensate(&nominal, TIP_MM, black_box(&touches), NormalSource::Nominal));
        });
    }
    group.finish();
}

criterion_group!(benches, million);
criterion_main!(benches);
