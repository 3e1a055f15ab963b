"""Picks the cheapest setting that is expected to meet a tolerance.

What a run is compared with depends on the plate. Where its flexibility stays below the tolerance, it is the exact rigid
motion, and the error is predicted by the plate's deflection ratio, which needs no run. Where it does not, it is the
flexible plate's own limit of fine meshes and an exact constraint, and the modal model of each mesh predicts the error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError, Verbatim
from tailslap.planning.flexibility import sensitivity
from tailslap.scene.vary import shown
from tailslap.tolerance.candidates import Candidate, candidate, coarsest, constraints, with_modal_quantities
from tailslap.tolerance.refinement_levels import RefinementLevel, refinement_levels

LEAST = 1e-8
"""Tolerances below this are beyond the rounding of the run and of the result it is compared with."""

MARGIN = 2.0
"""Times the distance from the limit that the modal models show."""

MAX_TRIED, SETTLED = 4_000, 0.1
"""Elements up to which the limit is sought, and the share of the tolerance to which it is known then."""

RIGID, LIMIT = "rigid", "limit"
"""What the result is compared with."""


@dataclass(frozen=True)
class Choice:
    """What was picked. against: RIGID or LIMIT; errors are relative, the largest of the five quantities.

    flexibility: by how much, at most, the plate's own flexibility moves the result. limit: the five quantities by modes
    of the finest mesh tried, where they were asked for; limit_deflection_ratio: of that mesh.
    """

    tolerance: float
    against: str
    level: RefinementLevel
    expected_error: float
    expected_seconds: float
    flexibility: float
    limit: Mapping[str, float] = field(default_factory=dict)
    limit_deflection_ratio: float = math.nan

    @property
    def changes(self) -> tuple[str, ...]:
        """The setting as --set would give it."""
        return shown({key: value for key, value in self.level.changes.items() if value is not None})


def choose(plan: RigidStages, tolerance: float) -> Choice:
    """The cheapest setting expected to meet the tolerance. Raises InputError where there is none."""
    if not LEAST <= tolerance < 1.0:
        raise InputError("--tolerance", Verbatim(f"{tolerance:g}"), f"allowed is from {LEAST:g} to below 1")
    flexibility = math.inf
    for constraint in constraints(plan.scene):
        coarse = coarsest(plan, constraint)
        error = sensitivity(plan.start.angle) * max(made.deflection_ratio for made in coarse)
        flexibility = min(flexibility, error)
        if error <= tolerance:
            return Choice(tolerance, RIGID, coarse[0].level, error, coarse[0].seconds, flexibility)
    return _towards_the_limit(plan, tolerance, flexibility)


def _towards_the_limit(plan: RigidStages, tolerance: float, flexibility: float) -> Choice:
    """The cheapest mesh that is near enough to ever finer ones."""
    if plan.scene.corner.patch_length is None:
        allowed = (
            f"the plate's flexibility moves the result by up to {flexibility:.1e}, and a corner held at one node has "
            "no limit of fine meshes to come closer to; allowed is that much, or a scene with corner.patch_length"
        )
        raise InputError("--tolerance", Verbatim(f"{tolerance:g}"), allowed)
    factor = sensitivity(plan.start.angle)
    found = _until_settled(plan, tolerance, factor)
    finest = found[-1]
    errors = {made: MARGIN * made.distance(finest, factor) for made in found[:-1]}
    good = [
        made
        for made in errors
        if all(errors[other] <= tolerance for other in errors if _at_least(other, made))
    ]
    if not good:
        nearest = min(errors.values(), default=math.inf)
        allowed = f"the finest mesh tried is expected to come within {nearest:.1e} of the limit"
        raise InputError("--tolerance", Verbatim(f"{tolerance:g}"), allowed)
    best = min(good, key=lambda made: made.seconds)
    choice = Choice(tolerance, LIMIT, best.level, errors[best], best.seconds, flexibility)
    return replace(choice, limit=finest.quantities, limit_deflection_ratio=finest.deflection_ratio)


def _at_least(other: Candidate, made: Candidate) -> bool:
    """Whether it is the same mesh or a finer one of the same element: near by chance is not near."""
    return other.level.element == made.level.element and other.level.fineness >= made.level.fineness


def _until_settled(plan: RigidStages, tolerance: float, factor: float) -> list[Candidate]:
    """Candidates from coarse to fine, until three quadratic meshes agree to a share of the tolerance."""
    found: list[Candidate] = []
    for level in refinement_levels(plan.scene, constraints(plan.scene)[-1]):
        if level.elements[0] * level.elements[1] > MAX_TRIED:
            break
        made = candidate(plan, level)
        found += [with_modal_quantities(made)] if made else []
        last = [made for made in found if made.level.element == "quad9"][-3:]
        if len(last) == 3 and max(made.distance(last[-1], factor) for made in last) < SETTLED * tolerance:
            break
    if len(found) < 2:
        raise InputError(
            "corner.patch_length", plan.scene.corner.patch_length, "no mesh tried has a node within it"
        )
    return sorted(found, key=lambda made: made.level.fineness)
