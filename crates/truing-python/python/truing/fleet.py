"""Many case folders at once: one row a case, as Parquet, on one process or on a cluster of Dask.

Needs pyarrow; with a cluster Dask as well (``pip install 'truing[fleet]'``), and fsspec for cases in object storage.

A row is stored under a key made of the program's version, the command, and the SHA-256 of every file of the case: a run that was broken
off goes on where it stood, and a case that did not change is not computed again. Every file is written beside its place and then renamed.
A case that cannot be answered is a row with its message. :func:`page` shows all rows at a glance.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from . import _truing
from .case import loop, solve
from .errors import NotDeterminedError, TruingError
from .fleet_page import page

__all__ = ["TABLE", "Verb", "content_key", "page", "row", "run"]

Verb = Literal["loop", "solve"]

#: What a table of rows is called.
TABLE = "fleet.parquet"


def run(
    cases: Iterable[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    verb: Verb = "loop",
    client: Any = None,
    retries: int = 3,
) -> Path:
    """Answers every case and writes ``out/fleet.parquet``, one row a case, sorted by its name; the path of that file.

    ``cases`` are folders, or addresses that fsspec knows (``s3://…``). ``client`` is a ``dask.distributed.Client`` whose
    workers see ``out``; without one this process does the work. A worker that dies takes no case with it: its cases go to
    others, ``retries`` times each.
    """
    names = sorted({os.fspath(case) for case in cases})
    out = Path(out).absolute()
    rows = out / "rows"
    rows.mkdir(parents=True, exist_ok=True)
    store = os.fspath(rows)
    if client is None:
        found = {name: row(name, store, verb) for name in names}
    else:
        found = _on_cluster(client, names, store, verb, retries)
    return _written(out, [found[name] for name in names])


def row(case: str, store: str, verb: Verb) -> dict[str, Any]:
    """The row of one case: the one in ``store``, or a new one that is put there."""
    try:
        with _local(case) as folder:
            key = content_key(folder, verb)
            kept = Path(store) / f"{key}.json"
            if kept.is_file():
                found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
            else:
                found = _answer(folder, verb)
                _replace(kept, json.dumps(found).encode())
    except OSError as error:
        key, found = "", _empty("unreadable", f"{type(error).__name__}: {error}")
    # A copy of a case has the key of its original, and a name of its own.
    return {"case": case, "key": key, "verb": verb, "version": _truing.__version__, **found}


def content_key(folder: str | os.PathLike[str], verb: Verb) -> str:
    """SHA-256 of program, command, and of the name and SHA-256 of every file of a case."""
    root = Path(folder)
    if not root.is_dir():
        raise NotADirectoryError(os.fspath(root))
    digest = hashlib.sha256(f"truing {_truing.__version__} {verb}\n".encode())
    for path in sorted(p for p in root.rglob("*") if p.is_file()):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{content}  {path.relative_to(root).as_posix()}\n".encode())
    return digest.hexdigest()


def _answer(folder: str, verb: Verb) -> dict[str, Any]:
    try:
        answer = (loop if verb == "loop" else solve)(folder, timing=False).to_dict()
    except TruingError as error:
        status = "not-determined" if isinstance(error, NotDeterminedError) else "unusable"
        # Where a case lies is no part of what is wrong with it.
        message = str(error).replace(folder, "").lstrip("/\\")
        return {**_empty(status, message), "line": error.line, "free_direction": error.free_direction}
    steps = answer.get("steps", [])
    return {
        **_empty("answered", ""),
        "kind": answer["kind"],
        "verdict": answer.get("verdict"),
        "effects": [step["effect"] for step in steps],
        "sizes": [
            {"effect": step["effect"], **{key: size[key] for key in ("name", "value", "unit", "std")}}
            for step in steps
            for size in step["parameters"]
        ],
        "unit": answer["residual"]["unit"],
        "rms": answer["residual"]["rms"],
        "chi2_per_dof": answer["residual"]["chi2_per_dof"],
        "before_held_out_rms": answer.get("before", {}).get("held_out_rms"),
        "after_held_out_rms": answer.get("after", {}).get("held_out_rms"),
        "warnings": answer["warnings"],
        "answer": json.dumps(answer),
    }


def _empty(status: str, message: str) -> dict[str, Any]:
    return {
        "status": status,
        "message": message,
        "line": None,
        "free_direction": None,
        "kind": None,
        "verdict": None,
        "effects": [],
        "sizes": [],
        "unit": None,
        "rms": None,
        "chi2_per_dof": None,
        "before_held_out_rms": None,
        "after_held_out_rms": None,
        "warnings": [],
        "answer": None,
    }


def _on_cluster(client: Any, names: list[str], store: str, verb: Verb, retries: int) -> dict[str, Any]:
    from dask.distributed import KilledWorker, as_completed

    found: dict[str, Any] = {}
    waiting = names
    for again in range(retries + 1):
        futures = {client.submit(row, name, store, verb, retries=retries, pure=False): name for name in waiting}
        waiting = []
        # With results: asked for later, one may be gone with its worker, and nobody would go on meanwhile.
        for future, result in as_completed(  # type: ignore[no-untyped-call,unused-ignore]
            list(futures), with_results=True, raise_errors=False
        ):
            name = futures[future]
            if future.status == "finished":
                found[name] = result
                continue
            error = future.exception()
            if isinstance(error, KilledWorker) and again < retries:
                # Several workers died while it waited there: that says nothing of the case.
                waiting.append(name)
            else:
                said = _empty("failed", f"{type(error).__name__}: {error}")
                found[name] = {"case": name, "key": "", "verb": verb, "version": _truing.__version__, **said}
        if not waiting:
            break
    return found


@contextmanager
def _local(case: str) -> Iterator[str]:
    """The folder of a case; one in object storage is fetched for as long as it is needed."""
    if "://" not in case:
        yield case
        return
    import fsspec

    with tempfile.TemporaryDirectory(prefix="truing-") as folder:
        files, address = fsspec.core.url_to_fs(case)
        files.get(address.rstrip("/") + "/", folder + "/", recursive=True)
        yield folder


def _written(out: Path, rows: list[dict[str, Any]]) -> Path:
    import pyarrow
    from pyarrow import parquet

    text, number = pyarrow.string(), pyarrow.float64()
    size = pyarrow.struct([("effect", text), ("name", text), ("value", number), ("unit", text), ("std", number)])
    schema = pyarrow.schema(
        [(name, text) for name in ("case", "key", "verb", "version", "status", "message")]
        + [("line", pyarrow.int64())]
        + [(name, text) for name in ("free_direction", "kind", "verdict")]
        + [("effects", pyarrow.list_(text)), ("sizes", pyarrow.list_(size)), ("unit", text)]
        + [(name, number) for name in ("rms", "chi2_per_dof", "before_held_out_rms", "after_held_out_rms")]
        + [("warnings", pyarrow.list_(text)), ("answer", text)]
    )
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.Table.from_pylist(rows, schema=schema), sink)
    path = out / TABLE
    _replace(path, sink.getvalue().to_pybytes())
    return path


def _replace(path: Path, content: bytes) -> None:
    """Writes beside the place and renames: whoever reads sees the whole file or none."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise
