"""How long a call on many points takes from Python; beside it, the same call in Rust:

    cargo bench -p frame-fit -- "100000 pairs"
    python overhead.py

Both fit points in a cube of 1 m with 10 µm of noise, as the benchmark of the crate does.
"""

import argparse
import time

import numpy as np
import truing


def cloud(points: int, per_axis: bool) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """Points before and after a rotation and a shift, and their standard uncertainties."""
    draws = np.random.default_rng(1)
    axis = np.array([0.3, -0.8, 0.5])
    angle = np.linalg.norm(axis)
    x, y, z = axis / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    from_mm = draws.uniform(-500.0, 500.0, (points, 3))
    std_mm = np.tile([0.01, 0.01, 0.03], (points, 1)) if per_axis else np.array(0.01)
    to_mm = from_mm @ turned.T + [100.0, 20.0, -7.0] + draws.normal(0.0, 1.0, (points, 3)) * std_mm
    return from_mm, to_mm, std_mm


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--points", type=int, default=100_000)
    arguments.add_argument("--repeats", type=int, default=50)
    options = arguments.parse_args()
    for transform, per_axis in [("rigid", False), ("rigid", True), ("similarity", False), ("affine", False)]:
        from_mm, to_mm, std_mm = cloud(options.points, per_axis)
        times_s = []
        for _ in range(options.repeats):
            started = time.perf_counter()
            fit = truing.frame_fit.fit(from_mm, to_mm, std_mm, transform=transform)
            times_s.append(time.perf_counter() - started)
        assert abs(fit.variance_factor - 1.0) < 0.05, fit
        weights = "per axis" if per_axis else "isotropic"
        print(
            f"{transform}, {weights}, {options.points} pairs: "
            f"least {1e3 * min(times_s):.2f} ms, median {1e3 * float(np.median(times_s)):.2f} ms"
        )


if __name__ == "__main__":
    main()
