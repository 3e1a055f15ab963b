"""A run of the constrained corner as columns of a sweep's table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import KEYS
from tailslap.report.common import run_cost
from tailslap.verification.check import check_columns

if TYPE_CHECKING:
    from tailslap.planning.plan import Plan
    from tailslap.scene.schema import Scene


def corner_column_kinds(scene: Scene) -> dict[str, type]:
    """Columns that the table has whatever its rows, checks beside, and the type of their values. Raises InputError for
    a scene without [plate]."""
    _ = scene.needed_plate
    compared = [f"{group}.{key}" for group in ("rigid", "fe", "difference") for key in KEYS]
    real = dict.fromkeys([*compared, "rigid.peak_force", "deflection_ratio"], float)
    spent = {"cost.elements": int, "cost.nodes": int, "cost.steps": int, "cost.time_step": float}
    return {**real, **spent}


def corner_columns(plan: Plan) -> dict[str, Any]:
    """Columns of the plan's run, SI; those of the tail-slap are missing where it was not reached."""
    from tailslap.scene_run import run_scene

    outcome = run_scene(plan)
    groups = {"rigid": outcome.rigid, "fe": outcome.fe, "difference": outcome.difference}
    groups["cost"] = run_cost(outcome)
    return {
        **check_columns(outcome.checks),
        **{f"{group}.{name}": value for group, its in groups.items() for name, value in its.items()},
        "rigid.peak_force": float(outcome.fe_plan.plan.force.peak_force),
        "deflection_ratio": float(outcome.fe_plan.deflection_ratio),
        "numerical_error": float(outcome.error.total),
    }
