"""What a worker does: computes the parts of a batch, one after the other."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import tailslap
from tailslap.execution.record_file import Key
from tailslap.progress import MODE


class Part(NamedTuple):
    """A call to make, by its key."""

    key: Key
    arguments: tuple[Any, ...]


class Finished(NamedTuple):
    """What became of a batch: records by key up to the first part that raised an error; seconds that a part took."""

    records: dict[Key, Any]
    error: Exception | None
    seconds: float


class OtherVersionError(Exception):
    """The worker has another version of this program than the one that sent the batch."""


def run_batch(version: str, function: Callable[..., Any], parts: Sequence[Part]) -> Finished:
    """Call the function with each part's arguments; version: the sender's, of this program."""
    if version != tailslap.__version__:
        raise OtherVersionError(tailslap.__version__)
    began, records, error = time.perf_counter(), {}, None
    with contextlib.redirect_stderr(io.StringIO()):  # the progress of single runs is not for the terminal
        try:
            for part in parts:
                records[part.key] = function(*part.arguments)
        except Exception as raised:
            error = raised
    return Finished(records, error, (time.perf_counter() - began) / max(1, len(records)))


def make_ready() -> str:
    """Import what runs need, once a worker; returns the version of this program."""
    os.environ[MODE] = "none"
    for module in ("fem.run.corner", "tailslap.planning.fe_plan", "tailslap.scene_run"):
        importlib.import_module(module)
    return tailslap.__version__
