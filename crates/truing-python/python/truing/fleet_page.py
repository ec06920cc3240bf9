"""One page about many machines: which share an effect, which change from one case to the next, which need a look."""

from __future__ import annotations

import math
import os
from collections import defaultdict
from collections.abc import Callable
from html import escape
from pathlib import Path
from statistics import median
from typing import Any

#: Coverage factor of the expanded uncertainties shown.
_K = 2.0

_STYLE = """body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color-scheme:light dark}
div{overflow-x:auto;margin:.5rem 0 2rem}table{border-collapse:collapse}th,td{text-align:left;padding:.25rem 1.25rem .25rem 0;
border-bottom:1px solid #8884;vertical-align:top;font-variant-numeric:tabular-nums}.n{text-align:right;white-space:nowrap}
thead{display:table-header-group}tr{break-inside:avoid}@media print{div{overflow:visible}}"""

#: Columns of numbers.
_NUMBERS = {"cases", "machines", "median", "smallest", "largest", "first ± U", "last ± U", "change ± U", "error before", "after"}


def machine_of(case: str) -> str:
    """The name of a case's folder."""
    return case.rstrip("/").rsplit("/", 1)[-1]


def page(
    table: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    machine: Callable[[str], str] = machine_of,
) -> Path:
    """Writes a page about the rows of :func:`truing.fleet.run` beside them (or to ``out``); its path.

    ``machine`` tells from the address of a case which machine it is of; cases of one machine are in the order of their
    names. An effect whose size differs between the first and the last of them by more than the expanded uncertainty of
    the difference (k = 2) has changed.
    """
    from pyarrow import parquet

    table = Path(table)
    rows: list[dict[str, Any]] = parquet.read_table(table).to_pylist()
    machines: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        machines[machine(row["case"])].append(row)
    changed = [line for name, cases in sorted(machines.items()) for line in _changes(name, cases)]
    look = [row for row in rows if row["status"] != "answered" or row["verdict"] == "input-wrong"]
    content = "".join(
        [
            "<!DOCTYPE html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>",
            f"<title>Fleet</title><style>{_STYLE}</style><h1>{len(machines)} machines, {len(rows)} cases</h1>",
            _table("Answers", ["verdict or status", "cases"], _counts(rows)),
            _table(
                "What they share",
                ["effect", "amplitude", "machines", "median", "smallest", "largest", "unit"],
                _shared(machines),
            ),
            _table(
                "What changed between the first and the last case of a machine",
                ["machine", "effect", "amplitude", "first ± U", "last ± U", "change ± U", "unit"],
                changed,
            ),
            _table(
                "To be looked at",
                ["case", "status", "message"],
                [[row["case"], row["status"], row["message"] or row["verdict"] or ""] for row in look],
            ),
            _table(
                "Machines",
                ["machine", "cases", "last verdict", "effects of the last case", "error before", "after", "unit"],
                [_machine(name, cases) for name, cases in sorted(machines.items())],
            ),
            "<p>Every ± U is an expanded uncertainty, k = 2.</p>",
        ]
    )
    path = Path(out) if out is not None else table.with_suffix(".html")
    path.write_text(content, encoding="utf-8")
    return path


def _counts(rows: list[dict[str, Any]]) -> list[list[Any]]:
    counts: dict[str, int] = defaultdict(int)
    for row in rows:
        counts[row["verdict"] or row["status"]] += 1
    return [[name, n] for name, n in sorted(counts.items(), key=lambda item: (-item[1], item[0]))]


def _sizes(row: dict[str, Any]) -> dict[tuple[str, str, str], tuple[float, float]]:
    """Value and standard uncertainty by effect, amplitude and unit."""
    return {(s["effect"], s["name"], s["unit"]): (s["value"], s["std"]) for s in row["sizes"] or []}


def _shared(machines: dict[str, list[dict[str, Any]]]) -> list[list[Any]]:
    """Effects by how many machines have them in their last case, the most frequent first."""
    values: dict[tuple[str, str, str], list[float]] = defaultdict(list)
    for cases in machines.values():
        for key, (value, _) in _sizes(cases[-1]).items():
            values[key].append(value)
    order = sorted(values.items(), key=lambda item: (-len(item[1]), item[0]))
    return [[e, name, len(v), *(_number(of(v), 3) for of in (median, min, max)), unit] for (e, name, unit), v in order]


def _changes(name: str, cases: list[dict[str, Any]]) -> list[list[Any]]:
    """What an effect was in the first and the last case of a machine, where it is not the same.

    An effect that only one of them has is listed without a difference: the other may not show it.
    """
    if len(cases) < 2:
        return []
    first, last = _sizes(cases[0]), _sizes(cases[-1])
    lines: list[list[Any]] = []
    for key in sorted({*first, *last}):
        effect, amplitude, unit = key
        if key in first and key in last:
            change = last[key][0] - first[key][0]
            expanded = _K * (first[key][1] ** 2 + last[key][1] ** 2) ** 0.5
            if abs(change) <= expanded:
                continue
            difference = _with_expanded(change, expanded)
        else:
            difference = "not named in both"
        values = [_with_expanded(sizes[key][0], _K * sizes[key][1]) if key in sizes else "–" for sizes in (first, last)]
        lines.append([name, effect, amplitude, *values, difference, unit])
    return lines


def _machine(name: str, cases: list[dict[str, Any]]) -> list[Any]:
    last = cases[-1]
    found = [
        f"{effect} {amplitude} {_with_expanded(value, _K * std)} {unit}"
        for (effect, amplitude, unit), (value, std) in _sizes(last).items()
    ]
    errors = [_number(last[key]) for key in ("before_held_out_rms", "after_held_out_rms")]
    return [name, len(cases), last["verdict"] or last["status"], "; ".join(found), *errors, last["unit"] or ""]


def _number(value: float | None, digits: int = 4) -> str:
    return "–" if value is None else f"{value:.{digits}g}".replace("-", "−")


def _with_expanded(value: float, expanded: float) -> str:
    """A value and its expanded uncertainty to two significant digits, the value to the same place."""
    if not (math.isfinite(value) and math.isfinite(expanded) and expanded > 0.0):
        return _number(value)
    # As it is after rounding: 0.0996 is 0.10.
    decimals = 1 - int(f"{expanded:.1e}".partition("e")[2])
    written = [f"{round(number, decimals):.{max(decimals, 0)}f}" for number in (value, expanded)]
    return " ± ".join(written).replace("-", "−")


def _table(title: str, columns: list[str], rows: list[list[Any]]) -> str:
    if not rows:
        return f"<h2>{escape(title)}</h2><p>Nothing.</p>"
    classes = [" class=n" if column in _NUMBERS else "" for column in columns]
    head = "".join(f"<th{of}>{escape(column)}</th>" for column, of in zip(columns, classes))

    def line(row: list[Any]) -> str:
        return "".join(f"<td{of}>{escape(str(value))}</td>" for value, of in zip(row, classes))

    body = "".join(f"<tr>{line(row)}</tr>" for row in rows)
    return f"<h2>{escape(title)}</h2><div><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
