"""The reference of a random cell: the same plate on a finer mesh of quadratic elements, held exactly."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass

from fem.discretisation.element_kinds import ELEMENT_KINDS
from postprocess.comparison.comparison import largest
from tailslap.errors import InputError
from tailslap.planning.plan import make_plan
from tailslap.run import MORE_DAMPING, Outcome, attempt, damping_is_open, rings
from tailslap.scene.files import validate
from tailslap.scene.schema import Plate
from tailslap.studies.stability.axes import Tables
from tailslap.studies.stability.effort import expected_effort

FINER, MOST_ELEMENTS = 1.5, 600
"""Times as fine as the cell's mesh, both ways, and elements of which a reference has no more."""

MOST_SECONDS = 20.0
"""Expected seconds above which a coarser reference is taken."""

CALMING = 0.05
"""Stiffness-proportional damping of the reference that is tried last."""

SWAYED = (5e-4, 0.1)
"""What damping and ringing may change in a reference: a part of its own, and a share of its flexibility."""

DEMANDED = {
    *("tail-slap reached", "finite numbers", "time step", "energy balance", "momentum balance"),
    *("friction by ringing", "oscillation", "mesh"),
}
"""Checks that a reference must pass; its reaction may ring."""


@dataclass(frozen=True)
class Reference:
    """Differences of a trustworthy refined model from the rigid motion; model: which it was."""

    difference: Mapping[str, float]
    model: str
    seconds: float


def find_reference(tables: Tables, plate: Plate) -> Reference | None:
    """The first model that comes to a trustworthy answer; plate: the cell's own, with what the program chose."""
    began = time.perf_counter()
    for finer, ratio in ((FINER, 0.0), (1.0, 0.0), (0.7, 0.0), (FINER, CALMING), (0.7, CALMING)):
        changed = reference_tables(tables, plate, finer, ratio)
        try:
            plan = make_plan(validate(changed))
            outcome = None if expected_effort(plan).seconds > MOST_SECONDS else _calm(changed)
        except InputError:
            continue
        if outcome is not None and trustworthy(outcome):
            along, across = outcome.fe_plan.plate.counts
            words = f"{outcome.fe_plan.plate.element} {along} x {across}" + (", damped" if ratio else "")
            return Reference(outcome.difference, words, time.perf_counter() - began)
    return None


def reference_tables(tables: Tables, plate: Plate, finer: float, ratio: float = 0.0) -> Tables:
    """Tables of the refined model; ratio: of its damping, 0 to leave it to the program."""
    changed = copy.deepcopy(tables)
    model, corner = changed["plate"], changed["corner"]
    for key in ("hourglass", "lumping", "distortion"):
        model.pop(key, None)
    for key in ("penalty_scale", "damping_ratio"):
        corner.pop(key, None)
    changed.pop("damping", None)
    corner["constraint"] = "exact"
    model["element"] = ELEMENT_KINDS[plate.element].richer or plate.element
    model["elements"] = reference_counts(plate.counts, finer)
    if ratio:
        changed["damping"] = {"ratio": ratio}
    return changed


def reference_counts(counts: tuple[int, int], finer: float) -> tuple[int, int]:
    """Elements along and across: so much finer, but no more than MOST_ELEMENTS."""
    scale = min(finer, math.sqrt(MOST_ELEMENTS / math.prod(counts)))
    along, across = (max(2, math.ceil(scale * count)) for count in counts)
    return along, across


def trustworthy(outcome: Outcome) -> bool:
    """Whether the answer can be taken for the truth about the plate."""
    failed = {check.name for check in outcome.checks if not check.passed}
    finite = bool(outcome.difference) and all(map(math.isfinite, outcome.difference.values()))
    error = outcome.error
    swayed = error.damping + error.ringing > SWAYED[0] + SWAYED[1] * largest(outcome.difference)
    return finite and not failed & DEMANDED and not swayed


def _calm(tables: Tables) -> Outcome:
    """A run, made once more with more damping where it rings; no second mesh."""
    plan = make_plan(validate(tables))
    outcome = attempt(plan)
    if rings(outcome) and damping_is_open(outcome.fe_plan):
        return attempt(plan, MORE_DAMPING)
    return outcome
