"""`tailslap run SCENE --tolerance X`: the cheapest setting expected to meet it, and whether it did."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tailslap.case.corner.rigid import RigidStages
    from tailslap.scene_run import Outcome


def run_to_tolerance(plan: RigidStages, tolerance: float) -> Outcome:
    """Pick a setting for the plan's scene, run it, and judge the result. Raises InputError."""
    from tailslap.scene_run import run_scene
    from tailslap.tolerance.choose import choose
    from tailslap.tolerance.verify import verified

    choice = choose(plan, tolerance)
    return verified(run_scene(plan.varied(choice.level.changes)), choice, plan)
