"""The loop on a model of one's own.

>>> import numpy as np
>>> class Scale(Model):
...     '''A scale read at known lengths; the declared model has a zero error and nothing else.'''
...     def __init__(self, length_mm, read_mm):
...         self.length_mm, self.read_mm = length_mm, read_mm
...         self.unit = "mm"
...         self.observations = [f"{length} mm" for length in length_mm]
...         self.base = [Parameter("zero", "mm")]
...         self.effects = [
...             Effect("scale", "the scale's divisions are too long", [Parameter("scale", "ppm", 1e6)])
...         ]
...     def residuals(self, base, amplitudes):
...         [zero], [[scale]] = base, amplitudes
...         return self.read_mm - zero - self.length_mm * (1.0 + scale)
>>> length_mm = 50.0 * np.arange(12)
>>> noise_mm = 1e-4 * np.array([3, -5, 1, 4, -2, 0, -4, 5, 2, -1, -3, 1])
>>> closure = close_loop(Scale(length_mm, 0.005 + length_mm * 1.00002 + noise_mm))
>>> closure.verdict, closure.steps[0].effect, round(closure.steps[0].parameters[0].value)
('explained', 'scale', 20)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _truing
from .answer import Record
from .arrays import column, floats
from .errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """One number of a model; reported value = value in the model × ``factor``."""

    name: str
    unit: str
    factor: float = 1.0


@dataclass(frozen=True)
class Effect:
    """An effect that the declared model lacks; its amplitudes are zero where it is absent."""

    #: Short name.
    id: str
    #: One sentence for people.
    description: str
    #: Its amplitudes.
    parameters: Sequence[Parameter]
    #: The one thing it is about, where there is one candidate per thing.
    subject: str | None = None
    #: The covariate that drives it.
    driver: str | None = None
    #: Whether some designs show nothing of it; otherwise an amplitude that moves nothing is an error.
    some_designs: bool = False


class Model(ABC):
    """A declared model with its data, and the effects that it leaves out.

    Derivatives are taken by differences, so that ``residuals`` must be smooth, and the same whenever it is called.
    """

    #: Unit of the residuals.
    unit: str
    #: One name for each observation, in the order measured.
    observations: Sequence[str]
    #: Parameters of the declared model.
    base: Sequence[Parameter]
    #: What may be missing.
    effects: Sequence[Effect] = ()
    #: Where the fit starts; zero unless given.
    start: Sequence[float] | None = None
    #: Residuals an observation: 3 for x, y, z.
    components: int = 1
    #: Standard uncertainty of a residual, one for all or one each; ``None``: estimated from the residual.
    std: ArrayLike | None = None
    #: What is left out together, a name for each observation; each its own unless given.
    groups: Sequence[str] | None = None
    #: Groups that are never fitted, only judged.
    check: Sequence[str] = ()

    @abstractmethod
    def residuals(self, base: Floats, amplitudes: Sequence[Floats]) -> ArrayLike:
        """Observed − predicted: ``components`` numbers for each observation, one observation after the other.

        ``amplitudes`` has one array for each effect.
        """


class Closure(Record):
    """What the loop found; keys are attributes: ``verdict``, ``before``, ``after``, ``steps``, ``remaining``, …"""

    def _repr_html_(self) -> str:
        unit = self["before"]["unit"]
        rows = [
            f"<tr><td>error on unseen data, {which}</td><td>{self[which]['held_out_rms']:.4g} {escape(unit)}</td></tr>"
            for which in ("before", "after")
        ]
        rows += [
            f"<tr><td>{escape(step['effect'])}: {escape(size['name'])}</td>"
            f"<td>{size['value']:.4g} ± {2.0 * size['std']:.2g} {escape(size['unit'])}</td></tr>"
            for step in self["steps"]
            for size in step["parameters"]
        ]
        return f"<div><b>{escape(self['verdict'])}</b><table>{''.join(rows)}</table></div>"


def close_loop(
    model: Model,
    covariates: Mapping[str, ArrayLike] | None = None,
    *,
    alpha: float = 0.05,
    max_steps: int = 6,
    nested: bool = True,
) -> Closure:
    """Fits a model, finds what it is missing, and judges the error before and after on unseen data.

    ``covariates`` are quantities recorded beside the observations, one number each. ``alpha`` is the probability of
    adding anything where nothing is missing; without ``nested`` the choice of effects is not repeated without each
    group.
    """
    observations = [str(name) for name in model.observations]
    groups = observations if model.groups is None else [str(name) for name in model.groups]
    if len(groups) != len(observations):
        raise InputError(f"groups must name one for each of {len(observations)} observations")
    if model.components < 1:
        raise InputError(f"components must be 1 or more, got {model.components}")

    def residuals(base: Floats, amplitudes: list[Floats]) -> Floats:
        return column(np.ravel(floats(model.residuals(base, amplitudes))))

    start = [0.0] * len(model.base) if model.start is None else [float(v) for v in model.start]
    found = _truing.close_own_loop(
        residuals,
        (model.unit, model.components, groups, [str(name) for name in model.check]),
        None if model.std is None else floats(model.std),
        [_parameter(p) for p in model.base],
        start,
        [
            (e.id, e.subject, e.description, e.driver, e.some_designs, [_parameter(p) for p in e.parameters])
            for e in model.effects
        ],
        [(name, column(values).tolist()) for name, values in (covariates or {}).items()],
        (alpha, max_steps, nested),
    )
    return Closure({key: _record(value) for key, value in found.items()})


def _parameter(parameter: Parameter) -> tuple[str, str, float]:
    return parameter.name, parameter.unit, parameter.factor


def _record(value: Any) -> Any:
    if isinstance(value, dict):
        return Record({key: _record(inner) for key, inner in value.items()})
    if isinstance(value, list):
        return [_record(inner) for inner in value]
    return value
