"""Where a workpiece lies, from touches of its surface, or from a cloud."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _truing
from .arrays import column, floats, table
from .errors import InputError

Floats = NDArray[np.float64]
Component = Literal["x", "y", "z", "alpha", "beta", "gamma"]

_COMPONENTS = ("x", "y", "z", "alpha", "beta", "gamma")


@dataclass(frozen=True)
class PoseFit:
    """Pose of a part: ``p_machine = Rz(γ) Ry(β) Rx(α) p + d``."""

    #: Homogeneous matrix, machine from workpiece.
    matrix: Floats
    #: ``[x, y, z, α, β, γ]``, mm and rad.
    pose: Floats
    #: Covariance of ``pose``.
    covariance: Floats
    #: Standard uncertainties of ``pose``; ``None`` where the noise is to be estimated and nothing is redundant.
    std: Floats | None
    #: Where the surface was touched, workpiece frame.
    contacts_mm: Floats
    #: Distance of each ball from the surface, less its radius.
    residuals_mm: Floats
    #: Touches minus unknowns.
    degrees_of_freedom: int
    #: Mean whitened square residual, near 1 where ``std_mm`` is honest.
    variance_factor: float | None
    #: Motions that the touches hardly show.
    weak: list[str]
    #: Steps of the search.
    iterations: int


def locate(
    surface: _truing.Surface,
    touches_mm: ArrayLike,
    std_mm: ArrayLike,
    *,
    tip_radius_mm: float = 0.0,
    side: Literal["+z", "-z"] = "+z",
    hold: Sequence[Component] = ("gamma",),
    start: ArrayLike | None = None,
    gamma_rad: float = 0.0,
    estimate_noise: bool = False,
) -> PoseFit:
    """Fits the pose of a part to the centres of a ball that touched it (``n × 3``, machine frame).

    ``hold`` names what stays as it is at the start: the rotation about z of a part that is round, unless told otherwise.
    ``start`` is ``[x, y, z, α, β, γ]``; without it the touches give one, level and turned by ``gamma_rad``, at which no
    position can be held.

    >>> import numpy as np
    >>> from truing import Surface
    >>> part = Surface.asphere(480.0, conic=-1.0, diameter_mm=100.0)
    >>> xy = np.array([[0, 0], [40, 0], [0, 40], [-40, 0], [0, -40], [30, 30], [-30, 20]], dtype=float)
    >>> touches_mm = np.column_stack([xy, 0.2 + (xy**2).sum(axis=1) / 960.0])
    >>> fit = locate(part, touches_mm, 1e-3, hold=["x", "y", "gamma"], start=np.zeros(6))
    >>> round(float(fit.pose[2]), 9)
    0.2
    """
    if start is None and set(hold) & {"x", "y", "z"}:
        raise InputError("a position is held where the start has it: give start")
    at = np.array([0.0, 0.0, 0.0, 0.0, 0.0, gamma_rad]) if start is None else column(start)
    if at.shape != (6,):
        raise InputError("start must be x, y, z in mm and alpha, beta, gamma in rad")
    return PoseFit(
        **_truing.fit_pose(
            surface,
            table(touches_mm),
            floats(std_mm),
            tip_radius_mm,
            side == "-z",
            list(hold),
            (at.tolist(), start is not None),
            estimate_noise,
        )
    )


@dataclass(frozen=True)
class Registration:
    """Where one cloud lies on another."""

    #: Homogeneous matrix, target from source.
    matrix: Floats
    #: Covariance of a small motion ``[tx, ty, tz, rx, ry, rz]`` on the left about ``pivot_mm``.
    covariance: Floats
    #: Point of the target frame that rotations turn about.
    pivot_mm: Floats
    #: Standard uncertainty of one residual.
    std_mm: float
    #: Root mean square residual of the points used.
    rms_mm: float
    #: Points of the source that took part in the end.
    used: int
    #: Passes over the points.
    iterations: int
    #: Motions that the shape hardly shows.
    weak: list[str]


def register(
    source_mm: ArrayLike,
    target_mm: ArrayLike,
    *,
    target_normals: ArrayLike | None = None,
    source_normals: ArrayLike | None = None,
    method: Literal["point-to-plane", "point-to-point", "symmetric"] = "point-to-plane",
    start: ArrayLike | None = None,
    hold: Sequence[Component] = (),
    loss: Literal["huber", "cauchy", "tukey"] | None = None,
    keep_share: float = 1.0,
    max_distance_mm: float | None = None,
    tolerance_mm: float = 1e-6,
    max_iterations: int = 100,
    neighbours: int = 12,
) -> Registration:
    """Moves one cloud onto another (both ``n × 3``), as ``truing register`` does with files.

    Normals that the method needs and that are not given come from the planes through ``neighbours`` points. ``start`` is a
    homogeneous matrix.
    """
    unknown = set(hold) - set(_COMPONENTS)
    if unknown:
        raise InputError(f"hold must be of {', '.join(_COMPONENTS)}, got {', '.join(sorted(unknown))}")
    source, target = table(source_mm), table(target_mm)
    of_target = None if target_normals is None else table(target_normals)
    of_source = None if source_normals is None else table(source_normals)
    if of_target is None and method != "point-to-point":
        of_target = normals(target, neighbours=neighbours)
    if of_source is None and method == "symmetric":
        of_source = normals(source, neighbours=neighbours)
    return Registration(
        **_truing.register(
            (source, of_source),
            (target, of_target),
            method,
            None if start is None else table(start),
            [name in hold for name in _COMPONENTS],
            loss,
            keep_share,
            max_distance_mm,
            tolerance_mm,
            max_iterations,
        )
    )


def normals(
    points_mm: ArrayLike, *, neighbours: int = 12, viewpoint_mm: Sequence[float] | None = None
) -> Floats:
    """Unit normals of a cloud from the planes through the nearest points, the point itself among them."""
    viewpoint = None if viewpoint_mm is None else [float(v) for v in viewpoint_mm]
    return _truing.estimate_normals(table(points_mm), neighbours, viewpoint)
