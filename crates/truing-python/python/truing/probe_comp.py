"""Where a ball probe really touched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _truing
from .arrays import floats, table

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Contacts:
    """Contacts, one for each touch."""

    #: Contact points, workpiece frame.
    points_mm: Floats
    #: Unit normals along which the ball was compensated, from the part to the ball.
    normals: Floats
    #: How far each contact is above the nominal surface, along its normal.
    deviation_mm: Floats
    #: Standard uncertainty of the deviation.
    deviation_std_mm: Floats
    #: Whether the contact is within the part's aperture.
    inside_aperture: NDArray[np.bool_]
    #: Contact less planned contact, where ``guide_mm`` says where the ball was sent to.
    error_mm: Floats | None


def compensate(
    surface: _truing.Surface,
    centers_mm: ArrayLike,
    std_mm: ArrayLike,
    *,
    tip_radius_mm: float,
    side: Literal["along", "against"] = "along",
    normal: Literal["nominal", "approach", "surface-fit"] = "nominal",
    approach: ArrayLike | None = None,
    guide_mm: ArrayLike | None = None,
) -> Contacts:
    """Contacts of a ball whose centres were read at ``centers_mm`` (``n × 3``, workpiece frame).

    ``side`` says on which side of the surface the ball is: where its normal points to, or the other one (inside a
    sphere). ``normal`` is along what the ball is compensated; ``approach`` (``n × 3``) leads from the ball towards the
    surface.

    >>> import numpy as np
    >>> from truing import Surface
    >>> found = compensate(Surface.sphere(12.5), [[0.0, 0.0, 15.503]], 1e-3, tip_radius_mm=3.0)
    >>> found.points_mm.round(9).tolist(), found.deviation_mm.round(9).tolist()
    ([[0.0, 0.0, 12.503]], [0.003])
    """
    return Contacts(
        **_truing.compensate(
            surface,
            table(centers_mm),
            floats(std_mm),
            tip_radius_mm,
            side == "against",
            normal,
            None if approach is None else table(approach),
            None if guide_mm is None else table(guide_mm),
        )
    )
