"""`tailslap run SCENE --tolerance X`: the cheapest setting expected to meet it, and whether it did."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tailslap.run import Outcome


def run_to_tolerance(name: str, changes: tuple[str, ...], tolerance: float) -> Outcome:
    """Pick a setting for the scene with its changes, run it, and judge the result. Raises InputError."""
    from tailslap.planning.plan import make_plan
    from tailslap.run import run_scene
    from tailslap.scene.files import read_scene
    from tailslap.tolerance.choose import choose
    from tailslap.tolerance.judge import judged

    choice = choose(make_plan(*read_scene(name, changes)), tolerance)
    outcome = run_scene(make_plan(*read_scene(name, (*changes, *choice.changes))))
    return judged(outcome, choice, name, changes)
