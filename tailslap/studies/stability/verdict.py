"""The verdict on a cell: what became of its run, and what that was compared with."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError
from tailslap.scene.vary import Changes, Source, vary
from tailslap.scene_run import Outcome, run_scene

RIGHT, FLEXIBLE, REFUSED, CAUGHT, WRONG = "right", "flexible", "refused", "caught", "wrong"


@dataclass(frozen=True)
class Verdict:
    """How a cell ended; NaN stands for what is not known.

    Parameters
    ----------
    kind : str
        One of the campaign's kinds.
    failed, reason : str
        Names of the checks that failed; otherwise why the cell is refused, wrong, or flexible.
    difference, reference : float
        Largest difference of the five quantities from the rigid motion: of the run, and of the refined model.
    distance, allowed : float
        Largest difference between the two, and how large it may be.
    error : float
        The run's own estimate of its numerical error.
    model, reference_model : str
        Elements of the run, and the refined model.
    steps : int
        Steps of the run.
    seconds, reference_seconds : float
        Wall-clock time of the run, and of the refined model [s].
    """

    kind: str
    failed: str = ""
    reason: str = ""
    distance: float = math.nan
    allowed: float = math.nan
    difference: float = math.nan
    reference: float = math.nan
    error: float = math.nan
    model: str = ""
    reference_model: str = ""
    steps: int = 0
    seconds: float = 0.0
    reference_seconds: float = 0.0

    @property
    def why(self) -> str:
        """Failed checks, or the reason."""
        return self.failed or self.reason


class Calculation(NamedTuple):
    """How a cell is run: what makes its outcome of a scene and changes, and the error that the outcome claims."""

    run: Callable[[Source, Changes], Any]
    error: Callable[[Any], float]


def _run_corner(base: Source, changes: Changes) -> Outcome:
    return run_scene(CornerCase(*vary(base, changes)))


def _total_error(outcome: Outcome) -> float:
    return outcome.error.total


CORNERS = Calculation(_run_corner, _total_error)
"""How a cell with a constrained corner is run."""


def verdict_on(
    base: Source, changes: Changes, verify: Callable[[Any], Verdict], calculation: Calculation = CORNERS
) -> dict[str, Any]:
    """Run the scene with these changes, and judge it by `verify`; a record of the journal."""
    began = time.perf_counter()
    try:
        outcome = calculation.run(base, changes)
    except InputError as error:
        return asdict(Verdict(REFUSED, reason=str(error)))
    except Exception as error:  # whatever it is, a program that breaks has not refused
        return asdict(Verdict(WRONG, reason=f"broke: {type(error).__name__}: {error}"))
    seconds = time.perf_counter() - began
    try:
        verdict = verify(outcome)
    except Exception as error:  # the reference breaks, and with it the program
        verdict = Verdict(WRONG, reason=f"reference broke: {type(error).__name__}: {error}")
    estimate, steps = calculation.error(outcome), outcome.run.steps
    return asdict(replace(verdict, error=estimate, model=model_name(outcome), steps=steps, seconds=seconds))


def model_name(outcome: Any) -> str:
    """Elements of a run, like "quad9 20 x 6"."""
    plate = outcome.fe_plan.plate
    return f"{plate.element} {plate.counts[0]} x {plate.counts[1]}"


def by_refinement(name: str, moved: float, allowed: float, found: float, its: float, began: float) -> Verdict:
    """The verdict by a refined model of this name, which moved the result by so much; began: when its run did [s]."""
    seconds = time.perf_counter() - began
    kind, reason = (FLEXIBLE, name) if moved <= allowed else (WRONG, f"{name} changes it by {moved:.1e}")
    return Verdict(kind, "", reason, moved, allowed, found, its, reference_seconds=seconds)


def distance(ours: Mapping[str, float], its: Mapping[str, float]) -> float:
    """Largest difference between two sets of quantities."""
    return max(abs(value - its[name]) for name, value in ours.items())
