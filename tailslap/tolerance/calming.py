"""Damping that keeps a setting from fluttering."""

from __future__ import annotations

from tailslap.fe_plan import rigid_start
from tailslap.plan import Plan
from tailslap.tolerance.candidates import Candidate, candidate, coarsest
from tailslap.tolerance.ladder import ladder

MARGIN = 2.0
"""Times the damping that calms the linearised model, which looks at few of the angles that the plate goes through."""

LEAST_CURE = 0.005
"""Damping ratio for a small model that needs none, where the large one may."""

MOST_NODES = 350
"""Nodes up to which flutter is foretold for the setting itself: the analysis is dense."""


def calming_ratio(plan: Plan, best: Candidate) -> float:
    """Damping ratio that keeps the setting from fluttering, or 0: the cure foretold, with a margin.

    A large model is judged by the finest small one: growth goes with the frequency, and so does what damping of a given
    ratio leaves of a mode; the margin then counts twice. 0 as well where the scene has damping of its own.
    """
    from fem.flutter import CALM, foresee_flutter

    if plan.scene.damping is not None:
        return 0.0
    model = best.model
    small = model if model.loop.mass.size <= MOST_NODES else _finest_small(plan, best).model
    finer = model.highest_frequency / small.highest_frequency
    flutter = foresee_flutter(small, rigid_start(plan), plan.motion.strike.t)
    if flutter is None or flutter.growth * finer <= CALM:
        return 0.0
    cure = flutter.cure or LEAST_CURE
    return min(1.0, MARGIN * cure * (MARGIN * finer if small is not model else 1.0))


def _finest_small(plan: Plan, best: Candidate) -> Candidate:
    """The finest mesh of the same element that the analysis takes."""
    found = coarsest(plan, best.rung.constraint)[-1]
    for rung in ladder(plan.scene, best.rung.constraint):
        made = candidate(plan, rung) if rung.element == best.rung.element else None
        if made is not None:
            if made.model.loop.mass.size > MOST_NODES:
                break
            found = made
    return found
