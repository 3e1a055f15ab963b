"""What the `rigid` command answers: the three stages, as plain numbers and as lines of text."""

from __future__ import annotations

from typing import Any

from tailslap.plan import Plan, other_convention

COMPARED = ("t", "v_gx", "v_gy", "omega", "slide")
"""The quantities that are compared at the tail-slap."""


def stage_two_numbers(plan: Plan) -> dict[str, float]:
    """State at the tail-slap, SI, by the names of `summary.json`."""
    return {name: float(getattr(plan.motion.strike, name)) for name in COMPARED}


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


def rigid_lines(plan: Plan) -> list[str]:
    """The answer as a person reads it."""
    answer = rigid_answer(plan)
    start, two, three = answer["start"], answer["stage2"], answer["stage3"]
    lines = [f"{plan.scene.name}: rigid-body method, reaction {plan.scene.corner.reaction}", ""]
    if one := answer["stage1"]:
        lines += [
            "Stage 1, impulse at the front corner",
            *_rows(("angular velocity", one["omega"], "rad/s"), ("corner speed", one["corner_speed"], "m/s")),
            *_rows(("impulse", one["impulse"] / 1e3, "kN s")),
        ]
    lines += [
        "Stage 2, from",
        *_rows(("angle", start["angle"], "rad"), ("angular velocity", start["omega"], "rad/s")),
        *_rows(("corner speed", start["corner_speed"], "m/s")),
        "to the tail-slap",
        *_rows(("time", two["t"], "s"), ("v_GX", two["v_gx"], "m/s"), ("v_GY", two["v_gy"], "m/s")),
        *_rows(("angular velocity", two["omega"], "rad/s"), ("slide", two["slide"], "m")),
        "Stage 3, tail-slap",
        *_rows(("impulse", three["impulse"] / 1e3, "kN s"), ("duration", three["duration"], "s")),
        *_rows(("peak force", three["peak_force"] / 1e3, "kN")),
    ]
    if other := answer["other_convention"]:
        force = other["stage3"]["peak_force"] / 1e3
        lines += ["", f'With the convention "{other["convention"]}" the peak force would be {force:.4g} kN.']
    return lines


def _rows(*rows: tuple[str, float, str]) -> list[str]:
    return [f"  {name:<18}{value:>14.7g} {unit}" for name, value, unit in rows]
