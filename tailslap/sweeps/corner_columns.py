"""A run of the constrained corner as columns of a sweep's table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import KEYS

if TYPE_CHECKING:
    from tailslap.scene.schema import Scene
    from tailslap.scene_run import Outcome


def corner_column_kinds(scene: Scene) -> dict[str, type]:
    """Columns that the table has whatever its rows, checks beside, and the type of their values."""
    compared = [f"{group}.{key}" for group in ("rigid", "fe", "difference") for key in KEYS]
    real = dict.fromkeys([*compared, "rigid.peak_force", "deflection_ratio"], float)
    spent = {"cost.elements": int, "cost.nodes": int, "cost.steps": int, "cost.time_step": float}
    return {**real, **spent}


def outcome_columns(outcome: Outcome) -> dict[str, Any]:
    """Columns of a run that came to its end, SI; those of the tail-slap are missing where it was not reached."""
    from tailslap.report.summary import cost

    failed = [check.name for check in outcome.checks if not check.passed]
    spent = cost(outcome)
    return {
        "status": "failed" if failed else "passed",
        "reason": ", ".join(failed),
        **_named("rigid", outcome.rigid),
        "rigid.peak_force": float(outcome.fe_plan.plan.force.peak_force),
        **_named("fe", outcome.fe),
        **_named("difference", outcome.difference),
        "deflection_ratio": float(outcome.fe_plan.deflection_ratio),
        "numerical_error": float(outcome.error.total),
        **{check_column(check.name): float(check.value) for check in outcome.checks},
        **_named("cost", {name: value for name, value in spent.items() if name != "pictures_s"}),
    }


def check_column(name: str) -> str:
    """The column of a check's value."""
    return "check." + name.replace(" ", "_").replace("-", "_")


def _named(group: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {f"{group}.{name}": value for name, value in numbers.items()}
