"""One run of a sweep as a row: names of columns and plain values, times among them."""

from __future__ import annotations

import functools
import time
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import tailslap
from fem import kept
from tailslap.case import case_of
from tailslap.case.cost import demand_affordable
from tailslap.errors import InputError
from tailslap.scene.vary import Changes, Source, vary

PASSED, FAILED, REFUSED, ERROR = STATUSES = ("passed", "failed", "refused", "error")
"""All checks passed; a check failed; the theory or the model refuses the combination; the run broke down."""

KILLS = "its worker died each time that it was computed, alone at last"

TIMES = ("cost.run_s", "cost.setup_s", "cost.time_loop_s")
REUSED = "cost.reused"
"""Column with the parts of the model that were there already, from runs that this worker has made before."""

CIRCUMSTANCES = (*TIMES, REUSED)
"""Columns that differ when the same run is made again; all others are the same to the bit."""


def compute_row(run: int, source: Source, changes: Changes) -> dict[str, Any]:
    """Make a run of the scene with these changes. Whatever goes wrong is the row's status and reason."""
    began, before = time.perf_counter(), kept.looks()
    try:
        found = _columns(source, changes)
    except InputError as refusal:
        found = {"status": REFUSED, "reason": str(refusal)}
    except MemoryError:
        found = {"status": ERROR, "reason": "the memory of the machine does not hold this mesh"}
    except Exception as error:  # a sweep goes on, whatever one of its runs does
        found = {"status": ERROR, "reason": f"{type(error).__name__}: {error}"}
    spent = {REUSED: ", ".join(kept.reused(before)), "cost.run_s": time.perf_counter() - began}
    return {"run": run, **found, **versions(), **spent}


def killing_row(run: Any) -> dict[str, Any]:
    """The row of a run that never came back."""
    return {"run": run, "status": ERROR, "reason": KILLS}


def _columns(source: Source, changes: Changes) -> dict[str, Any]:
    """What the calculation that the scene asks for tells of its run."""
    case = case_of(*vary(source, changes))
    demand_affordable(case.scene, case.duration)
    return case.row(case.run() if case.scene.plate else None)


@functools.cache
def versions() -> Mapping[str, str]:
    """Columns with the versions that a row was computed with."""
    libraries = {name: version(name) for name in ("numba", "numpy", "scipy")}
    return {
        f"version.{name}": given for name, given in {"tailslap": tailslap.__version__, **libraries}.items()
    }
