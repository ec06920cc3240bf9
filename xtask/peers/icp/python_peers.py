#!/usr/bin/env python3
"""Registers a problem with a packaged peer.   usage: python_peers.py PEER DISTANCE DIR THREADS RUNS|basin

Peers: open3d-plane, small_gicp-plane, small_gicp-gicp. One JSON line a run: wall and processor seconds of building the search tree and
registering, wall seconds of building the tree apart, largest error of a source point in um, whether the peer says that it converged. Given normals are used, none are estimated.
With «basin»: from each start of starts.bin instead, one JSON line an angle and shift with the starts that led to within 50 um.
Pairs further apart than the distance, in mm, do not count. Stops at 1e-8 rad and 1e-6 mm (small_gicp), or at a change of fitness and of rmse, in mm, of
1e-6, its own criterion (Open3D), or after 100 iterations.
"""
import json
import os
import sys
import time

peer, distance, folder, threads, runs = sys.argv[1], float(sys.argv[2]), sys.argv[3], int(sys.argv[4]), sys.argv[5]
# Before the libraries start their pools.
os.environ["OMP_NUM_THREADS"] = str(threads)
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])

import numpy as np  # noqa: E402

MAX_ITERATIONS = 100
FOUND_UM = 50.0


def load(name, width=3):
    return np.fromfile(os.path.join(folder, name + ".bin")).reshape(-1, width)


target, normals, source = load("target"), load("target_n"), load("source")
truth = np.fromfile(os.path.join(folder, "T_true.bin"))
expected = source @ truth[:9].reshape(3, 3).T + truth[9:]


def open3d_plane():
    import open3d as o3d

    registration = o3d.pipelines.registration
    fixed, moving = o3d.geometry.PointCloud(), o3d.geometry.PointCloud()
    fixed.points, fixed.normals = o3d.utility.Vector3dVector(target), o3d.utility.Vector3dVector(normals)
    moving.points = o3d.utility.Vector3dVector(source)

    def build():
        # What the registration builds inside once more; it takes no tree.
        o3d.geometry.KDTreeFlann(fixed)

    def run(start):
        found = registration.registration_icp(
            moving,
            fixed,
            distance,
            start,
            registration.TransformationEstimationPointToPlane(),
            registration.ICPConvergenceCriteria(1e-6, 1e-6, MAX_ITERATIONS),
        )
        return found.transformation, None

    return run, build


def small_gicp(kind):
    import small_gicp as sg

    homogeneous = np.hstack([target, np.ones((len(target), 1))])
    fixed = sg.PointCloud(homogeneous)
    moving = sg.PointCloud(np.hstack([source, np.ones((len(source), 1))]))
    sg.estimate_normals_covariances(fixed, num_neighbors=10, num_threads=threads)
    if kind == "GICP":
        sg.estimate_covariances(moving, num_neighbors=10, num_threads=threads)

    def build():
        return sg.KdTree(fixed, num_threads=threads)

    def run(start):
        tree = build()
        found = sg.align(
            fixed,
            moving,
            tree,
            start,
            registration_type=kind,
            max_correspondence_distance=distance,
            num_threads=threads,
            max_iterations=MAX_ITERATIONS,
            rotation_epsilon=1e-8,
            translation_epsilon=1e-6,
        )
        return found.T_target_source, bool(found.converged)

    return run, build


run, build = {
    "open3d-plane": open3d_plane,
    "small_gicp-plane": lambda: small_gicp("PLANE_ICP"),
    "small_gicp-gicp": lambda: small_gicp("GICP"),
}[peer]()


def error_um(pose):
    miss = source @ pose[:3, :3].T + pose[:3, 3] - expected
    return float(np.linalg.norm(miss, axis=1).max()) * 1e3


def speed():
    for _ in range(int(runs)):
        wall, cpu = time.perf_counter(), time.process_time()
        pose, converged = run(np.eye(4))
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        line = {"wall_s": wall, "cpu_s": cpu, "error_um": error_um(pose), "converged": converged}
        wall = time.perf_counter()
        build()
        line["build_s"] = time.perf_counter() - wall
        print(json.dumps(line), flush=True)


def basin():
    cells = {}
    for row in load("starts", 14):
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = row[2:11].reshape(3, 3), row[11:]
        found = error_um(run(start)[0]) < FOUND_UM
        cells.setdefault((row[0], row[1]), []).append(found)
    for (angle, shift), found in cells.items():
        line = {"angle_deg": angle, "shift_mm": shift, "found": sum(found), "starts": len(found)}
        print(json.dumps(line), flush=True)


basin() if runs == "basin" else speed()
