"""Save checkpoints of runs beside the result folder.

`tailslap run --resume` continues from them. A command may make several runs, that of the plate and those that estimate
its error; they come in the same order each time, and are distinguished by their number. A file is named after a digest
of scene, program and libraries, so that those of other commands are neither read nor touched; with it the result is
that of an uninterrupted run, bit for bit.

A file has a digest of the rest, the number of rows, and the arrays one after the other, all of numbers in double
precision. Names and shapes are not stored: they are those of the run after this number of rows.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextvars import ContextVar
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from tailslap import errors
from tailslap.storage import folder, manifest

if TYPE_CHECKING:
    from fem.run.observers import Checkpoint
    from fem.run.runner import Arrays, Sizes

SAVE_S, MAX_SHARE = 10.0, 0.02
"""Seconds between checkpoints, and the fraction of a run's time that they may take."""

DIGEST, COUNT, NUMBER = hashlib.sha256().digest_size, 8, np.dtype(np.float64).itemsize
"""Bytes of the digest, of the number of rows, and of each number of an array."""

MAX_STEM = 40
"""Characters of the place's name in those of checkpoints."""

_current: ContextVar[Checkpoints | None] = ContextVar("checkpoints", default=None)


class Checkpoints:
    """Checkpoints of one command.

    resume: True if those of an earlier command count. promised: True if the run can continue from one.
    """

    def __init__(self, place: Path, definition: Mapping[str, object], resume: bool) -> None:
        place, self._resume, self.promised = folder.resolved(place), resume, False
        self._digest = _digest({**definition, "place": place.name})
        self._all = place.with_name(f".{place.name[:MAX_STEM]}.checkpoint-")
        self._own = Path(f"{self._all}{self._digest[:16]}-")
        self._runs, self._path, self._due = 0, Path(), 0.0

    def next(self) -> Checkpoints:
        """Return the checkpoints of the next run."""
        self._runs += 1
        self._path = Path(f"{self._own}{self._runs}")
        self._due = time.monotonic() + SAVE_S
        return self

    def files(self, same_definition: bool) -> list[Path]:
        """List checkpoints for this place, of this definition or another one."""
        folder = self._all.parent
        names = os.listdir(folder) if errors.is_there(folder) else []
        names = [name for name in names if name.startswith(self._all.name)]
        return [folder / name for name in names if name.startswith(self._own.name) == same_definition]

    def load(self, sizes: Callable[[int], Sizes]) -> Arrays | None:
        """Read the arrays of the file, None without intact ones.

        sizes: shapes of the arrays after a number of rows.
        """
        if not (self._resume and errors.is_there(self._path)):
            return None
        try:
            arrays = self._read(sizes)
        except OSError as error:
            raise OSError(
                error.errno, f"the checkpoint cannot be read: {error.strerror}", str(self._path)
            ) from None
        except ValueError:
            _report(f"the checkpoint {self._path} is damaged")
            return None
        self.promised = True
        return arrays

    def _read(self, sizes: Callable[[int], Sizes]) -> Arrays:
        """Read the arrays of the file. Raises ValueError for a damaged one."""
        with open(self._path, "rb", opener=manifest.open_plain) as file:
            digest, rows = file.read(DIGEST), int.from_bytes(file.read(COUNT), "little")
            shapes = sizes(rows)
            size = DIGEST + COUNT + NUMBER * sum(map(math.prod, shapes.values()))
            if os.fstat(file.fileno()).st_size != size:
                raise ValueError("the sizes differ")
            arrays = {name: np.empty(shape) for name, shape in sorted(shapes.items())}
            for array in arrays.values():
                file.readinto(array.data)
        if self._sealed(arrays) != digest:
            raise ValueError("the digests differ")
        return arrays

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Write the file if the last one is old enough."""
        began = time.monotonic()
        if began < self._due:
            return
        self._path.parent.mkdir(parents=True, exist_ok=True)
        state = {name: np.ascontiguousarray(array, np.float64) for name, array in sorted(arrays().items())}
        with manifest.whole_file(self._path) as partial, partial.open("wb") as file:
            file.write(self._sealed(state) + len(state["rows"]).to_bytes(COUNT, "little"))
            for array in state.values():
                file.write(array.data)
        self.promised, spent = True, time.monotonic() - began
        self._due = time.monotonic() + max(SAVE_S, spent / MAX_SHARE)

    def _sealed(self, arrays: Arrays) -> bytes:
        """Return the digest of definition, run number, names, shapes and numbers."""
        head = [self._digest, self._runs, [(name, array.shape) for name, array in arrays.items()]]
        digest = hashlib.sha256(json.dumps(head).encode())
        for array in arrays.values():
            digest.update(array.data)
        return digest.digest()


@contextlib.contextmanager
def checkpointed(place: Path, definition: Mapping[str, object], resume: bool) -> Iterator[None]:
    """Save checkpoints of runs in this block.

    They are beside `place`, and removed when the block ends without an error.
    """
    checkpoints = Checkpoints(place, definition, resume)
    if resume and not checkpoints.files(same_definition=True):
        foreign = ", ".join(sorted(path.name for path in checkpoints.files(same_definition=False)))
        stay = f"; checkpoints of other scenes or versions are kept: {foreign}" if foreign else ""
        _report(f"this run has no checkpoint{stay}")
    token = _current.set(checkpoints)
    try:
        yield
    except KeyboardInterrupt:
        if checkpoints.promised:
            message = "interrupted; the same command with --resume continues from the checkpoint"
            raise errors.Interrupted(message) from None
        raise
    finally:
        _current.reset(token)
    with contextlib.suppress(OSError):  # the result is complete without that
        for path in checkpoints.files(same_definition=True):
            path.unlink()


def next_checkpoint() -> Checkpoint | None:
    """Return the checkpoints of the next run, None outside `checkpointed`."""
    checkpoints = _current.get()
    return checkpoints.next() if checkpoints else None


def _report(why: str) -> None:
    """Print why a run starts from the beginning."""
    click.echo(f"tailslap: {errors.escaped(why)}; the run starts from the beginning", err=True)


def _digest(definition: Mapping[str, object]) -> str:
    """Return the digest of a definition, the libraries and the compiled code."""
    from fem.registry import digest_of_laws
    from machine_code.system.folder import own_sources

    programs = {name: version(name) for name in ("numpy", "llvmlite", "scipy", "scikit-fem")}
    all_of_it = {**definition, **programs, "fem": own_sources("machine_code", "fem") + digest_of_laws()}
    return hashlib.sha256(json.dumps(all_of_it, sort_keys=True, default=str).encode()).hexdigest()
