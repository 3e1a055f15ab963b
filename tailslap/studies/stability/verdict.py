"""The verdict on one cell: right, flexible, refused, caught, or wrong without being caught."""

from __future__ import annotations

import copy
import math
from dataclasses import asdict, dataclass
from typing import Any

from fem.discretisation.element_kinds import ELEMENT_KINDS
from tailslap.errors import InputError
from tailslap.planning.plan import make_plan
from tailslap.run import Outcome, run_scene
from tailslap.scene.files import validate
from tailslap.scene.schema import Plate
from tailslap.studies.stability.axes import Tables

RIGHT, FLEXIBLE, REFUSED, CAUGHT, WRONG = KINDS = ("right", "flexible", "refused", "caught", "wrong")

SURVIVES = 0.5
"""Share of a difference that refinement may change for it to count as the plate's own."""


@dataclass(frozen=True)
class Verdict:
    """How a cell ended. difference: largest of the five, of the run and of the refined run; NaN where there is none."""

    kind: str
    reason: str
    difference: float = math.nan
    refined: float = math.nan
    steps: int = 0
    seconds: float = 0.0


def judge(tables: Tables, tolerance: float) -> dict[str, Any]:
    """Run the scene that the tables describe, and once more on a finer mesh if it differs from the rigid motion."""
    try:
        outcome = _run(tables)
    except InputError as error:
        return asdict(Verdict(REFUSED, str(error)))
    except Exception as error:  # whatever it is, a program that breaks has not refused
        return asdict(Verdict(WRONG, f"broke: {type(error).__name__}: {error}"))
    found, effort = _worst(outcome.difference), (outcome.run.steps, outcome.run.time_loop_s)
    if not outcome.passed:
        failed = ", ".join(check.name for check in outcome.checks if not check.passed)
        return asdict(Verdict(CAUGHT, failed, found, math.nan, *effort))
    if found <= tolerance:
        return asdict(Verdict(RIGHT, "", found, math.nan, *effort))
    return asdict(_confirmed(tables, outcome, tolerance))


def _confirmed(tables: Tables, outcome: Outcome, tolerance: float) -> Verdict:
    """Flexible if its own error is small beside the difference and the difference survives refinement, else wrong."""
    found, effort = _worst(outcome.difference), (outcome.run.steps, outcome.run.time_loop_s)
    own, seen = outcome.error.total, "no refined model came to an answer"
    # Statics bounds error and flexibility alike: with a bound that is wide, both are.
    if not own <= tolerance + SURVIVES * max(found, outcome.error.flexibility):
        return Verdict(WRONG, f"its own numerical error is {own:.1e}", found, math.nan, *effort)
    for change in REFINEMENTS:
        try:
            refined = _run(change(copy.deepcopy(tables), outcome.fe_plan.plate))
        except InputError:
            continue
        finer, failed = _worst(refined.difference), {c.name for c in refined.checks if not c.passed}
        if not math.isfinite(finer) or not failed <= BESIDE_THE_POINT:
            continue
        pairs = [(outcome.difference[name], value) for name, value in refined.difference.items()]
        moved = max(abs(ours - its) for ours, its in pairs)
        if moved <= tolerance + SURVIVES * finer:
            return Verdict(FLEXIBLE, change.__name__.strip("_"), found, finer, *effort)
        seen = f"{change.__name__.strip('_')} changes it by {moved:.1e}"
    return Verdict(WRONG, seen, found, math.nan, *effort)


def _finer(tables: Tables, plate: Plate) -> Tables:
    """Twice the elements each way, half the time step, four times the corner's spring; plate: as the run had it."""
    along, across = plate.counts
    tables["plate"] |= {"elements": (2 * along, 2 * across), "element": plate.element}
    time, corner = tables.setdefault("time", {}), tables.setdefault("corner", {})
    time["safety_factor"] = 0.5 * time.get("safety_factor", 0.9)
    if corner.keys() & {"penalty_scale", "damping_ratio"} or corner.get("constraint") == "penalty":
        corner["penalty_scale"] = 4.0 * corner.get("penalty_scale", 1.0)
    return tables


def _finer_and_damped(tables: Tables, plate: Plate) -> Tables:
    """The same, with damping enough to keep the finer model from fluttering."""
    damping = tables.setdefault("damping", {})
    damping["ratio"] = max(0.05, damping.get("ratio", 0.0))
    return _finer(tables, plate)


def _richer(tables: Tables, plate: Plate) -> Tables:
    """Quadratic elements and the exact constraint, on finer elements where they were quadratic already."""
    model, corner = tables["plate"], tables.setdefault("corner", {})
    along, across = plate.counts
    richer = ELEMENT_KINDS[plate.element].richer
    times = 1 if richer else 2
    model["elements"] = (times * along, times * across)
    model["element"] = richer or plate.element
    model.pop("hourglass", None)
    for key in ("penalty_scale", "damping_ratio"):
        corner.pop(key, None)
    corner["constraint"] = "exact"
    return tables


REFINEMENTS = (_finer, _finer_and_damped, _richer)
"""Models that a difference must survive, tried until one comes to an answer that confirms it."""

BESIDE_THE_POINT = {"reaction against rigid", "friction by ringing"}
"""Checks that a refined model may fail and still bear witness to the five quantities: if it is spoilt, it disagrees."""


def _run(tables: Tables) -> Outcome:
    return run_scene(make_plan(validate(tables)))


def _worst(differences: dict[str, float]) -> float:
    sizes = [abs(value) for value in differences.values()]
    return max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.inf
