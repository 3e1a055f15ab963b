"""Damping that keeps a setting from fluttering."""

from __future__ import annotations

from tailslap.fe_plan import rigid_start
from tailslap.plan import Plan
from tailslap.tolerance.candidates import Candidate, coarsest

MARGIN = 2.0
"""Times the damping that calms the linearised model, which looks at few of the angles that the plate goes through."""

MOST_NODES = 350
"""Nodes up to which flutter is foretold for the setting itself: the analysis is dense."""


def calming_ratio(plan: Plan, best: Candidate) -> float:
    """Damping ratio that keeps the setting from fluttering, or 0: the cure foretold, with a margin.

    For a large model it is that of a small one, at the same modes, with the margin twice: fine meshes flutter sooner.
    0 as well where the scene has damping of its own.
    """
    from fem.flutter import CALM, foresee_flutter

    if plan.scene.damping is not None:
        return 0.0
    model = best.model
    small = model if model.loop.mass.size <= MOST_NODES else coarsest(plan, best.rung.constraint)[1].model
    flutter = foresee_flutter(small, rigid_start(plan), plan.motion.strike.t)
    if flutter is None or flutter.growth <= CALM or flutter.cure is None:
        return 0.0
    ratio = MARGIN * flutter.cure
    if small is not model:
        ratio *= MARGIN * model.highest_frequency / small.highest_frequency
    return min(1.0, ratio)
