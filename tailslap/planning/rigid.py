"""What the `rigid` command answers: the three stages, as plain numbers and as lines of text."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import KEYS
from tailslap.planning.plan import Plan, other_convention
from tailslap.scene.units import shown, value_line

if TYPE_CHECKING:
    import numpy as np

ROWS = 401
"""Instants of a history of the rigid motion."""


def stage_two_numbers(plan: Plan) -> dict[str, float]:
    """State at the tail-slap, SI, by the names of `summary.json`."""
    return {name: float(getattr(plan.motion.strike, name)) for name in KEYS}


def rigid_history(plan: Plan) -> dict[str, np.ndarray]:
    """Columns of the rigid motion to the tail-slap, by their names in `history.csv`, SI."""
    import numpy as np

    from fem.explicit.columns import COLUMNS

    state = plan.motion.at(np.linspace(0.0, plan.motion.strike.t, ROWS))
    return {name: getattr(state, name) for name in ("t", *COLUMNS) if hasattr(state, name)}


def rigid_answer(plan: Plan) -> dict[str, Any]:
    """Stages 1 to 3, SI, and what the other convention of restitution would have given."""
    stage1, other = plan.stage1, other_convention(plan)
    return {
        "scene": plan.scene.name,
        "stage1": stage1
        and {
            "omega": float(stage1.omega),
            "corner_speed": float(stage1.corner_speed),
            "impulse": float(stage1.impulse),
        },
        "start": {
            "angle": plan.start.angle,
            "omega": float(plan.start.omega),
            "corner_speed": float(plan.start.corner_speed),
        },
        "stage2": stage_two_numbers(plan),
        "stage3": _stage_three(plan),
        "other_convention": other
        and {"convention": other[0], "omega": float(other[1].start.omega), "stage3": _stage_three(other[1])},
    }


def _stage_three(plan: Plan) -> dict[str, float]:
    force = plan.force
    return {
        "impulse": float(force.impulse),
        "duration": float(force.duration),
        "peak_force": float(force.peak_force),
    }


def rigid_lines(plan: Plan, units: str = "si") -> list[str]:
    """The answer as a person reads it, in SI or, with units "us", in ft, mph and kip."""
    answer = rigid_answer(plan)
    start, two, three = answer["start"], answer["stage2"], answer["stage3"]
    rows = functools.partial(_rows, units)
    lines = [f"{plan.scene.name}: rigid-body method, reaction {plan.scene.corner.reaction}"]
    lines += ["US customary units; 1 kip = 1000 lbf", ""] if units == "us" else [""]
    if one := answer["stage1"]:
        lines += [
            "Stage 1, impulse at the front corner",
            *rows(("angular velocity", one["omega"], "rad/s"), ("corner speed", one["corner_speed"], "m/s")),
            *rows(("impulse", one["impulse"], "N s")),
        ]
    lines += [
        "Stage 2, from",
        *rows(("angle", start["angle"], "rad"), ("angular velocity", start["omega"], "rad/s")),
        *rows(("corner speed", start["corner_speed"], "m/s")),
        "to the tail-slap",
        *rows(("time", two["t"], "s"), ("v_GX", two["v_gx"], "m/s"), ("v_GY", two["v_gy"], "m/s")),
        *rows(("angular velocity", two["omega"], "rad/s"), ("slide", two["slide"], "m")),
        "Stage 3, tail-slap",
        *rows(("impulse", three["impulse"], "N s"), ("duration", three["duration"], "s")),
        *rows(("peak force", three["peak_force"], "N")),
    ]
    return lines + _other(answer["other_convention"], units)


def _other(other: dict[str, Any] | None, units: str) -> list[str]:
    """The peak force by the other convention of restitution."""
    if other is None:
        return []
    force = shown(other["stage3"]["peak_force"], "N", units, digits=4)
    return ["", f'With the convention "{other["convention"]}" the peak force would be {force}.']


def _rows(units: str, *rows: tuple[str, float, str]) -> list[str]:
    """Lines of values that are given in SI."""
    return [value_line(*row, units) for row in rows]
