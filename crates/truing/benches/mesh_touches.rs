//! Time of compensating a million touches on a mesh of a million triangles, and of fewer on one of
//! which the search tree stays in a processor's cache: the difference is what memory costs.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use truing::pose_icp::{Holes, MeshSurface, TriangleMesh};
use truing::probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};

const TIP_MM: f64 = 3.0;
/// Touches in an order that visits the whole part again and again.
const N_SCATTERED: u32 = 100_000;
/// Name, cells along a side with two triangles each, and lines of a scan with as many touches each.
const MESHES: [(&str, u32, u32); 2] = [("1e4", 71, 316), ("1e6", 708, 1000)];
/// Half the side of the part.
const REACH_MM: f64 = 50.0;

fn height(x: f64, y: f64) -> f64 {
    (x * x + y * y) / 240.0
}

fn mesh(n_cells: u32) -> MeshSurface {
    let side = n_cells + 1;
    let place = |i: u32| REACH_MM * (2.0 * f64::from(i) / f64::from(n_cells) - 1.0);
    let vertex = |v: u32| {
        let (x, y) = (place(v % side), place(v / side));
        Point3::new(x, y, height(x, y))
    };
    let vertices_mm = (0..side * side).map(vertex).collect();
    let cell = |c: u32| {
        let a = c / n_cells * side + c % n_cells;
        [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
    };
    let faces = (0..n_cells * n_cells).flat_map(cell).collect();
    MeshSurface::new(&TriangleMesh { vertices_mm, faces }, Holes::Refuse)
        .expect("the mesh is sound")
}

/// A ball 4 µm above the bowl.
fn touch(x: f64, y: f64) -> BallTouch {
    let normal = Vector3::new(-x / 120.0, -y / 120.0, 1.0).normalize();
    BallTouch::new(Point3::new(x, y, height(x, y)) + normal * (TIP_MM + 4e-3), 1e-3)
}

/// Line by line, as a machine scans: the next touch is beside the last.
fn scan(n_lines: u32) -> Vec<BallTouch> {
    let place = |i: u32| 0.96 * REACH_MM * (2.0 * f64::from(i) / f64::from(n_lines - 1) - 1.0);
    (0..n_lines).flat_map(|j| (0..n_lines).map(move |i| touch(place(i), place(j)))).collect()
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

fn touches(criterion: &mut Criterion) {
    for (triangles, n_cells, n_lines) in MESHES {
        let nominal = Nominal::new(Arc::new(mesh(n_cells)), Side::Along);
        let mut group =
            criterion.benchmark_group(format!("touches on a mesh of {triangles} triangles"));
        // A pass takes seconds: ten of them, and no warming up beyond one.
        group.sample_size(10).sampling_mode(SamplingMode::Flat);
        group.warm_up_time(Duration::from_millis(1));
        for (name, touches) in [("line by line", scan(n_lines)), ("scattered", scattered())] {
            group.throughput(Throughput::Elements(touches.len().try_into().expect("a million")));
            let compensated =
                || compensate(&nominal, TIP_MM, black_box(&touches), NormalSource::Nominal);
            group.bench_function(name, |bencher| bencher.iter(compensated));
        }
        group.finish();
    }
}

criterion_group!(benches, touches);
criterion_main!(benches);
