#!/usr/bin/env python3
"""Writes the clouds that registration is compared on.   usage: problems.py 100k|1m|scan|scan-SEED|basin|poses OUTDIR

100k, 1m: freeform face z = f(x, y), 200 x 200 mm. Target: as many points on a jittered grid, with analytic normals. Source: as many
other points of the face with 2 um noise along the normal, 184 x 184 mm, moved by a known transform of 0.5 deg and 0.9 mm.
scan:     as 100k, but 20 um noise on both sides and half an overlap: the target is the face with x < 25 mm, the source that with x > -75 mm,
          of which a third lies beside the target; scan-SEED is another drawing of points and noise.

basin:    as 100k with 40 000 and 4000 points, and starts.bin: rows of angle_deg, shift_mm and a pose (R by rows, t), the true one after a
          rotation by that angle about the middle of the source and a shift by that way, both in random directions.

poses:    poses.bin alone: nine ball centres over the paraboloid R = 480 mm, diameter 100 mm, of document [D], 1 um noise in each
          coordinate, tilted by up to 10 mrad; rows of start size s, centres (9 x 3) and a start: x, y, z off by up to s * 5 mm, alpha, beta
          by up to s * 10 mrad, gamma = 0.

Files, little-endian doubles: target.bin, target_n.bin, source.bin (n x 3), T_true.bin (R by rows, t; target from source).
"""
import os
import sys

import numpy as np


def surface(x, y):
    z = (x * x + y * y) / 1200.0 + 0.8 * np.sin(x / 23.0 + 0.4) * np.cos(y / 31.0)
    z += 0.35 * np.sin((x + 1.7 * y) / 17.0) + 6e-7 * x**3 - 4e-7 * y**3 * x / 50
    zx = x / 600.0 + 0.8 / 23.0 * np.cos(x / 23.0 + 0.4) * np.cos(y / 31.0)
    zx += 0.35 / 17.0 * np.cos((x + 1.7 * y) / 17.0) + 1.8e-6 * x**2 - 4e-7 * y**3 / 50
    zy = y / 600.0 - 0.8 / 31.0 * np.sin(x / 23.0 + 0.4) * np.sin(y / 31.0)
    zy += 0.35 * 1.7 / 17.0 * np.cos((x + 1.7 * y) / 17.0) - 1.2e-6 * y**2 * x / 50
    n = np.stack([-zx, -zy, np.ones_like(x)], -1)
    return np.stack([x, y, z], -1), n / np.linalg.norm(n, axis=-1, keepdims=True)


def rotation(w):
    angle = np.linalg.norm(w)
    k = w / angle
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


ANGLES_DEG = (5, 15, 30, 45, 60)
SHIFTS_MM = (0, 10, 30, 60)
STARTS_EACH = 10


def starts(rng, middle, r, t):
    rows = []
    for angle in ANGLES_DEG:
        for shift in SHIFTS_MM:
            for _ in range(STARTS_EACH):
                axis, way = rng.normal(size=(2, 3))
                turn = rotation(np.deg2rad(angle) * axis / np.linalg.norm(axis))
                moved = turn @ (t - middle) + middle + shift * way / np.linalg.norm(way)
                rows.append(np.concatenate([[angle, shift], (turn @ r).ravel(), moved]))
    return np.array(rows)


SIZES = (0.25, 1, 2, 4, 8)
POSES_EACH = 2000
RADIUS_MM, TIP_MM, NOISE_MM = 480.0, 3.0, 1e-3


def write_poses(out):
    rng = np.random.Generator(np.random.PCG64(202))
    ring = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    xy = np.concatenate([[[0, 0]], 20 * ring, 40 * ring])
    normal = np.column_stack([-xy / RADIUS_MM, np.ones(9)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    balls = np.column_stack([xy, (xy**2).sum(1) / (2 * RADIUS_MM)]) + TIP_MM * normal
    rows = []
    for size in SIZES:
        for _ in range(POSES_EACH):
            alpha, beta = rng.uniform(-0.01, 0.01, 2)
            place = np.array([-499.3, -474.6, -284.9]) + rng.uniform(-5, 5, 3)
            turn = rotation_about(1, beta) @ rotation_about(0, alpha)
            seen = balls @ turn.T + place + rng.normal(0, NOISE_MM, (9, 3))
            start = np.concatenate([place, [alpha, beta]]) + size * rng.uniform(-1, 1, 5) * [5, 5, 5, 0.01, 0.01]
            rows.append(np.concatenate([[size], seen.ravel(), start]))
    os.makedirs(out, exist_ok=True)
    np.array(rows).astype("<f8").tofile(os.path.join(out, "poses.bin"))


def rotation_about(axis, angle):
    return rotation(angle * np.eye(3)[axis])


def write(name, count, out):
    is_scan = name.startswith("scan")
    seed = int(name[len("scan-"):]) if name.startswith("scan-") else 201
    n_source = 4000 if name == "basin" else count
    rng = np.random.Generator(np.random.PCG64(seed))
    m = int(round(np.sqrt(count)))
    h = 200.0 / m
    gx, gy = np.meshgrid(np.arange(m), np.arange(m), indexing="ij")
    x = -100 + h * (gx.ravel() + 0.5) + rng.uniform(-0.3, 0.3, m * m) * h
    y = -100 + h * (gy.ravel() + 0.5) + rng.uniform(-0.3, 0.3, m * m) * h
    target, normals = surface(x, y)
    order = rng.permutation(m * m)
    target, normals = target[order], normals[order]
    source, source_n = surface(rng.uniform(-92, 92, n_source), rng.uniform(-92, 92, n_source))
    source = source + source_n * rng.normal(0, 2e-2 if is_scan else 2e-3, (n_source, 1))
    if is_scan:
        keep = target[:, 0] < 25.0
        target, normals = target[keep], normals[keep]
        target = target + normals * rng.normal(0, 2e-2, (len(target), 1))
        source = source[source[:, 0] > -75.0]
    r = rotation(np.deg2rad(np.array([0.25, -0.2, 0.35])))
    t = np.array([0.6, -0.45, 0.5])
    os.makedirs(out, exist_ok=True)
    if name == "basin":
        starts(rng, source.mean(axis=0), r, t).astype("<f8").tofile(os.path.join(out, "starts.bin"))
    for file, values in [
        ("target", target),
        ("target_n", normals),
        ("source", (source - t) @ r),
        ("T_true", np.concatenate([r.ravel(), t])),
    ]:
        values.astype("<f8").tofile(os.path.join(out, file + ".bin"))


if __name__ == "__main__":
    problem, folder = sys.argv[1:3]
    if problem == "poses":
        sys.exit(write_poses(folder))
    write(problem, {"1m": 1_000_000, "basin": 40_000}.get(problem, 100_000), folder)
