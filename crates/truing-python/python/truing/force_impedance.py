"""Contact force and position impedance of a polishing head on four legs.

Frame Y: origin in the joint, the straight tool along −y. Legs and cells are in the order ``l1, l2, l3`` (radial), ``l4``
(axial); cells read compression positive; normals point out of the workpiece, so that pressing is positive.

>>> import numpy as np
>>> head = Head(
...     tip_to_plane_mm=120.0, plane_to_joint_mm=180.0, head_radius_mm=40.0, bracket_radius_mm=110.0,
...     leg_angles_rad=np.radians([90.0, 210.0, 330.0]).tolist(), weight_n=60.0, center_of_gravity_mm=150.0,
... )
>>> lengths_mm = head.lengths_mm((4.0, -301.5, -2.5))
>>> force = contact_force(head, [lengths_mm], [[22.0, 51.0, 49.0, 81.0]], [[0.0, 1.0, 0.0]])
>>> bool(force.normal_n[0] > 70.0), bool(abs(force.consistency_mm[0]) < 1e-9)
(True, True)
>>> controller = Controller(head, mass_kg=5.0, damping_ns_per_mm=2.0)
>>> controller.update(lengths_mm, [22.0, 51.0, 49.0, 81.0], [0.0, 1.0, 0.0], 75.0, 1e-3)["status"]
'recovering'
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._truing import Controller, Head
from .arrays import table

__all__ = ["ContactForces", "Controller", "Head", "contact_force"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ContactForces:
    """What every reading of legs and load cells says of the contact."""

    #: Normal force.
    normal_n: Floats
    #: Force across the normal.
    tangential_n: Floats
    #: Internal force of the legs.
    preload_n: Floats
    #: Disagreement of the four lengths.
    consistency_mm: Floats
    #: Standard uncertainty of the normal force per standard uncertainty of one cell.
    noise_gain: Floats
    #: Where the tip was, frame Y.
    tip_mm: Floats


def contact_force(
    head: Head,
    lengths_mm: ArrayLike,
    cells_n: ArrayLike,
    normals: ArrayLike,
    *,
    formula: Literal["full-balance", "published"] = "full-balance",
) -> ContactForces:
    """Contact force of every reading: lengths and load cells ``n × 4``, outward unit normals ``n × 3``."""
    return ContactForces(**head.contact_force(table(lengths_mm), table(cells_n), table(normals), formula))
