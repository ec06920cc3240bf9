//! `threecrate_plane DISTANCE DIR THREADS RUNS`: point-to-plane registration of threecrate, in single
//! precision, as it computes. One JSON line a run.
//!
//! Its tree is built inside; there is no handle to build it apart. Stops at its own default, a
//! relative gain of 1e-6, or after 100 iterations.

use std::path::PathBuf;
use std::time::Instant;

use cpu_time::ProcessTime;
use icp_peers::{error_um, read_points, read_truth};
use nalgebra::{Isometry3, Point3};
use threecrate_algorithms::registration::icp_point_to_plane_detailed;
use threecrate_core::PointCloud;

const MAX_ITERATIONS: usize = 100;
const CONVERGENCE: f32 = 1e-6;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let distance: f32 = arguments.next().expect("DISTANCE").parse().expect("a number of mm");
    let directory = PathBuf::from(arguments.next().expect("DIR"));
    let threads: usize = arguments.next().expect("THREADS").parse().expect("a count");
    let runs: usize = arguments.next().expect("RUNS").parse().expect("a count");
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("first pool");
    let source = read_points(&directory.join("source.bin"));
    let truth = read_truth(&directory.join("T_true.bin"));
    let single = |points: &[Point3<f64>]| {
        PointCloud::from_points(points.iter().map(|p| p.cast::<f32>()).collect())
    };
    let fixed = single(&read_points(&directory.join("target.bin")));
    let moving = single(&source);
    let normals = read_points(&directory.join("target_n.bin"));
    let normals: Vec<_> = normals.iter().map(|n| n.coords.cast::<f32>()).collect();
    for _ in 0..runs {
        let (start, cpu) = (Instant::now(), ProcessTime::now());
        let fit = icp_point_to_plane_detailed(
            &moving,
            &fixed,
            &normals,
            Isometry3::identity(),
            MAX_ITERATIONS,
            Some(distance),
            CONVERGENCE,
        );
        let (wall_s, cpu_s) = (start.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
        let fit = fit.expect("usable clouds");
        let pose = fit.transformation.cast::<f64>();
        let error = error_um(&source, |p| truth * p, |p| pose * p);
        println!(
            "{{\"wall_s\":{wall_s:.6},\"cpu_s\":{cpu_s:.6},\"iterations\":{},\"error_um\":{error:.4},\
             \"converged\":{}}}",
            fit.iterations, fit.converged
        );
    }
}
