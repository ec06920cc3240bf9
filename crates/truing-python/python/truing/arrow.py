"""Tables of other libraries, read through the Arrow C stream interface.

pandas, polars, pyarrow, DuckDB and others hand over a table as a capsule (``__arrow_c_stream__``); nothing of theirs is
imported here. Structures and formats are those of the Arrow specification, «The Arrow C data interface» and «The Arrow C
stream interface».
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol, Union, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from .errors import InputError

#: Numbers of a column, or its texts; what is missing is NaN, or an empty text.
Column = Union[NDArray[Any], list[str]]


@runtime_checkable
class ArrowStream(Protocol):
    """A table that can be handed over."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """A capsule named ``arrow_array_stream``."""


class _Schema(ctypes.Structure):
    pass


class _Array(ctypes.Structure):
    pass


class _Stream(ctypes.Structure):
    pass


_Schema._fields_ = [
    ("format", ctypes.c_char_p),
    ("name", ctypes.c_char_p),
    ("metadata", ctypes.c_char_p),
    ("flags", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("children", ctypes.POINTER(ctypes.POINTER(_Schema))),
    ("dictionary", ctypes.POINTER(_Schema)),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(_Schema))),
    ("private_data", ctypes.c_void_p),
]
_Array._fields_ = [
    ("length", ctypes.c_int64),
    ("null_count", ctypes.c_int64),
    ("offset", ctypes.c_int64),
    ("n_buffers", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("buffers", ctypes.POINTER(ctypes.c_void_p)),
    ("children", ctypes.POINTER(ctypes.POINTER(_Array))),
    ("dictionary", ctypes.POINTER(_Array)),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(_Array))),
    ("private_data", ctypes.c_void_p),
]
_Stream._fields_ = [
    ("get_schema", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(_Stream), ctypes.POINTER(_Schema))),
    ("get_next", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(_Stream), ctypes.POINTER(_Array))),
    ("get_last_error", ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.POINTER(_Stream))),
    ("release", ctypes.CFUNCTYPE(None, ctypes.POINTER(_Stream))),
    ("private_data", ctypes.c_void_p),
]

#: Formats of numbers, and what NumPy calls them.
_NUMBERS = {
    "c": "i1",
    "C": "u1",
    "s": "i2",
    "S": "u2",
    "i": "i4",
    "I": "u4",
    "l": "i8",
    "L": "u8",
    "e": "f2",
    "f": "f4",
    "g": "f8",
}
#: Formats of texts with offsets, and the type of the offsets.
_TEXTS = {"u": "i4", "U": "i8"}
#: Texts by view: 16 bytes each, inline up to 12.
_TEXT_VIEW = "vu"
_VIEW_BYTES = 16
_INLINE_BYTES = 12


def read(table: ArrowStream) -> dict[str, Column]:
    """Columns of a table by name, in its order.

    Numbers become arrays, whole numbers stay whole where none is missing; texts and categories become lists of text.
    """
    with _released(_stream(table)) as (capsule, stream):
        schema = _Schema()
        _ask(stream, stream.contents.get_schema(stream, ctypes.byref(schema)))
        try:
            if schema.format != b"+s":
                raise InputError("a table of columns is needed, not a single column")
            fields = [schema.children[k].contents for k in range(schema.n_children)]
            names = [(field.name or b"").decode() for field in fields]
            twice = {name for name in names if names.count(name) > 1}
            if twice:
                raise InputError(f"the table has two columns named {sorted(twice)[0]!r}")
            pieces: list[list[Column]] = [[] for _ in fields]
            for batch in _batches(stream):
                for k, field in enumerate(fields):
                    # The children of a struct begin where the struct does.
                    pieces[k].append(
                        _column(names[k], field, batch.children[k].contents, batch.offset, batch.length)
                    )
        finally:
            schema.release(ctypes.byref(schema))
        del capsule
    return {name: _joined(parts) for name, parts in zip(names, pieces)}


def _stream(table: ArrowStream) -> tuple[object, Any]:
    capsule = table.__arrow_c_stream__()
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    return capsule, ctypes.cast(pointer(capsule, b"arrow_array_stream"), ctypes.POINTER(_Stream))


@contextmanager
def _released(of: tuple[object, Any]) -> Iterator[tuple[object, Any]]:
    """The stream, given back whatever happens; the capsule then has nothing left to give back."""
    _, stream = of
    try:
        yield of
    finally:
        if stream.contents.release:
            stream.contents.release(stream)


def _batches(stream: Any) -> Iterator[Any]:
    while True:
        batch = _Array()
        _ask(stream, stream.contents.get_next(stream, ctypes.byref(batch)))
        if not batch.release:
            return
        try:
            yield batch
        finally:
            batch.release(ctypes.byref(batch))


def _ask(stream: Any, code: int) -> None:
    if code != 0:
        said = stream.contents.get_last_error(stream)
        raise InputError(f"the table cannot be read: {(said or b'no reason given').decode(errors='replace')}")


def _column(name: str, field: Any, array: Any, first: int, length: int) -> Column:
    # Rows of this batch start after its own offset and that of the column.
    start = first + array.offset
    layout = field.format.decode()
    missing = _missing(array, start, length)
    if field.dictionary:
        return _categories(name, field, array, start, length, missing)
    if layout in _NUMBERS:
        numbers = _buffer(array, 1, _NUMBERS[layout], start, length).copy()
        if missing is not None:
            numbers = numbers.astype(np.float64)
            numbers[missing] = np.nan
        return numbers
    if layout == "b":
        return _bits(array, 1, start, length)
    if layout in _TEXTS:
        return _texts(array, _TEXTS[layout], start, length, missing)
    if layout == _TEXT_VIEW:
        return _text_views(array, start, length, missing)
    raise InputError(f"column {name!r} holds neither numbers nor text (Arrow format {layout!r})")


def _categories(name: str, field: Any, array: Any, start: int, length: int, missing: Any) -> Column:
    of = array.dictionary.contents
    words = _column(name, field.dictionary.contents, of, 0, of.length)
    codes = _buffer(array, 1, _NUMBERS[field.format.decode()], start, length)
    gone = np.zeros(length, dtype=bool) if missing is None else missing
    return [
        "" if is_gone else str(words[code])
        for code, is_gone in zip(codes.tolist(), gone.tolist())
    ]


def _missing(array: Any, start: int, length: int) -> NDArray[np.bool_] | None:
    if array.null_count == 0 or array.n_buffers == 0 or not array.buffers[0]:
        return None
    missing = ~_bits(array, 0, start, length)
    return missing if missing.any() else None


def _bits(array: Any, k: int, start: int, length: int) -> NDArray[np.bool_]:
    packed = _buffer(array, k, "u1", 0, (start + length + 7) // 8)
    return np.unpackbits(packed, bitorder="little")[start : start + length].astype(bool)


def _buffer(array: Any, k: int, kind: str, start: int, length: int) -> NDArray[Any]:
    """Entries of a buffer where they lie; good for as long as the batch is."""
    dtype = np.dtype(kind)
    address = array.buffers[k]
    if not address or length == 0:
        return np.empty(0, dtype=dtype)
    raw = (ctypes.c_char * (length * dtype.itemsize)).from_address(address + start * dtype.itemsize)
    return np.frombuffer(memoryview(raw), dtype=dtype)


def _texts(array: Any, kind: str, start: int, length: int, missing: Any) -> list[str]:
    offsets = _buffer(array, 1, kind, start, length + 1).tolist() if length else [0]
    whole = _buffer(array, 2, "u1", 0, offsets[-1]).tobytes()
    texts = [whole[a:b].decode() for a, b in zip(offsets, offsets[1:])]
    return texts if missing is None else ["" if gone else t for t, gone in zip(texts, missing.tolist())]


def _text_views(array: Any, start: int, length: int, missing: Any) -> list[str]:
    views = _buffer(array, 1, "u1", _VIEW_BYTES * start, _VIEW_BYTES * length).tobytes()
    texts = []
    for k in range(length):
        view = views[_VIEW_BYTES * k : _VIEW_BYTES * (k + 1)]
        size = int.from_bytes(view[:4], "little")
        if missing is not None and missing[k]:
            texts.append("")
        elif size <= _INLINE_BYTES:
            texts.append(view[4 : 4 + size].decode())
        else:
            of, at = int.from_bytes(view[8:12], "little"), int.from_bytes(view[12:16], "little")
            texts.append(_buffer(array, 2 + of, "u1", at, size).tobytes().decode())
    return texts


def _joined(parts: list[Column]) -> Column:
    if not parts:
        return np.empty(0)
    if isinstance(parts[0], list):
        return [text for part in parts for text in part]
    return np.concatenate([np.asarray(part) for part in parts])
