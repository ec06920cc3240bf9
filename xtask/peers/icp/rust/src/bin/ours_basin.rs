//! `ours_basin DIR THREADS`: from how far off pose-icp finds the pose. One JSON line an angle and
//! shift of the starts, with those that led to within 50 µm.

use std::path::PathBuf;

use icp_peers::{error_um, read_points, read_starts, read_truth};
use nalgebra::Unit;
use pose_icp::{CloudTarget, PointCloud, RegisterOptions, register_to_cloud};

/// Largest error of any point, µm, at which the pose counts as found.
const FOUND_UM: f64 = 50.0;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let directory = PathBuf::from(arguments.next().expect("DIR"));
    let threads: usize = arguments.next().expect("THREADS").parse().expect("a count");
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("first pool");
    let normals = read_points(&directory.join("target_n.bin"));
    let normals = normals.into_iter().map(|n| Unit::new_unchecked(n.coords)).collect();
    let target = PointCloud::with_normals(read_points(&directory.join("target.bin")), normals);
    let target = CloudTarget::new(&target).expect("usable target");
    let source = PointCloud::new(read_points(&directory.join("source.bin")));
    let truth = read_truth(&directory.join("T_true.bin"));
    let mut cells: Vec<([f64; 2], usize, usize)> = Vec::new();
    for (cell, start) in read_starts(&directory.join("starts.bin")) {
        let options = RegisterOptions { start, ..RegisterOptions::default() };
        let is_found = register_to_cloud(&source, &target, &options).is_ok_and(|fit| {
            let pose = fit.target_from_source;
            error_um(&source.points_mm, |p| truth * p, |p| pose * p) < FOUND_UM
        });
        if cells.last().is_none_or(|last| last.0 != cell) {
            cells.push((cell, 0, 0));
        }
        let last = cells.last_mut().expect("one was pushed");
        last.1 += usize::from(is_found);
        last.2 += 1;
    }
    for ([angle, shift], found, starts) in cells {
        println!(
            "{{\"angle_deg\":{angle},\"shift_mm\":{shift},\"found\":{found},\"starts\":{starts}}}"
        );
    }
}
