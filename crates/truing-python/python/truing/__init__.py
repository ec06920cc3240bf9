"""Locate, calibrate and correct precision machine tools from measured data, and find what a model is missing.

Case folders go through :func:`solve`, :func:`loop` and :func:`check`, with the answers of the command line; arrays go to
:mod:`truing.frame_fit`, :mod:`truing.ft_center`, :mod:`truing.tracker_lm`, :mod:`truing.pose_icp`, :mod:`truing.probe_comp` and
:mod:`truing.force_impedance`; a model of one's own goes to :func:`close_loop`.

Lengths are in mm, forces in N, torques in N·mm, angles in rad, times in s; names say so.

>>> import numpy as np
>>> import truing
>>> corners_mm = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 80.0, 0.0], [0.0, 0.0, 60.0]])
>>> fit = truing.frame_fit.fit(corners_mm, corners_mm + [10.0, -5.0, 2.0], std_mm=0.01)
>>> fit.translation_mm.round(9).tolist()
[10.0, -5.0, 2.0]
"""

from __future__ import annotations

from . import force_impedance, frame_fit, ft_center, pose_icp, probe_comp, tracker_lm
from ._truing import Surface, __version__
from .answer import Checked, Closed, ClosedMachine, Depth, Planned, Record, Solved
from .case import Case, check, depth, init, kinds, loop, machine, plan, solve
from .errors import InputError, NotDeterminedError, TruingError
from .own_model import Closure, Effect, Model, Parameter, close_loop

__all__ = [
    "Case",
    "Checked",
    "Closed",
    "ClosedMachine",
    "Closure",
    "Depth",
    "Effect",
    "InputError",
    "Model",
    "NotDeterminedError",
    "Parameter",
    "Planned",
    "Record",
    "Solved",
    "Surface",
    "TruingError",
    "__version__",
    "check",
    "close_loop",
    "depth",
    "force_impedance",
    "frame_fit",
    "ft_center",
    "init",
    "kinds",
    "loop",
    "machine",
    "plan",
    "pose_icp",
    "probe_comp",
    "solve",
    "tracker_lm",
]
