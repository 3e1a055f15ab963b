"""The reference of a random cell: the same plate on a finer mesh of quadratic elements, held exactly."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from fem.discretisation.element_kinds import ELEMENT_KINDS
from postprocess.comparison.comparison import largest
from tailslap.case.corner.case import CornerCase
from tailslap.case.cost import expected_effort
from tailslap.errors import InputError
from tailslap.scene.schema import Plate
from tailslap.scene.vary import Changes, Source, vary
from tailslap.scene_run import Outcome, settled
from tailslap.studies.stability.verdict import model_name
from tailslap.verification.check import failed_names
from tailslap.verification.mechanics import OSCILLATES
from tailslap.verification.numerical_error import Histories

FINER, FINEST, MAX_ELEMENTS = 1.5, 2.0, 600
"""Times as fine as the cell's mesh, both ways, a second one, and elements of which a reference has no more."""

MAX_SECONDS = 4.0
"""Expected seconds above which a coarser reference is taken."""

FLUTTER_DAMPING = 0.05
"""Stiffness-proportional damping against flutter, of the reference that is tried last."""

SWAYED = (5e-4, 0.1)
"""What damping and ringing may change in a reference: a part of its own, and a share of its flexibility."""

DEMANDED = {
    *("tail-slap reached", "finite numbers", "time step", "energy balance", "momentum balance"),
    *("friction by ringing", "oscillation", "mesh"),
    *("contact work", "friction work", "friction takes energy"),
}
"""Checks that a reference must pass; its reaction may ring."""


@dataclass(frozen=True)
class Reference:
    """Differences of a trustworthy refined model from the rigid motion; model: which it was; its histories, those of
    the plate and of the rigid body."""

    difference: Mapping[str, float]
    model: str
    seconds: float
    histories: Histories


def find_reference(cell: Source, plate: Plate) -> Reference | None:
    """The first model that comes to a trustworthy result; plate: the cell's own, with what the program chose."""
    return next(_references(cell, plate, FINER), None)


def second_opinion(cell: Source, plate: Plate, first: Reference) -> Reference | None:
    """Another trustworthy model."""
    others = _references(cell, plate, FINEST)
    return next((other for other in others if other.model != first.model), None)


def _references(cell: Source, plate: Plate, finest: float) -> Iterator[Reference]:
    """Models that come to a trustworthy result. Damping in proportion to the stiffness would take an unstressed plate's
    oscillation off."""
    began = time.perf_counter()
    damped = ((FINER, FLUTTER_DAMPING), (0.7, FLUTTER_DAMPING)) if plate.relieved else ()
    for finer, ratio in ((finest, 0.0), (1.0, 0.0), (0.7, 0.0), *damped):
        try:
            plan = CornerCase(*vary(cell, reference_changes(plate, finer, ratio)))
            costly = expected_effort(plan.scene, plan.motion.strike.t).seconds > MAX_SECONDS
            outcome = None if costly else settled(plan)
        except InputError:
            continue
        if outcome is not None and trustworthy(outcome):
            name = model_name(outcome) + (", damped" if ratio else "")
            histories = outcome.fe_history, outcome.rigid_history
            yield Reference(outcome.difference, name, time.perf_counter() - began, histories)


def reference_changes(plate: Plate, finer: float, ratio: float = 0.0) -> Changes:
    """What makes a cell's scene the refined model; ratio: of its damping, 0 to leave it to the program."""
    return {
        **quadratic_and_exact(plate, reference_counts(plate.counts, finer)),
        **dict.fromkeys(("plate.lumping", "plate.distortion", "damping")),
        **({"damping.ratio": ratio} if ratio else {}),
    }


def quadratic_and_exact(plate: Plate, counts: tuple[int, int]) -> Changes:
    """So many quadratic elements of the plate's kind, and the exact constraint."""
    return {
        **dict.fromkeys(("corner.penalty_scale", "corner.damping_ratio")),
        "corner.constraint": "exact",
        "plate.element": ELEMENT_KINDS[plate.element].richer or plate.element,
        "plate.elements": counts,
    }


def reference_counts(counts: tuple[int, int], finer: float) -> tuple[int, int]:
    """Elements along and across: so much finer, but no more than MAX_ELEMENTS."""
    scale = min(finer, math.sqrt(MAX_ELEMENTS / math.prod(counts)))
    along, across = (max(2, math.ceil(scale * count)) for count in counts)
    return along, across


def trustworthy(outcome: Outcome) -> bool:
    """Whether the result can be taken for the truth about the plate. What an undamped run may show, an oscillation that
    friction has fed, a reference may not."""
    found, error = largest(outcome.difference), outcome.error
    swayed = error.damping + error.ringing > SWAYED[0] + SWAYED[1] * found
    fed = any(check.name == "oscillation" and check.value > OSCILLATES for check in outcome.checks)
    passed = DEMANDED.isdisjoint(failed_names(outcome.checks))
    return math.isfinite(found) and passed and not swayed and not fed
