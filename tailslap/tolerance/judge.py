"""Checks after the run that the tolerance was met: the expected error is not taken on trust."""

from __future__ import annotations

import math
from dataclasses import replace

from postprocess.report import Check
from tailslap.errors import InputError
from tailslap.plan import Plan, make_plan
from tailslap.run import Outcome, run_scene
from tailslap.scene_files import read_scene
from tailslap.tolerance.choose import RIGID, Choice
from tailslap.tolerance.ladder import Rung

COARSER_SHARE, FINER_SHARE = 1.0 / 3.0, 1.0
"""Least error over the change between two meshes, where the other mesh is half, and twice, as fine: order two."""


def judged(outcome: Outcome, choice: Choice, name: str, changes: tuple[str, ...]) -> Outcome:
    """The outcome with the check "tolerance"; name, changes: the scene as the user gave it."""
    if choice.against == RIGID:
        value, how = _largest(outcome.difference), "difference from the exact rigid motion"
    else:
        value, how = _from_limit(outcome, choice, name, changes)
    met = bool(math.isfinite(value) and value <= choice.tolerance)
    check = Check("tolerance", value, choice.tolerance, met, f"largest of five: {how}")
    return replace(outcome, checks=(*outcome.checks, check), choice=choice)


def _from_limit(outcome: Outcome, choice: Choice, name: str, changes: tuple[str, ...]) -> tuple[float, str]:
    """Estimated distance from the limit of fine meshes, by a second run on another mesh."""
    if not outcome.fe:
        return math.nan, "there is no answer to judge"
    for rung, share in ((choice.rung.scaled(0.5), COARSER_SHARE), (choice.rung.scaled(2.0), FINER_SHARE)):
        plan = _plan(rung, choice, name, changes)
        other = _run(plan) if plan else None
        if other is None or not other.fe:
            continue
        moved = max(abs(other.fe[key] / value - 1.0) for key, value in outcome.fe.items())
        spread = abs(outcome.fe_plan.give - other.fe_plan.give)
        observed = abs(outcome.fe_plan.give - choice.limit) / spread if spread else math.inf
        along, across = other.fe_plan.plate.elements
        how = f"distance from the limit of fine meshes, estimated from a second run with {along} x {across} elements"
        return max(share, observed) * moved, how
    return math.nan, "no second mesh made a model to judge by"


def _plan(rung: Rung | None, choice: Choice, name: str, changes: tuple[str, ...]) -> Plan | None:
    if rung is None:
        return None
    damping = (f"damping.ratio={choice.damping:g}",) if choice.damping else ()
    return make_plan(*read_scene(name, (*changes, *rung.changes, *damping)))


def _run(plan: Plan) -> Outcome | None:
    try:
        return run_scene(plan)
    except InputError:
        return None


def _largest(differences: dict[str, float]) -> float:
    sizes = [abs(value) for value in differences.values()]
    return max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan
