"""How long calls on many points take from Python, and the same calls in Rust, turn by turn in one run:

    PYO3_BUILD_EXTENSION_MODULE=1 cargo build --release --examples
    python examples/overhead.py target/release/examples/overhead_mimalloc

The Rust half (``overhead.rs``) is built with the same features and profile as the package, has its records at hand before
the clock starts, and drops its results within, as Python drops those of the call before. ``overhead_mimalloc`` has the
allocator of the package, ``overhead`` that of the system.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import truing
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Call = Callable[[], object]
#: What the Rust half is called with, what it reads, and the call from Python.
Compared = tuple[str, dict[str, Floats], Call]


def turned() -> Floats:
    """A rotation by about one radian."""
    axis = np.array([0.3, -0.8, 0.5])
    angle = np.linalg.norm(axis)
    x, y, z = axis / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


def frame(points: int, transform: Literal["rigid", "similarity", "affine"], per_axis: bool) -> Compared:
    """Points in a cube of 1 m with 10 µm of noise, before and after a rotation and a shift."""
    draws = np.random.default_rng(1)
    from_mm = draws.uniform(-500.0, 500.0, (points, 3))
    std_mm = np.tile([0.01, 0.01, 0.03], (points, 1)) if per_axis else np.array(0.01)
    to_mm = from_mm @ turned().T + [100.0, 20.0, -7.0] + draws.normal(0.0, 1.0, (points, 3)) * std_mm

    def call() -> object:
        return truing.frame_fit.fit(from_mm, to_mm, std_mm, transform=transform)

    return transform, {"from_mm": from_mm, "to_mm": to_mm, "std_mm": std_mm}, call


def contact(points: int) -> Compared:
    """Wrenches of one place, 0.1 N and 1 N·mm of noise; columns lie together."""
    draws = np.random.default_rng(2)
    force_n, at_mm = np.array([3.0, 0.0, -40.0]), np.array([12.0, -7.0, 30.0])
    wrench = np.concatenate([force_n, np.cross(at_mm, force_n)])
    noise = draws.normal(0.0, 1.0, (6, points)) * np.array([0.1, 0.1, 0.1, 1.0, 1.0, 1.0])[:, None]
    columns = wrench[:, None] * draws.uniform(1.0, 2.0, points) + noise

    def call() -> object:
        return truing.ft_center.locate_contact(columns.T, z0_mm=30.0, min_fz_n=5.0)

    return "locate-contact", {"wrenches": columns}, call


def touches(points: int) -> Compared:
    """Centres of a ball of 3 mm on a paraboloid, 1 µm of noise."""
    draws = np.random.default_rng(3)
    xy = draws.uniform(-100.0, 100.0, (points, 2))
    normals = np.column_stack([-xy / 480.0, np.ones(points)])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    contacts = np.column_stack([xy, (xy**2).sum(axis=1) / 960.0])
    centers_mm = contacts + (3.0 + draws.normal(0.0, 1e-3, (points, 1))) * normals
    part = truing.Surface.asphere(480.0, conic=-1.0, diameter_mm=320.0)

    def call() -> object:
        return truing.probe_comp.compensate(part, centers_mm, 1e-3, tip_radius_mm=3.0)

    return "compensate", {"centers_mm": centers_mm}, call


def clouds(points: int) -> Compared:
    """A wave of 1 mm, twice with 10 µm of noise, 0.2 mm and some mrad apart."""
    draws = np.random.default_rng(4)

    def cloud() -> tuple[Floats, Floats]:
        x, y = draws.uniform(-100.0, 100.0, (2, points))
        z = np.sin(x / 20.0) + np.cos(y / 30.0) + draws.normal(0.0, 0.01, points)
        normals = np.column_stack([-np.cos(x / 20.0) / 20.0, np.sin(y / 30.0) / 30.0, np.ones(points)])
        return np.column_stack([x, y, z]), normals / np.linalg.norm(normals, axis=1)[:, None]

    (source_mm, _), (target_mm, normals) = cloud(), cloud()
    source_mm = source_mm @ np.array([[1.0, -2e-3, 0.0], [2e-3, 1.0, 1e-3], [0.0, -1e-3, 1.0]]) + 0.2

    def call() -> object:
        return truing.pose_icp.register(source_mm, target_mm, target_normals=normals)

    return "register", {"source_mm": source_mm, "target_mm": target_mm, "normals": normals}, call


def forces(points: int) -> Compared:
    """Readings of legs and load cells, the tool about straight."""
    draws = np.random.default_rng(5)
    head = truing.force_impedance.Head(
        tip_to_plane_mm=120.0,
        plane_to_joint_mm=180.0,
        head_radius_mm=40.0,
        bracket_radius_mm=110.0,
        leg_angles_rad=np.radians([90.0, 210.0, 330.0]).tolist(),
        weight_n=60.0,
        center_of_gravity_mm=150.0,
    )
    tips_mm = draws.normal([4.0, -301.5, -2.5], 1.0, (points, 3))
    lengths_mm = np.array([head.lengths_mm(tip) for tip in tips_mm.tolist()])
    cells_n = draws.normal([22.0, 51.0, 49.0, 81.0], 0.5, (points, 4))
    normals = np.tile([0.0, 1.0, 0.0], (points, 1))

    def call() -> object:
        return truing.force_impedance.contact_force(head, lengths_mm, cells_n, normals)

    return "contact-force", {"lengths_mm": lengths_mm, "cells_n": cells_n, "normals": normals}, call


def processor_s(pid: int) -> float:
    """Processor time that a process has used, all its threads together; Linux."""
    return time.clock_gettime((~pid << 3) | 2)  # The clock that clock_getcpuclockid(3) names.


def compare(rust: Path, compared: Compared, rounds: int, repeats: int) -> tuple[Floats, Floats]:
    """Seconds and processor seconds of every call (``2 × n``) from Python and in Rust, in turns, so that both see the
    same machine; processor times are means of a round."""
    name, arrays, call = compared
    from_python, in_rust = [], []
    with tempfile.TemporaryDirectory() as folder:
        for array, numbers in arrays.items():
            numbers.tofile(Path(folder) / array)
        other = subprocess.Popen([rust, name, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert other.stdin is not None and other.stdout is not None
        for turn in range(rounds + 1):
            answer, python_s = None, []
            used_s = time.process_time()
            for _ in range(repeats):
                started = time.perf_counter()
                answer = call()
                python_s.append(time.perf_counter() - started)
            used_s = time.process_time() - used_s
            del answer
            rust_used_s = processor_s(other.pid)
            other.stdin.write(f"{repeats}\n")
            other.stdin.flush()
            rust_s = [float(other.stdout.readline()) for _ in range(repeats)]
            rust_used_s = processor_s(other.pid) - rust_used_s
            if turn > 0:  # The first warms up, and reads what it needs.
                from_python += [(s, used_s / repeats) for s in python_s]
                in_rust += [(s, rust_used_s / repeats) for s in rust_s]
        other.stdin.close()
        assert other.wait() == 0
    return np.array(from_python).T, np.array(in_rust).T


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("rust", type=Path, help="one of the two programs built from overhead.rs")
    arguments.add_argument("--points", type=int, default=100_000)
    arguments.add_argument("--rounds", type=int, default=20)
    arguments.add_argument("--repeats", type=int, default=5, help="calls in a row, in each round")
    arguments.add_argument("--only", default="", help="calls whose line has this word")
    options = arguments.parse_args()
    n = options.points
    calls: dict[str, Callable[[], Compared]] = {
        "frame_fit.fit, rigid": lambda: frame(n, "rigid", False),
        "frame_fit.fit, rigid, a standard uncertainty per axis": lambda: frame(n, "rigid", True),
        "frame_fit.fit, similarity": lambda: frame(n, "similarity", False),
        "frame_fit.fit, affine": lambda: frame(n, "affine", False),
        "ft_center.locate_contact": lambda: contact(n),
        "probe_comp.compensate": lambda: touches(n),
        "pose_icp.register": lambda: clouds(n),
        "force_impedance.contact_force": lambda: forces(n),
    }
    print(f"{n} points, medians of {options.rounds * options.repeats} calls: ms from Python and in Rust, ms of processor time")
    for line, make in calls.items():
        if options.only not in line:
            continue
        from_python, in_rust = (np.median(1e3 * of, axis=1) for of in compare(options.rust, make(), options.rounds, options.repeats))
        told = [
            f"{a:.2f} {b:.2f} ({100.0 * (a / b - 1.0):+.1f} %)" for a, b in zip(from_python, in_rust, strict=True)
        ]
        print(f"{line}: {told[0]}, processor {told[1]}", flush=True)


if __name__ == "__main__":
    main()
