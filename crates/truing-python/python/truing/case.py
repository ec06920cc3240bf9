"""Case folders: what ``truing solve``, ``loop``, ``check``, ``plan`` and ``init`` do."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union

from . import _truing
from .answer import Checked, Closed, ClosedMachine, Depth, Planned, Solved
from .errors import InputError
from .tables import TableLike, csv

#: Draws of a Monte Carlo: fewer say nothing of an interval.
_FEWEST_DRAWS, _MOST_DRAWS = 100, 10_000_000

#: Largest budget of a plan, measurements or minutes.
_MOST_BUDGET = 1e6

#: Numbers of a pose.
_POSE = 6

#: A case folder, or a case that is still in memory.
CaseLike = Union[str, "os.PathLike[str]", "Case"]


@dataclass(frozen=True)
class Case:
    """A case in memory: what ``case.toml`` says, and its tables.

    Tables are dictionaries of columns, or anything with an Arrow stream: a table of pandas, polars or pyarrow. Column
    names are those of the case format.

    >>> pairs = {
    ...     "point": ["a", "b", "c", "d"],
    ...     "from_x_mm": [0.0, 100.0, 0.0, 100.0], "from_y_mm": [0.0, 0.0, 80.0, 80.0],
    ...     "to_x_mm": [5.0, 105.0, 5.0, 105.0], "to_y_mm": [1.0, 1.0, 81.0, 81.0],
    ... }
    >>> case = Case("frame-fit", {"pairs": pairs}, {"noise": {"point_mm": 0.01}})
    >>> solve(case).estimates.translation_mm
    [5.0, 1.0]
    """

    kind: str
    #: Tables by name, without ``.csv``.
    tables: Mapping[str, TableLike]
    #: Everything in ``case.toml`` but the kind.
    settings: Mapping[str, Any] = field(default_factory=dict)

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the case folder, which must not hold a case yet."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        texts = {f"{name}.csv": csv(table) for name, table in self.tables.items()}
        texts["case.toml"] = toml({"kind": self.kind, **self.settings})
        for name, text in texts.items():
            with open(folder / name, "x", encoding="utf-8", newline="") as file:
                file.write(text)
        return folder


def solve(
    case: CaseLike,
    *,
    report: str | os.PathLike[str] | None = None,
    monte_carlo: int | None = None,
    timing: bool = True,
    allow_outside: bool = False,
) -> Solved:
    """Fits the declared model of a case, as ``truing solve`` does.

    ``report`` is a page to write; ``monte_carlo`` solves it so many times more with its data drawn anew from their declared
    noise; without ``timing`` two runs answer the same bytes; ``allow_outside`` reads files that
    ``case.toml`` names outside of the folder.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = init("frame-fit", f"{folder}/case")
    ...     solved = solve(f"{folder}/case")
    >>> solved.kind, solved.residual.unit
    ('frame-fit', 'mm')
    """
    with _on_disk(case) as folder:
        return Solved(_truing.solve(folder, allow_outside, timing, _path(report), _draws(monte_carlo)))


def loop(
    case: CaseLike,
    *,
    carry: str | os.PathLike[str] | None = None,
    report: str | os.PathLike[str] | None = None,
    monte_carlo: int | None = None,
    timing: bool = True,
    allow_outside: bool = False,
) -> Closed:
    """Fits, finds what is missing, and judges the error before and after on unseen data, as ``truing loop`` does.

    ``carry`` is what ``truing loop`` printed as JSON on another case, whose effects then count as declared; ``monte_carlo``
    fits what the loop ended with so many times more with the data drawn anew.
    """
    with _on_disk(case) as folder:
        return Closed(_truing.close_loop(folder, _path(carry), allow_outside, timing, _path(report), _draws(monte_carlo)))


def check(case: CaseLike, *, allow_outside: bool = False) -> Checked:
    """Validates a case and says what it can and cannot determine, as ``truing check`` does."""
    with _on_disk(case) as folder:
        return Checked(_truing.check(folder, allow_outside))


def plan(
    case: CaseLike,
    *,
    answer: str | os.PathLike[str] | None = None,
    aim: str | None = None,
    measurements: int | None = None,
    minutes: float | None = None,
    out: str | os.PathLike[str] | None = None,
    allow_outside: bool = False,
) -> Planned:
    """Chooses what to measure next, as ``truing plan`` does.

    ``answer`` is what ``truing loop`` printed as JSON for the case (without it the loop is closed first), ``aim`` what the
    plan is made for, ``measurements`` or ``minutes`` the most that it may cost, and ``out`` a folder to write it to.
    """
    if measurements is not None and minutes is not None:
        raise InputError("a budget is a number of measurements or of minutes, not both")
    if any(budget is not None and not 0 < budget <= _MOST_BUDGET for budget in (measurements, minutes)):
        raise InputError(f"a budget is above 0 and up to {_MOST_BUDGET:g}")
    with _on_disk(case) as folder:
        return Planned(_truing.plan(folder, _path(answer), aim, (measurements, minutes), _path(out), allow_outside))


def machine(folder: str | os.PathLike[str], *, allow_outside: bool = False) -> ClosedMachine:
    """Closes the loop on the cases that ``machine.toml`` of a folder lists, as ``truing loop`` does there.

    What they share, as the scale of an axis, has one amplitude with the data of all.
    """
    return ClosedMachine(_truing.close_machine(os.fspath(folder), allow_outside))


def depth(
    case: CaseLike,
    program: str | os.PathLike[str],
    *,
    planned: Sequence[float] | None = None,
    allow_outside: bool = False,
) -> Depth:
    """How deep a part presses into a polishing tool along an NC program, as ``truing depth`` does.

    ``planned`` is the pose that the program was written for: x, y, z in mm, and alpha, beta, gamma in *degrees*, as in files.
    """
    if planned is not None and len(planned) != _POSE:
        raise InputError(f"planned has {len(planned)} numbers; a pose has six: x, y, z in mm, alpha, beta, gamma in degrees")
    with _on_disk(case) as folder:
        return Depth(_truing.depth(folder, os.fspath(program), planned, allow_outside))


def init(kind: str, folder: str | os.PathLike[str]) -> list[Path]:
    """Writes a small commented case to start from; the files that it wrote."""
    return [Path(path) for path in _truing.init(kind, os.fspath(folder))]


def kinds() -> dict[str, str]:
    """Kinds of cases, and what each is for.

    >>> sorted(kinds())
    ['force-impedance', 'frame-fit', 'ft-center', 'pose-icp', 'positioning', 'probe-comp', 'tracker-lm']
    """
    return dict(_truing.kinds())


class _on_disk(ExitStack):
    """The folder of a case; that of a case in memory is there for as long as it is needed."""

    def __init__(self, case: CaseLike) -> None:
        super().__init__()
        self._case = case

    def __enter__(self) -> str:  # type: ignore[override]
        super().__enter__()
        if not isinstance(self._case, Case):
            return os.fspath(self._case)
        folder = self.enter_context(tempfile.TemporaryDirectory(prefix="truing-"))
        return os.fspath(self._case.write(folder))


def _draws(monte_carlo: int | None) -> int | None:
    if monte_carlo is not None and not _FEWEST_DRAWS <= monte_carlo <= _MOST_DRAWS:
        raise InputError(f"monte_carlo is {monte_carlo}; give {_FEWEST_DRAWS} to {_MOST_DRAWS} draws")
    return monte_carlo


def _path(path: str | os.PathLike[str] | None) -> str | None:
    return None if path is None else os.fspath(path)


def toml(settings: Mapping[str, Any]) -> str:
    """Settings as TOML.

    >>> print(toml({"kind": "frame-fit", "noise": {"point_mm": 0.01}}), end="")
    kind = "frame-fit"
    [noise]
    point_mm = 0.01
    """
    plain = [f"{_key(k)} = {_value(v)}\n" for k, v in settings.items() if not isinstance(v, Mapping)]
    for name, section in settings.items():
        if isinstance(section, Mapping):
            plain.append(f"[{_key(name)}]\n")
            plain.extend(f"{_key(k)} = {_value(v)}\n" for k, v in section.items())
    return "".join(plain)


def _key(name: str) -> str:
    bare = name.replace("_", "").replace("-", "").isalnum() and name.isascii()
    return name if bare else json.dumps(name, ensure_ascii=False)


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if hasattr(value, "tolist"):
        return _value(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"case.toml holds no {type(value).__name__}")
