"""What the `rigid` command says of a whole impact."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from tailslap.case.impact.rigid import RigidImpact
from tailslap.impact.answers import ImpactAnswer, rigid_answer
from tailslap.impact.paper_method import PaperMethod, paper_method
from tailslap.scene.units import shown, value_line

if TYPE_CHECKING:
    from solver.impact import ImpactMotion

SAMPLE = 2e-4
"""Longest time between rows [s]: 5 kHz, above what CFC 180 asks for."""

ROWS_A_STRIKE = 200
"""Rows in the shorter of the rigid vehicle's first two strikes."""


def sample_interval(motion: ImpactMotion) -> float:
    """Time between rows [s] that resolves both strikes of the rigid vehicle."""
    shortest = min((strike.duration for strike in motion.strikes[:2]), default=SAMPLE * ROWS_A_STRIKE)
    return min(SAMPLE, max(shortest / ROWS_A_STRIKE, motion.t_end / MOST_ROWS))


MOST_ROWS = 200_000
"""Of a history, at most."""


def rigid_impact(plan: RigidImpact) -> ImpactAnswer:
    """The rigid vehicle's impact, sampled."""
    motion = plan.motion
    rows = max(2, int(np.ceil(motion.t_end / sample_interval(motion))))
    return rigid_answer(motion, np.linspace(0.0, motion.t_end, rows + 1))


def rigid_history(plan: RigidImpact) -> dict[str, np.ndarray]:
    """Columns of the rigid vehicle's impact by name, SI."""
    return dict(rigid_impact(plan).history)


def rigid_numbers(plan: RigidImpact) -> dict[str, Any]:
    """Strikes, peaks and end, SI."""
    answer = rigid_impact(plan)
    beside = paper_method(plan.scene, answer)
    return {"scene": plan.scene.name, **answer.numbers(), "paper_method": beside and asdict(beside)}


def rigid_lines(plan: RigidImpact, units: str = "si") -> list[str]:
    """The same as a person reads it, in SI or, with units "us", in ft, mph and kip."""
    answer = rigid_impact(plan)
    lines = [f"{plan.scene.name}: whole impact of the rigid vehicle"]
    lines += ["US customary units; 1 kip = 1000 lbf", ""] if units == "us" else [""]
    lines += strike_lines(answer, units)
    lines += ["", "Lateral force on the wall, peak"]
    lines += [value_line(label, answer.peaks[name], "N", units) for name, label in CURVES.items()]
    end = answer.end
    lines += ["", "At the end"]
    labels = {"t": ("time", "s"), "theta": ("angle", "rad"), "omega": ("angular velocity", "rad/s")}
    labels |= {"v_gx": ("v_GX", "m/s"), "v_gy": ("v_GY", "m/s")}
    lines += [value_line(label, end[name], unit, units) for name, (label, unit) in labels.items()]
    return lines + _paper_lines(paper_method(plan.scene, answer), units)


def _paper_lines(beside: PaperMethod | None, units: str) -> list[str]:
    """The paper's method beside it."""
    if beside is None:
        return []
    lines = [
        "",
        "The paper's method, of the uniform rectangle, whose side stops all at once",
        f"  tail-slap at {beside.t:.4g} s, impulse {shown(beside.impulse, 'N s', units, digits=4)}, peak force "
        f"{shown(beside.peak_force, 'N', units, digits=4)} with a duration of {beside.duration:g} s",
    ]
    if beside.computed_duration and beside.computed_peak_force:
        lines.append(
            f"  {shown(beside.computed_peak_force, 'N', units, digits=4)} with {beside.computed_duration:.3f} s, "
            "read off the 50 ms mean above by its rule"
        )
    return lines


CURVES = {
    "raw": "raw",
    "mean_50ms": "50 ms mean",
    "cfc60": "CFC 60",
    "cfc180": "CFC 180",
    "cutoff_60hz": "60 Hz cut-off",
}
"""Labels of the force curves."""


def strike_lines(answer: ImpactAnswer, units: str) -> list[str]:
    """A line a strike."""
    if not answer.strikes:
        return ["no strike"]
    lines = []
    for strike in answer.strikes:
        peak, impulse = shown(strike.peak_force, "N", units), shown(strike.impulse, "N s", units)
        lines.append(
            f"  {strike.corner:<16} from {strike.start:.4f} s for {strike.duration:.4f} s: "
            f"peak {peak}, impulse {impulse}"
        )
    return ["Strikes", *lines]
