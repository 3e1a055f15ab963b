"""Command lines, tables, times and processes of the benchmarks.

They run the sources of this checkout.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import json
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
TAILSLAP = (sys.executable, "-m", "tailslap")
WIDTHS = 66, 12

sys.path.insert(0, str(ROOT))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@functools.cache
def bytecode_folder() -> tempfile.TemporaryDirectory[str]:
    """Return a new folder for compiled sources, closed to other users.

    Python executes its files. The folder is removed at the end of this process.
    """
    return tempfile.TemporaryDirectory(prefix="tailslap-bytecode-")


def options(description: str | None, *positional: str | tuple[str, Any], **optional: Any) -> Any:
    """Parse the command line of a benchmark, whose help is its docstring.

    positional: name of a required argument, or name and default; with a tuple one of its texts, with an empty list any
    number of arguments, with a mapping its keys, all by default. optional: default by name; False is a flag, a type an
    option without default, an empty list one that is repeated, a tuple one of several values, None one of any number of
    texts, None without the option.
    """
    kind = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=description, formatter_class=kind)
    names: dict[str, Mapping[str, Any]] = {}
    for entry in positional:
        name, default = (entry, ...) if isinstance(entry, str) else entry
        if isinstance(default, Mapping):
            names[name] = default
            parser.add_argument(name, nargs="*", help=", ".join(default))
        elif isinstance(default, list):
            parser.add_argument(name, nargs="*", default=default)
        elif default is ... or isinstance(default, tuple):
            parser.add_argument(name, choices=None if default is ... else default)
        else:
            parser.add_argument(name, nargs="?", **_value(default))
    for name, default in optional.items():
        value: dict[str, Any] = {"action": "append", "default": []} if default == [] else _value(default)
        parser.add_argument(f"--{name.replace('_', '-')}", **value)
    arguments = parser.parse_args()
    for name, allowed in names.items():
        if unknown := {*getattr(arguments, name)} - {*allowed}:
            parser.error(f"{name}: given {', '.join(unknown)}, allowed {', '.join(allowed)}")
        setattr(arguments, name, getattr(arguments, name) or [*allowed])
    return arguments


def _value(default: Any) -> dict[str, Any]:
    """Return the settings of an argument with this default."""
    if default is False:
        return {"action": "store_true"}
    if default is None:
        return {"nargs": "*"}
    if isinstance(default, type):
        return {"type": default}
    if isinstance(default, tuple):
        return {"type": type(default[0]), "nargs": "+", "default": default}
    return {"type": type(default), "default": default}


def row(what: str, required: str, measured: str) -> None:
    """Print a line of a table."""
    print(f"{what:<{WIDTHS[0]}} {required:>{WIDTHS[1]}}  {measured}", flush=True)


def counts(outcomes: Mapping[str, int]) -> str:
    """Return a line for each outcome with its number."""
    return "\n".join(f"{count:6d}  {outcome}" for outcome, count in sorted(outcomes.items()))


def seconds(call: Callable[[], object]) -> float:
    """Return the wall-clock time of a call [s]."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def spread(values: Sequence[float], form: str = ".3g") -> str:
    """Return the median of values with the least and the largest."""
    return f"{statistics.median(values):{form}} ({min(values):{form}} to {max(values):{form}})"


def on_all_cores(function: Callable[..., Any], *arguments: Iterable[Any], chunk: int = 1) -> list[Any]:
    """Return the values of a function, computed on all cores."""
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        return list(pool.map(function, *arguments, chunksize=chunk))


def run_command(*words: object) -> tuple[int, str, str]:
    """Run a command here, and return its status, output and messages."""
    from tailslap.cli import _status

    output, messages = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(messages):
        status = _status([str(word) for word in words])
    return status, output.getvalue(), messages.getvalue()


def sweep_rows(folder: Path) -> list[dict[str, Any]]:
    """Return the rows of a sweep without times."""
    import pyarrow.parquet as parquet

    from tailslap.campaign.sweep_table import CIRCUMSTANCES, TABLE

    table = parquet.read_table(folder / TABLE)
    columns = [name for name in table.column_names if name not in CIRCUMSTANCES]
    return list(table.select(columns).to_pylist())


def read_records(file: Path | None) -> list[dict[str, Any]]:
    """Return the records of a file of JSON lines."""
    return [json.loads(line) for line in file.read_text().splitlines()] if file and file.exists() else []


def add_record(file: Path | None, record: Mapping[str, Any]) -> None:
    """Append a record to a file if there is one."""
    if file:
        with file.open("a") as stream:
            stream.write(json.dumps(record) + "\n")


def corner_case(scene: str, *changes: str) -> Any:
    """Return the case of a scene with changes."""
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.scene.read import read_scene

    return CornerCase(*read_scene(scene, changes))
