"""Tables: dictionaries of columns, or whatever hands over an Arrow stream."""

from __future__ import annotations

import csv as writer
import io
import math
from collections.abc import Mapping
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike

from . import arrow
from .errors import InputError

#: Columns by name, or a table of pandas, polars, pyarrow and others.
TableLike = Union[Mapping[str, ArrayLike], arrow.ArrowStream]


def columns(table: TableLike) -> dict[str, arrow.Column]:
    """Columns by name.

    >>> columns({"point": ["a", "b"], "x_mm": [1, 2.5]})
    {'point': ['a', 'b'], 'x_mm': array([1. , 2.5])}
    """
    # A table of polars or pandas is no mapping, and one of its own is asked for columns first.
    if isinstance(table, arrow.ArrowStream):
        return arrow.read(table)
    if not isinstance(table, Mapping):
        raise InputError(
            f"a table must be a dictionary of columns or have an Arrow stream, got {type(table).__name__}"
        )
    return {str(name): _column(str(name), values) for name, values in table.items()}


def _column(name: str, values: ArrayLike) -> arrow.Column:
    found = np.asarray(values)
    if found.ndim != 1:
        raise InputError(f"column {name!r} must be one value a row, got {found.ndim} dimensions")
    if found.dtype.kind in "OUS":
        return ["" if value is None else str(value) for value in found.tolist()]
    return found


def csv(table: TableLike) -> str:
    """A table as the CSV of a case; numbers in as many digits as bring them back.

    >>> print(csv({"point": ["a", "b"], "x_mm": [0.1, float("nan")]}), end="")
    point,x_mm
    a,0.1
    b,
    """
    found = columns(table)
    lengths = {len(values) for values in found.values()}
    if len(lengths) > 1:
        raise InputError(f"columns must be equally long, got {sorted(lengths)}")
    out = io.StringIO()
    rows = writer.writer(out, lineterminator="\n")
    rows.writerow(found)
    cells = (values if isinstance(values, list) else map(_cell, values.tolist()) for values in found.values())
    rows.writerows(zip(*cells))
    return out.getvalue()


def _cell(value: Any) -> str:
    if isinstance(value, float) and math.isnan(value):
        return ""
    return repr(value)
