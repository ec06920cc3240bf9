"""Arrays as the native half takes them; one that is right already is not copied."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError


def floats(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers of any shape."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"numbers are needed: {error}") from None


def table(values: ArrayLike) -> NDArray[np.float64]:
    """Some numbers a row."""
    found = floats(values)
    if found.ndim != 2:
        raise InputError(f"a table of rows and columns is needed, got {found.ndim} dimensions")
    return found


def column(values: ArrayLike) -> NDArray[np.float64]:
    """One number a row, without gaps."""
    found = np.ascontiguousarray(floats(values))
    if found.ndim != 1:
        raise InputError(f"one number a row is needed, got {found.ndim} dimensions")
    return found


def indices(values: ArrayLike) -> NDArray[np.int64]:
    """One index a row, from 0."""
    found = np.asarray(values)
    if found.ndim != 1 or not np.issubdtype(found.dtype, np.integer):
        raise InputError("one whole number a row is needed, counted from 0")
    return found.astype(np.int64, copy=False)
