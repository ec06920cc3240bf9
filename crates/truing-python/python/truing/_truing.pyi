"""The native half; call the modules of ``truing`` instead."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_Indices = NDArray[np.int64]
_Answer = tuple[str, str, list[str], list[str]]
_Parameter = tuple[str, str, float]
_Effect = tuple[str, str | None, str, str | None, bool, Sequence[_Parameter]]
_Cloud = tuple[_Floats, _Floats | None]

__all__ = [
    "Controller",
    "Head",
    "Surface",
    "__version__",
    "calibrate",
    "centers",
    "check",
    "close_loop",
    "close_machine",
    "close_own_loop",
    "compensate",
    "depth",
    "estimate_normals",
    "fit_frame",
    "fit_pose",
    "init",
    "kinds",
    "locate_contact",
    "locate_presses",
    "plan",
    "register",
    "solve",
]

__version__: str

def solve(
    case: str, allow_outside: bool, timing: bool, report: str | None, monte_carlo: int | None
) -> _Answer: ...
def close_loop(
    case: str,
    carry: str | None,
    allow_outside: bool,
    timing: bool,
    report: str | None,
    monte_carlo: int | None,
) -> _Answer: ...
def check(case: str, allow_outside: bool) -> _Answer: ...
def plan(
    case: str,
    answer: str | None,
    aim: str | None,
    budget: tuple[int | None, float | None],
    out: str | None,
    allow_outside: bool,
) -> _Answer: ...
def close_machine(folder: str, allow_outside: bool) -> _Answer: ...
def depth(
    case: str, program: str, planned: Sequence[float] | None, allow_outside: bool
) -> _Answer: ...
def init(kind: str, folder: str) -> list[str]: ...
def kinds() -> list[tuple[str, str]]: ...
def fit_frame(
    from_mm: _Floats,
    to_mm: _Floats,
    std_mm: _Floats,
    transform: str,
    handedness: str,
    estimate_noise: bool,
    loss: str | None,
) -> dict[str, Any]: ...
def locate_contact(wrenches: _Floats, z0_mm: float, min_fz_n: float) -> dict[str, Any]: ...
def centers(wrenches: _Floats, z0_mm: float, min_fz_n: float) -> tuple[_Floats, _Floats]: ...
def locate_presses(
    presses: Sequence[tuple[str, str, tuple[float, float], _Floats, _Floats]],
    z0_mm: float,
    min_fz_n: float | None,
    noise: tuple[float, float] | None,
    spin_hz: float | None,
) -> dict[str, Any]: ...
def calibrate(
    axis: tuple[str, _Floats, _Floats],
    stations_mm: _Floats,
    mounts_mm: _Floats,
    angles_rad: _Floats,
    ranges: tuple[_Indices, _Indices, _Indices, _Floats],
    choices: Sequence[str],
    noise: Sequence[float | None],
) -> dict[str, Any]: ...
def fit_pose(
    surface: Surface,
    touches_mm: _Floats,
    std_mm: _Floats,
    tip_radius_mm: float,
    below: bool,
    held: Sequence[str],
    start: tuple[Sequence[float], bool],
    estimate_noise: bool,
) -> dict[str, Any]: ...
def register(
    source: _Cloud,
    target: _Cloud,
    objective: str,
    start: _Floats | None,
    hold: Sequence[bool],
    loss: str | None,
    keep_share: float,
    max_distance_mm: float | None,
    tolerance_mm: float,
    max_iterations: int,
) -> dict[str, Any]: ...
def estimate_normals(
    points_mm: _Floats, neighbours: int, viewpoint_mm: Sequence[float] | None
) -> _Floats: ...
def compensate(
    surface: Surface,
    centers_mm: _Floats,
    std_mm: _Floats,
    tip_radius_mm: float,
    against: bool,
    normal: str,
    approach: _Floats | None,
    guide_mm: _Floats | None,
) -> dict[str, Any]: ...
def close_own_loop(
    residuals: Callable[[_Floats, list[_Floats]], _Floats],
    layout: tuple[str, int, Sequence[str], Sequence[str]],
    std: _Floats | None,
    base: Sequence[_Parameter],
    start: Sequence[float],
    effects: Sequence[_Effect],
    covariates: Sequence[tuple[str, Sequence[float]]],
    options: tuple[float, int, bool],
) -> dict[str, Any]: ...

@final
class Surface:
    """A surface as drawn, in the workpiece frame."""

    @staticmethod
    def asphere(
        radius_mm: float,
        conic: float = 0.0,
        coefficients: Sequence[float] = ...,
        *,
        diameter_mm: float,
    ) -> Surface:
        """`z = r²/(R(1 + √(1 − (1 + k) r²/R²))) + A4 r⁴ + A6 r⁶ + …`, vertex at the origin."""
    @staticmethod
    def sphere(radius_mm: float, center_mm: Sequence[float] = ...) -> Surface:
        """A sphere; its own side is the outside."""
    @staticmethod
    def plane(point_mm: Sequence[float] = ..., normal: Sequence[float] = ...) -> Surface:
        """A plane; its own side is the one that its normal points to."""
    @staticmethod
    def polynomial(unit_mm: float, terms: Sequence[tuple[int, int, float]]) -> Surface:
        """`z = Σ a (x/unit)^i (y/unit)^j` of terms `(i, j, a)`, a in mm."""

@final
class Head:
    """A polishing head on three radial legs and one axial unit."""

    def __new__(
        cls,
        *,
        tip_to_plane_mm: float,
        plane_to_joint_mm: float,
        head_radius_mm: float,
        bracket_radius_mm: float,
        leg_angles_rad: Sequence[float],
        weight_n: float = 0.0,
        center_of_gravity_mm: float = 0.0,
        gravity_direction: Sequence[float] = ...,
    ) -> Head: ...
    def lengths_mm(self, tip_mm: Sequence[float]) -> list[float]:
        """Lengths of the legs and the axial unit that put the tip somewhere."""
    def contact_force(
        self,
        lengths_mm: _Floats,
        cells_n: _Floats,
        normals: _Floats,
        formula: str = "full-balance",
    ) -> dict[str, Any]:
        """Contact force of every reading of legs and load cells."""

@final
class Controller:
    """Force control by position impedance along the surface normal."""

    def __new__(
        cls,
        head: Head,
        *,
        mass_kg: float,
        damping_ns_per_mm: float,
        stiffness_n_per_mm: float = 0.0,
        interval_s: float = 1e-3,
        absolute: bool = False,
    ) -> Controller: ...
    def update(
        self,
        lengths_mm: Sequence[float] | None,
        cells_n: Sequence[float] | None,
        normal: Sequence[float],
        reference_n: float,
        dt_s: float,
    ) -> dict[str, Any]:
        """One cycle: readings in, lengths to command out."""
