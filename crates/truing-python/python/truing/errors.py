"""What is wrong, where, and what the data leave free."""

from __future__ import annotations


class TruingError(Exception):
    """Why there is no answer. The text is that of the command line."""

    #: File that is to blame, where there is one.
    file: str | None = None
    #: Line in it, from 1.
    line: int | None = None
    #: Column in it, from 1.
    column: int | None = None
    #: Name of the column or key.
    name: str | None = None
    #: Position in the arrays given, from 0, where they are to blame.
    index: int | None = None
    #: What the data do not determine, where that is known.
    free_direction: str | None = None


class InputError(TruingError, ValueError):
    """The input cannot be used; exit code 2 of the command line.

    >>> import truing
    >>> try:
    ...     truing.solve("no-such-folder")
    ... except truing.InputError as error:
    ...     print(error.file)
    no-such-folder
    """


class NotDeterminedError(TruingError, ArithmeticError):
    """The input is usable in form but leaves something free; exit code 3 of the command line.

    >>> import truing
    >>> on_a_line = [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [100.0, 0.0, 0.0]]
    >>> try:
    ...     truing.frame_fit.fit(on_a_line, on_a_line, std_mm=0.01)
    ... except truing.NotDeterminedError as error:
    ...     print(error.free_direction)
    the rotation about the line (1.000, 0.000, 0.000) of the points
    """
