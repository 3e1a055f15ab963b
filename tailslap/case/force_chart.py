"""Lateral force of the rigid vehicle beside the design forces of its test level: chart and tables."""

from typing import Any

import numpy as np

from postprocess.figures.impact import StrikeMark, draw_forces
from postprocess.report.tables import Table
from postprocess.signals.filters import force_curves
from postprocess.svg.chart import FULL, Chart
from tailslap.case.case import Case
from tailslap.case.run_report import design_table, known_forces, short, strikes_table

INTERVAL = 5e-4
"""Time between samples of the force at the tail-slap [s]."""

AFTER = 0.1
"""Time that is shown after the pulse of the tail-slap [s]."""


def force_chart(case: Case) -> Chart:
    """Draw the force of a whole impact, or the reaction of Stage 2 and the pulse of Stage 3."""
    t, curves, strikes = (_impact if case.scene.contact else _tail_slap)(case)
    level = case.scene.impact.test_level if case.scene.impact else None
    levels = {name: each.force for name, each in known_forces(level).items()}
    caption = "Lateral force on the wall, rigid vehicle" + ("; lines across: design forces" if levels else "")
    return draw_forces("force", caption, t, curves, strikes, levels, FULL)


def _impact(case: Any) -> tuple[np.ndarray, dict[str, np.ndarray], list[StrikeMark]]:
    answer = case.answer
    strikes = [
        StrikeMark(each.corner.removesuffix(" far side"), each.start, each.end) for each in answer.strikes
    ]
    return answer.history["t"][1:], answer.lateral, strikes


def _tail_slap(case: Any) -> tuple[np.ndarray, dict[str, np.ndarray], list[StrikeMark]]:
    start, pulse, history = case.duration, case.force, case.rigid_history()
    end = start + float(pulse.duration)
    t = np.arange(0.0, end + AFTER, INTERVAL)
    triangle = np.interp(t, [start, 0.5 * (start + end), end], [0.0, float(pulse.peak_force), 0.0])
    force = np.interp(t, history["t"], history["reaction_normal"], right=0.0) + triangle
    return t, force_curves(force, INTERVAL, ("raw", "mean_50ms")), [StrikeMark("tail-slap", start, end)]


def force_tables(case: Any) -> dict[str, Table]:
    """Strikes of a whole impact, and the largest force over each design force."""
    if not case.scene.contact:
        return {"Design forces": short(design_table(case, float(case.force.peak_force)))}
    answer = case.answer
    tables = {"Strikes": strikes_table({"rigid": answer.numbers()["strikes"]})}
    return tables | {"Design forces": short(design_table(case, answer.peaks["mean_50ms"]))}
