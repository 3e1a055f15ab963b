"""`tailslap run SCENE --tolerance X`: the cheapest setting expected to meet it, and whether it did."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tailslap.run import Outcome
    from tailslap.tolerance.choose import Choice

LEAST_DAMPING, MORE_DAMPING = 0.1, 5.0
"""Damping ratio of the second attempt: the least, and times the first one's."""


def run_to_tolerance(name: str, changes: tuple[str, ...], tolerance: float) -> Outcome:
    """Pick a setting for the scene with its changes, run it, and judge the result. Raises InputError.

    A run that fails a check is tried once more with more damping, unless the scene has its own: flutter is foretold
    from few angles, and now and then too late.
    """
    from tailslap.plan import make_plan
    from tailslap.scene_files import read_scene
    from tailslap.tolerance.choose import choose

    plan = make_plan(*read_scene(name, changes))
    choice = choose(plan, tolerance)
    outcome = _attempt(name, changes, choice)
    if outcome.passed or plan.scene.damping is not None or plan.scene.corner_friction == 0.0:
        return outcome
    damped = replace(choice, damping=min(1.0, max(LEAST_DAMPING, MORE_DAMPING * choice.damping)))
    again = _attempt(name, changes, damped)
    return again if again.passed else outcome


def _attempt(name: str, changes: tuple[str, ...], choice: Choice) -> Outcome:
    from tailslap.plan import make_plan
    from tailslap.run import run_scene
    from tailslap.scene_files import read_scene
    from tailslap.tolerance.judge import judged

    return judged(run_scene(make_plan(*read_scene(name, (*changes, *choice.changes)))), choice, name, changes)
