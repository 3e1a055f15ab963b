"""Checkpoints of the runs of a command, in files beside its result folder: `tailslap run --resume` goes on from them.

A command may make several runs, the plate's own and others by which it is judged; they come in the same order each
time, and are told apart by their number. A file is named after a digest of scene, program and libraries, so that those
of others are neither read nor touched; with it the result is that of a run that was left alone, bit for bit.

A file has a digest of the rest, the number of rows, and the arrays, all of numbers in double precision, one behind the
other: names and shapes are those that the run has after so many rows, and nothing in the file says otherwise.
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
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from tailslap import errors
from tailslap.files import folder, manifest

if TYPE_CHECKING:
    from fem.run.resume import Checkpoint
    from fem.run.runner import Arrays, Sizes

SAVE_S, MAX_SHARE = 10.0, 0.02
"""Seconds between checkpoints, and the fraction of a run's time that they may take."""

DIGEST, COUNT, NUMBER = hashlib.sha256().digest_size, 8, np.dtype(np.float64).itemsize
"""Bytes of the digest, of the number of rows, and of each number of an array."""

MAX_STEM = 40
"""Characters of the place's name in those of checkpoints, beside which there is room for others."""

_current: ContextVar[Checkpoints | None] = ContextVar("checkpoints", default=None)


class Checkpoints:
    """Checkpoints of one command; resume: True if those that an earlier command left count.

    promised: True if there is one from which the run can go on.
    """

    def __init__(self, place: Path, definition: Mapping[str, Any], resume: bool) -> None:
        place, self._resume, self.promised = folder.resolved(place), resume, False
        self._digest = _digest({**definition, "place": place.name})
        self._all = place.with_name(f".{place.name[:MAX_STEM]}.checkpoint-")
        self._own = Path(f"{self._all}{self._digest[:16]}-")
        self._runs, self._path, self._due = 0, Path(), 0.0

    def next(self) -> Checkpoints:
        """The keeper of the next run."""
        self._runs += 1
        self._path = Path(f"{self._own}{self._runs}")
        self._due = time.monotonic() + SAVE_S
        return self

    def files(self, own: bool) -> list[Path]:
        """List the checkpoints for this place, of this definition or of others."""
        folder = self._all.parent
        names = os.listdir(folder) if errors.is_there(folder) else []
        names = [name for name in names if name.startswith(self._all.name)]
        return [folder / name for name in names if name.startswith(self._own.name) == own]

    def load(self, sizes: Callable[[int], Sizes]) -> Arrays | None:
        """Arrays of the file, if it is whole; sizes: shapes that they have after so many rows."""
        if not (self._resume and errors.is_there(self._path)):
            return None
        try:
            arrays = self._read(sizes)
        except OSError as error:
            raise OSError(
                error.errno, f"the checkpoint cannot be read: {error.strerror}", str(self._path)
            ) from None
        except ValueError:
            _say(f"the checkpoint {self._path} is damaged")
            return None
        self.promised = True
        return arrays

    def _read(self, sizes: Callable[[int], Sizes]) -> Arrays:
        with open(self._path, "rb", opener=manifest.open_plain) as file:
            digest, rows = file.read(DIGEST), int.from_bytes(file.read(COUNT), "little")
            wanted = sizes(rows)
            size = DIGEST + COUNT + NUMBER * sum(map(math.prod, wanted.values()))
            if os.fstat(file.fileno()).st_size != size:
                raise ValueError("the sizes differ")
            arrays = {name: np.empty(shape) for name, shape in sorted(wanted.items())}
            for array in arrays.values():
                file.readinto(array.data)
        if self._sealed(arrays) != digest:
            raise ValueError("the digests differ")
        return arrays

    def save(self, arrays: Callable[[], Arrays]) -> None:
        """Write the file, if the last one is old enough."""
        began = time.monotonic()
        if began < self._due:
            return
        self._path.parent.mkdir(parents=True, exist_ok=True)
        kept = {name: np.ascontiguousarray(array, np.float64) for name, array in sorted(arrays().items())}
        with manifest.whole_file(self._path) as partial, partial.open("wb") as file:
            file.write(self._sealed(kept) + len(kept["rows"]).to_bytes(COUNT, "little"))
            for array in kept.values():
                file.write(array.data)
        self.promised, spent = True, time.monotonic() - began
        self._due = time.monotonic() + max(SAVE_S, spent / MAX_SHARE)

    def _sealed(self, arrays: Arrays) -> bytes:
        """Digest of definition, number of the run, names, shapes and numbers."""
        head = [self._digest, self._runs, [(name, array.shape) for name, array in arrays.items()]]
        digest = hashlib.sha256(json.dumps(head).encode())
        for array in arrays.values():
            digest.update(array.data)
        return digest.digest()


@contextlib.contextmanager
def checkpointed(place: Path, definition: Mapping[str, Any], resume: bool) -> Iterator[None]:
    """Runs made in this block keep checkpoints beside `place`; when it ends well they are removed."""
    checkpoints = Checkpoints(place, definition, resume)
    if resume and not checkpoints.files(own=True):
        others = ", ".join(sorted(path.name for path in checkpoints.files(own=False)))
        stay = f"; checkpoints of other scenes or versions are kept: {others}" if others else ""
        _say(f"this run has no checkpoint{stay}")
    token = _current.set(checkpoints)
    try:
        yield
    except KeyboardInterrupt:
        if checkpoints.promised:
            said = "interrupted; the same command with --resume continues from the checkpoint"
            raise errors.Interrupted(said) from None
        raise
    finally:
        _current.reset(token)
    with contextlib.suppress(OSError):  # the result is complete without that
        for path in checkpoints.files(own=True):
            path.unlink()


def next_checkpoint() -> Checkpoint | None:
    """The keeper of the run that is about to begin; None outside `checkpointed`."""
    checkpoints = _current.get()
    return checkpoints.next() if checkpoints else None


def _say(why: str) -> None:
    click.echo(f"tailslap: {errors.escaped(why)}; the run starts from the beginning", err=True)


def _digest(definition: Mapping[str, Any]) -> str:
    from fem.machine_code.folder import cache_folder

    programs = {name: version(name) for name in ("numpy", "numba", "scipy", "scikit-fem")}
    all_of_it = {**definition, **programs, "fem": cache_folder().name}
    return hashlib.sha256(json.dumps(all_of_it, sort_keys=True, default=str).encode()).hexdigest()
