"""One run of a sweep as a row: names of columns and plain values, times among them."""

from __future__ import annotations

import functools
import time
from collections.abc import Mapping
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import tailslap
from tailslap.errors import InputError
from tailslap.scene.vary import Changes, Source, vary

if TYPE_CHECKING:
    from tailslap.run import Outcome

PASSED, FAILED, REFUSED, ERROR = STATUSES = ("passed", "failed", "refused", "error")
"""All checks passed; a check failed; the theory or the model refuses the combination; the run broke down."""

KILLS = "its worker died each time that it was computed, alone at last"

TIMES = ("cost.run_s", "cost.setup_s", "cost.time_loop_s")
"""Columns that differ when the same run is made again; all others are the same to the bit."""


def compute_row(run: int, source: Source, changes: Changes) -> dict[str, Any]:
    """Make a run of the scene with these changes. Whatever goes wrong is the row's status and reason."""
    began = time.perf_counter()
    try:
        found = outcome_columns(_outcome(source, changes))
    except InputError as refusal:
        found = {"status": REFUSED, "reason": str(refusal)}
    except MemoryError:
        found = {"status": ERROR, "reason": "the memory of the machine does not hold this mesh"}
    except Exception as error:  # a sweep goes on, whatever one of its runs does
        found = {"status": ERROR, "reason": f"{type(error).__name__}: {error}"}
    return {"run": run, **found, **versions(), "cost.run_s": time.perf_counter() - began}


def killing_row(run: Any) -> dict[str, Any]:
    """The row of a run that never came back."""
    return {"run": run, "status": ERROR, "reason": KILLS}


def _outcome(source: Source, changes: Changes) -> Outcome:
    from tailslap.planning.affordable import demand_affordable
    from tailslap.planning.plan import make_plan
    from tailslap.run import run_scene

    plan = make_plan(*vary(source, changes))
    demand_affordable(plan.scene, plan.motion.strike.t)
    return run_scene(plan)


def outcome_columns(outcome: Outcome) -> dict[str, Any]:
    """Columns of a run that came to its end, SI; those of the tail-slap are missing where it was not reached."""
    from tailslap.report.summary import cost

    failed = [check.name for check in outcome.checks if not check.passed]
    spent = cost(outcome)
    return {
        "status": FAILED if failed else PASSED,
        "reason": ", ".join(failed),
        **_named("rigid", outcome.rigid),
        "rigid.peak_force": float(outcome.fe_plan.plan.force.peak_force),
        **_named("fe", outcome.fe),
        **_named("difference", outcome.difference),
        "deflection_ratio": float(outcome.fe_plan.deflection_ratio),
        "numerical_error": float(outcome.error.total),
        **{check_column(check.name): float(check.value) for check in outcome.checks},
        **_named("cost", {name: value for name, value in spent.items() if name != "pictures_s"}),
    }


def check_column(name: str) -> str:
    """The column of a check's value."""
    return "check." + name.replace(" ", "_").replace("-", "_")


@functools.cache
def versions() -> Mapping[str, str]:
    """Columns with the versions that a row was computed with."""
    libraries = {name: version(name) for name in ("numba", "numpy", "scipy")}
    return _named("version", {"tailslap": tailslap.__version__, **libraries})


def _named(group: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {f"{group}.{name}": value for name, value in numbers.items()}
