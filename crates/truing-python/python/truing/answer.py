"""Answers on case folders: attributes, the JSON and the text of the command line, a table for notebooks."""

from __future__ import annotations

import json
from collections.abc import Iterable
from html import escape
from typing import Any

#: Coverage factor of the expanded uncertainty shown.
_K = 2.0


class Record(dict[str, Any]):
    """A JSON object whose keys are attributes too.

    >>> Record(rms=0.5).rms
    0.5
    """

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self)
            raise AttributeError(f"no {name!r} here; there are {known}") from None

    def __dir__(self) -> Iterable[str]:
        return [*super().__dir__(), *self]


class Answer(Record):
    """What a command answers: the keys of its JSON are attributes; ``str()`` is its text."""

    def __init__(self, raw: tuple[str, str, list[str], list[str]]) -> None:
        """Reads what the native half answers."""
        self_json, text, notes, warnings = raw
        super().__init__(json.loads(self_json, object_hook=Record))
        self.__dict__.update(_json=self_json, _text=text, notes=notes, warnings=warnings)

    #: How files were understood that are not written as the format says.
    notes: list[str]
    #: What the user should read.
    warnings: list[str]

    def to_json(self) -> str:
        """The JSON that the command line prints."""
        return f"{self.__dict__['_json']}\n"

    def to_dict(self) -> dict[str, Any]:
        """The same as plain dictionaries and lists."""
        plain: dict[str, Any] = json.loads(self.__dict__["_json"])
        return plain

    def __str__(self) -> str:
        """The text that the command line prints."""
        return str(self.__dict__["_text"])

    def __repr__(self) -> str:
        return f"<truing.{type(self).__name__} of kind {self.get('kind')}>"

    def _rows(self) -> list[tuple[str, ...]]:
        return []

    def _repr_html_(self) -> str:
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in self._rows()
        )
        said = "".join(f"<li>{escape(warning)}</li>" for warning in self.warnings)
        title = f"<b>{escape(self._title())}</b>"
        notes = f"<ul>{said}</ul>" if said else ""
        return f"<div>{title}<table>{rows}</table>{notes}</div>"

    def _title(self) -> str:
        return f"{self['kind']}: {type(self).__name__.lower()}"


class Solved(Answer):
    """Answer of :func:`truing.solve`."""

    def _rows(self) -> list[tuple[str, ...]]:
        residual = self["residual"]
        return [
            ("residual, rms", _number(residual["rms"]), residual["unit"]),
            ("residual, largest", _number(residual["max_abs"]), residual["unit"]),
            ("χ² per degree of freedom", _number(residual["chi2_per_dof"]), ""),
        ]


class Closed(Answer):
    """Answer of :func:`truing.loop`."""

    def _title(self) -> str:
        return f"{self['kind']}: {self['verdict']}"

    def _rows(self) -> list[tuple[str, ...]]:
        unit = self["before"]["unit"]
        error: list[tuple[str, ...]] = [
            (f"error on unseen data, {which}", _number(self[which]["held_out_rms"]), unit)
            for which in ("before", "after")
        ]
        found: list[tuple[str, ...]] = [
            (f"{step['effect']}: {size['name']}", _with_uncertainty(size), size["unit"])
            for step in self["steps"]
            for size in step["parameters"]
        ]
        return error + found


class ClosedMachine(Closed):
    """Answer of :func:`truing.machine`."""


class Depth(Answer):
    """Answer of :func:`truing.depth`."""

    def _title(self) -> str:
        within = self["within"]
        return "depth" if within is None else f"depth: {within['decision']}"

    def _rows(self) -> list[tuple[str, ...]]:
        ranges = [("as written", self["as_written"]), ("as corrected", self["corrected"])]
        return [
            (f"{which}, {end}", _number(depths[f"{end}_mm"]), "mm")
            for which, depths in ranges
            if depths is not None
            for end in ("least", "mean", "largest")
        ]


class Checked(Answer):
    """Answer of :func:`truing.check`."""

    def _rows(self) -> list[tuple[str, ...]]:
        return [(name, str(count)) for name, count in self["counts"].items()]


class Planned(Answer):
    """Answer of :func:`truing.plan`."""

    def _title(self) -> str:
        return f"{self['kind']}: {self['planned']} to be measured for {self['aim']}"

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (f"{figure['of']}, {figure['measure']}", _number(figure["before"]), _number(figure["after"]), figure["unit"])
            for figure in self["figures"]
        ]


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _with_uncertainty(size: dict[str, Any]) -> str:
    return f"{size['value']:.4g} ± {_K * size['std']:.2g}"
