"""What a worker does: computes a batch of runs, each into a line of the journal."""

from __future__ import annotations

import contextlib
import importlib
import io
import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import tailslap
from tailslap.sweep.row import compute_row


class Task(NamedTuple):
    """A run by its number, and its changes of the scene."""

    run: int
    changes: tuple[str, ...]


class Finished(NamedTuple):
    """A run that is done: number, status, seconds that it took, and its row as a line of JSON."""

    run: int
    status: str
    seconds: float
    line: bytes


class OtherVersionError(Exception):
    """The worker has another version of this program than the one that sent the batch."""


def run_batch(version: str, text: str, tasks: Sequence[Task]) -> list[Finished]:
    """Compute runs of the scene's text, one after the other; version: the sender's, of this program."""
    if version != tailslap.__version__:
        raise OtherVersionError(tailslap.__version__)
    with contextlib.redirect_stderr(io.StringIO()):  # the progress of single runs is not for the terminal
        return [finished(compute_row(task.run, text, task.changes)) for task in tasks]


def finished(row: dict[str, Any]) -> Finished:
    """The row as it goes into the journal. Numbers that are not finite keep their names, NaN and Infinity."""
    line = json.dumps(row, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"
    return Finished(row["run"], row["status"], row.get("cost.run_s", 0.0), line)


def make_ready() -> str:
    """Import what runs need, once a worker; returns the version of this program."""
    for module in ("fem.explicit.simulate", "tailslap.planning.fe_plan", "tailslap.run"):
        importlib.import_module(module)
    return tailslap.__version__
