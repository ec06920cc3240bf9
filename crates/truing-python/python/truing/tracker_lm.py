"""Six errors of a rotary axis from laser-tracer displacements, by multilateration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _truing
from .arrays import column, indices, table

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Calibration:
    """A calibrated axis: everything with its standard uncertainty."""

    #: Names of the six errors, ISO 230-1: for B ``EXB EYB EZB EAB EBB ECB``.
    names: list[str]
    #: Angles, in the order in which they were first measured.
    angles_rad: Floats
    #: The six errors at each angle, mm and rad, relative to the first.
    errors: Floats
    #: Their standard uncertainties.
    errors_std: Floats
    #: Stations, machine frame.
    stations_mm: Floats
    stations_std_mm: Floats
    #: Reflectors, in the frame that turns with the axis.
    mounts_mm: Floats
    mounts_std_mm: Floats
    #: Distances at which the tracer reads zero, by station and mount.
    dead_paths_mm: Floats
    #: Names of the location errors, where the angles show them.
    location_names: list[str] | None
    #: Location errors of the axis, mm and rad.
    location: Floats | None
    location_covariance: Floats | None
    #: Root mean square residual of the ranges.
    rms_mm: float
    #: Equations minus unknowns.
    degrees_of_freedom: int
    #: Mean whitened square residual, near 1 where the declared noise is honest.
    variance_factor: float
    #: Standard uncertainty of one displacement, declared or estimated.
    displacement_std_mm: float
    #: Residual of every range, in the order given.
    residuals_mm: Floats
    #: Share of an error of each range that its own residual shows.
    redundancy: Floats
    #: Steps of the search.
    iterations: int


def calibrate(
    *,
    letter: Literal["A", "B", "C"],
    origin_mm: ArrayLike,
    direction: ArrayLike,
    stations_mm: ArrayLike,
    mounts_mm: ArrayLike,
    angles_rad: ArrayLike,
    station: ArrayLike,
    mount: ArrayLike,
    step: ArrayLike,
    displacement_mm: ArrayLike,
    formulation: Literal["joint", "free-points"] = "joint",
    dead_path: Literal["lock", "station"] = "lock",
    gauge: Literal["stations", "minimal", "inner"] = "stations",
    order: Literal["fixed", "rotating"] = "fixed",
    displacement_std_mm: float | None = None,
    rigid_std_mm: float | None = None,
    station_std_mm: float | None = None,
) -> Calibration:
    """Finds stations, reflectors, dead paths, and the six errors at every angle.

    ``stations_mm`` are nominal positions in the machine frame, ``mounts_mm`` nominal reflectors in the frame that turns
    with the axis, ``angles_rad`` one angle a step. ``station``, ``mount`` and ``step`` are indices from 0, one a reading.
    Standard uncertainties that are not given are estimated from the residual, or leave the result oriented only.
    """
    return Calibration(
        **_truing.calibrate(
            (letter, column(origin_mm), column(direction)),
            table(stations_mm),
            table(mounts_mm),
            column(angles_rad),
            (indices(station), indices(mount), indices(step), column(displacement_mm)),
            [formulation, dead_path, gauge, order],
            [displacement_std_mm, rigid_std_mm, station_std_mm],
        )
    )
