"""Where a polishing head really presses, from a six-axis force/torque sensor.

A wrench acts on the sensor, ``[fx, fy, fz, mx, my, mz]`` in N and N·mm, its moment about the sensor's reference point.
"""

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


@dataclass(frozen=True)
class ContactCenter:
    """Centre of pressure of many wrenches."""

    #: Centre in the contact plane, sensor frame.
    center_mm: Floats
    #: Its covariance, from the scatter of the means of 64 stretches of the record.
    covariance_mm2: Floats
    #: Degrees of freedom of the covariance: intervals are Student's.
    degrees_of_freedom: int
    #: Mean wrench in contact.
    mean_wrench: Floats
    #: Mean moment about z that the force does not explain.
    free_moment_nmm: float
    #: Samples in contact.
    contact_samples: int


def locate_contact(wrenches: ArrayLike, *, z0_mm: float, min_fz_n: float) -> ContactCenter:
    """The one place where many wrenches (``n × 6``) press, ``z0_mm`` above the sensor's reference point.

    Samples with ``|fz|`` under ``min_fz_n`` are not in contact. Columns that are contiguous (order ``"F"``) are read where
    they lie.

    >>> import numpy as np
    >>> force_n, at_mm = np.array([3.0, 0.0, -40.0]), np.array([12.0, -7.0, 30.0])
    >>> wrench = np.concatenate([force_n, np.cross(at_mm, force_n)])
    >>> load = np.linspace(1.0, 2.0, 640)
    >>> found = locate_contact(load[:, None] * wrench, z0_mm=30.0, min_fz_n=5.0)
    >>> found.center_mm.round(9).tolist(), found.contact_samples
    ([12.0, -7.0], 640)
    """
    return ContactCenter(**_truing.locate_contact(table(wrenches), z0_mm, min_fz_n))


def centers(wrenches: ArrayLike, *, z0_mm: float, min_fz_n: float) -> tuple[Floats, Floats]:
    """Centre of pressure of every wrench, x and y in mm; NaN where nothing is touched."""
    return _truing.centers(table(wrenches), z0_mm, min_fz_n)


@dataclass(frozen=True)
class Press:
    """One press as recorded."""

    #: Name.
    name: str
    #: ``frame``: position known, places the sensor; ``check``: known, only judged; ``locate``: sought.
    use: Literal["frame", "check", "locate"]
    #: Where the head was sent, x and y of the machine.
    machine_mm: Sequence[float]
    #: Time of each reading.
    time_s: ArrayLike
    #: Wrench of each reading, ``n × 6``.
    wrench: ArrayLike


@dataclass(frozen=True)
class Located:
    """The sensor in the machine, and every press."""

    #: Angle of ``sensor = Rot(angle) · Mirror · machine + translation``.
    angle_rad: float
    #: Shift of the same map.
    translation_mm: Floats
    #: Whether the z axes oppose each other, so that Mirror is diag(1, −1).
    opposed: bool
    #: Names of the presses, in the order given.
    names: list[str]
    #: Centre of each orbit, sensor frame.
    sensor_mm: Floats
    #: The same, machine frame.
    machine_mm: Floats
    #: Found − commanded position.
    offset_mm: Floats
    #: Standard uncertainty of the offset.
    std_mm: Floats
    #: Degrees of freedom of ``std_mm``: intervals are Student's.
    degrees_of_freedom: float
    #: How well the head seats: scatter from press to press along each axis.
    seat_mm: float


def locate(
    presses: Sequence[Press],
    *,
    z0_mm: float,
    min_fz_n: float | None = None,
    noise: tuple[float, float] | None = None,
    spin_hz: float | None = None,
) -> Located:
    """Places the sensor by presses at known positions, and every press in the machine.

    ``noise`` is the standard uncertainty of one force (N) and one moment (N·mm); without it the records' own scatter
    tells.
    """
    recorded = [
        (
            press.name,
            press.use,
            _pair(press),
            column(press.time_s),
            table(press.wrench),
        )
        for press in presses
    ]
    return Located(**_truing.locate_presses(recorded, z0_mm, min_fz_n, noise, spin_hz))


def _pair(press: Press) -> tuple[float, float]:
    at = floats(press.machine_mm)
    if at.shape != (2,):
        raise InputError(f"press {press.name}: machine_mm must be x and y")
    return float(at[0]), float(at[1])
