//! `ours DIR THREADS RUNS`: the registration of pose-icp. One JSON line a run.
//!
//! Besides the whole: building the tree apart, and the nearest target point of every source point
//! in no order, sorting included, in ns of processor time a query; beside it what merely reading
//! the answers takes, below which memory lets no exact search go.

use std::path::PathBuf;
use std::time::Instant;

use cpu_time::ProcessTime;
use icp_peers::{error_um, read_points, read_truth};
use nalgebra::{Point3, Unit};
use pose_icp::{CloudTarget, Nearest, PointCloud, RegisterOptions, register_to_cloud};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let directory = PathBuf::from(arguments.next().expect("DIR"));
    let threads: usize = arguments.next().expect("THREADS").parse().expect("a count");
    let runs: usize = arguments.next().expect("RUNS").parse().expect("a count");
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("first pool");
    let normals = read_points(&directory.join("target_n.bin"));
    let normals = normals.into_iter().map(|n| Unit::new_unchecked(n.coords)).collect();
    let target = PointCloud::with_normals(read_points(&directory.join("target.bin")), normals);
    let source = PointCloud::new(read_points(&directory.join("source.bin")));
    let truth = read_truth(&directory.join("T_true.bin"));
    for _ in 0..runs {
        let start = Instant::now();
        let cpu = ProcessTime::now();
        let prepared = CloudTarget::new(&target).expect("usable target");
        let build_s = start.elapsed().as_secs_f64();
        let build_cpu_s = cpu.elapsed().as_secs_f64();
        let fit = register_to_cloud(&source, &prepared, &RegisterOptions::default());
        let wall_s = start.elapsed().as_secs_f64();
        let cpu_s = cpu.elapsed().as_secs_f64();
        let start = ProcessTime::now();
        let nearest = prepared.nearest(&source.points_mm).expect("usable queries");
        let query_ns = start.elapsed().as_secs_f64() * 1e9 / nearest.len() as f64;
        let floor_ns = reading_ns(&source.points_mm, &target.points_mm, &nearest);
        let fit = fit.expect("converges");
        let pose = fit.target_from_source;
        let error = error_um(&source.points_mm, |p| truth * p, |p| pose * p);
        println!(
            "{{\"wall_s\":{wall_s:.6},\"cpu_s\":{cpu_s:.6},\"build_s\":{build_s:.6},\"build_cpu_s\":{build_cpu_s:.6},\
             \"query_ns\":{query_ns:.1},\"floor_ns\":{floor_ns:.1},\"iterations\":{},\"full_iterations\":{},\"rms_mm\":{:.6e},\
             \"error_um\":{error:.4},\"converged\":true}}",
            fit.iterations, fit.full_iterations, fit.rms_mm
        );
    }
}

/// Processor time a query of reading each query and the point that answers it, in the order given.
fn reading_ns(queries: &[Point3<f64>], points: &[Point3<f64>], nearest: &[Nearest]) -> f64 {
    let start = ProcessTime::now();
    let sum: f64 =
        queries.iter().zip(nearest).map(|(q, n)| (q - points[n.index]).norm_squared()).sum();
    std::hint::black_box(sum);
    start.elapsed().as_secs_f64() * 1e9 / queries.len() as f64
}
