"""The transform between two frames from points measured in both, with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _truing
from .arrays import floats, table

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FrameFit:
    """An estimated transform, with its uncertainty and the residuals that it leaves."""

    #: Homogeneous matrix, target from source.
    matrix: Floats
    #: Its linear part.
    linear: Floats
    #: Its shift.
    translation_mm: Floats
    #: Point of the target frame about which the parameters rotate and stretch.
    pivot_mm: Floats
    #: Names of the parameters of ``covariance``.
    parameters: list[str]
    #: Their units.
    units: list[str]
    #: A-priori covariance of a small motion on the left about ``pivot_mm``.
    covariance: Floats
    #: Standard uncertainties; ``None`` where the noise is to be estimated and nothing is redundant.
    std: Floats | None
    #: Root mean square length of the residuals.
    rms_mm: float
    #: ``to − T·from``, in the order given.
    residuals_mm: Floats
    #: Coordinates used minus parameters.
    degrees_of_freedom: int
    #: Weighted sum of squares over the degrees of freedom, near 1 where ``std_mm`` is honest.
    variance_factor: float | None
    #: Robust weight of each point, 1 without a loss.
    weights: Floats
    #: Steps of the search after the closed form.
    iterations: int

    def apply(self, points_mm: ArrayLike) -> Floats:
        """Points of the source frame in the target frame."""
        return np.asarray(floats(points_mm) @ self.linear.T + self.translation_mm)


def fit(
    from_mm: ArrayLike,
    to_mm: ArrayLike,
    std_mm: ArrayLike,
    *,
    transform: Literal["none", "translation", "rigid", "similarity", "affine"] = "rigid",
    handedness: Literal["proper", "improper"] = "proper",
    estimate_noise: bool = False,
    loss: Literal["huber", "cauchy", "tukey"] | None = None,
) -> FrameFit:
    """Fits the transform that takes ``from_mm`` to ``to_mm``, both ``n × 3`` or ``n × 2``.

    ``std_mm`` is the standard uncertainty of the difference: one number, one a point, one a coordinate (``n × 3``), or a
    covariance a point (``n × 3 × 3``, mm²). With ``estimate_noise`` it only weighs points against each other.

    >>> import numpy as np
    >>> turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> points_mm = np.random.default_rng(1).uniform(-100.0, 100.0, (20, 3))
    >>> fitted = fit(points_mm, points_mm @ turned.T + [1.0, 2.0, 3.0], std_mm=0.01)
    >>> bool(np.allclose(fitted.linear, turned)), fitted.degrees_of_freedom
    (True, 54)
    >>> fitted.parameters
    ['tx', 'ty', 'tz', 'rx', 'ry', 'rz']
    """
    return FrameFit(
        **_truing.fit_frame(
            table(from_mm), table(to_mm), floats(std_mm), transform, handedness, estimate_noise, loss
        )
    )
