"""Checkpoints of the runs of a command, in files beside its result folder: `tailslap run --resume` goes on from them.

A command may make several runs, the plate's own and others by which it is judged; they come in the same order each
time, and are told apart by their number. A file counts only for the same scene, program and libraries: then the result
is that of a run that was left alone, bit for bit.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextvars import ContextVar
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

import tailslap
from tailslap.errors import Interrupted
from tailslap.files import manifest
from tailslap.files.folder import resolved

if TYPE_CHECKING:
    from fem.run.observers import Arrays, Checkpoint

SAVE_S, MAX_SHARE = 10.0, 0.02
"""Seconds between checkpoints, and the fraction of a run's time that they may take."""

DEFINITION = "definition"

_current: ContextVar[Checkpoints | None] = ContextVar("checkpoints", default=None)


class Checkpoints:
    """Checkpoints of one command; resume: True if those that an earlier command left count."""

    def __init__(self, place: Path, definition: Mapping[str, Any], resume: bool) -> None:
        self._place, self._definition, self._resume = resolved(place), _digest(definition), resume
        self._runs, self._path, self._due = 0, Path(), 0.0

    def next(self) -> Checkpoints:
        """The keeper of the next run."""
        self._runs += 1
        self._path = self._place.with_name(f".{self._place.name}.checkpoint-{self._runs}.npz")
        self._due = time.monotonic() + SAVE_S
        return self

    @property
    def files(self) -> list[Path]:
        """The checkpoints that there are."""
        prefix = f".{self._place.name}.checkpoint-"
        found = self._place.parent.iterdir() if self._place.parent.is_dir() else ()
        return [path for path in found if path.name.startswith(prefix) and path.suffix == ".npz"]

    def load(self) -> Arrays | None:
        """Arrays of the file, if it is of the same definition."""
        if not self._resume:
            return None
        try:
            with np.load(self._path, allow_pickle=False) as found:
                arrays = dict(found)
        except (OSError, ValueError, EOFError, zipfile.BadZipFile):
            return None
        return arrays if str(arrays.pop(DEFINITION, "")) == self._definition else None

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Write the file, if the last one is old enough."""
        began = time.monotonic()
        if began < self._due:
            return
        self._path.parent.mkdir(parents=True, exist_ok=True)
        named: dict[str, Any] = {DEFINITION: np.array(self._definition), **arrays()}
        with manifest.whole_file(self._path) as partial, partial.open("wb") as file:
            np.savez(file, **named)
        spent = time.monotonic() - began
        self._due = time.monotonic() + max(SAVE_S, spent / MAX_SHARE)


@contextlib.contextmanager
def checkpointed(place: Path, definition: Mapping[str, Any], resume: bool) -> Iterator[None]:
    """Runs made in this block keep checkpoints beside `place`; when it ends well they are removed."""
    checkpoints = Checkpoints(place, definition, resume)
    if resume and not checkpoints.files:
        click.echo("tailslap: there is no checkpoint; the run begins at the beginning", err=True)
    token = _current.set(checkpoints)
    try:
        yield
    except KeyboardInterrupt:
        if checkpoints.files:
            said = "interrupted; the same command with --resume goes on from its checkpoint"
            raise Interrupted(said) from None
        raise
    finally:
        _current.reset(token)
    for path in checkpoints.files:
        path.unlink(missing_ok=True)


def next_checkpoint() -> Checkpoint | None:
    """The keeper of the run that is about to begin; None outside `checkpointed`."""
    checkpoints = _current.get()
    return checkpoints.next() if checkpoints else None


def _digest(definition: Mapping[str, Any]) -> str:
    from fem.machine_code.folder import cache_folder

    programs = {name: version(name) for name in ("numpy", "numba", "scipy", "scikit-fem")}
    all_of_it = {**definition, **programs, "tailslap": tailslap.__version__, "fem": cache_folder().name}
    return hashlib.sha256(json.dumps(all_of_it, sort_keys=True, default=str).encode()).hexdigest()
