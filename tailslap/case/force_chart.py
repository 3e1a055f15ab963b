"""Chart and tables of the lateral force of the rigid vehicle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.report.tables import Table
from postprocess.signals.filters import force_curves
from tailslap.case.report_parts import design_forces_of, design_table, short, strikes_table

if TYPE_CHECKING:
    from postprocess.figures.impact import StrikeMark
    from postprocess.svg.chart import Chart
    from tailslap.case.corner.rigid_stages import RigidStages
    from tailslap.case.impact.rigid import RigidImpact

    Curves = tuple[NDArray[np.float64], dict[str, NDArray[np.float64]], list[StrikeMark]]

INTERVAL = 5e-4
"""Time between samples of the force at the tail-slap [s]."""

AFTER = 0.1
"""Time in the chart after the pulse of the tail-slap [s]."""


def force_chart(case: Any) -> Chart:
    """Draw the lateral force of the rigid vehicle.

    Of a constrained corner these are the reaction of Stage 2 and the pulse of Stage 3.
    """
    from postprocess.figures.impact import Forces, draw_forces

    t, curves, strikes = (_impact if case.scene.contact else _tail_slap)(case)
    levels = {name: design.force for name, design in design_forces_of(case.scene).items()}
    caption = "Lateral force on the wall, rigid vehicle" + ("; lines across: design forces" if levels else "")
    return draw_forces(caption, [Forces("force on the wall", t, curves)], strikes, levels)


def _impact(case: RigidImpact) -> Curves:
    from postprocess.figures.impact import StrikeMark

    answer = case.answer
    strikes = [
        StrikeMark(strike.corner.removesuffix(" far side"), strike.start, strike.end)
        for strike in answer.strikes
    ]
    return answer.history["t"][1:], answer.lateral, strikes


def _tail_slap(case: RigidStages) -> Curves:
    from postprocess.figures.impact import StrikeMark

    start, pulse, history = case.duration, case.force, case.rigid_history()
    end = start + float(pulse.duration)
    t = np.arange(0.0, end + AFTER, INTERVAL)
    triangle = np.interp(t, [start, 0.5 * (start + end), end], [0.0, float(pulse.peak_force), 0.0])
    force = np.interp(t, history["t"], history["reaction_normal"], right=0.0) + triangle
    return t, force_curves(force, INTERVAL, ("raw", "mean_50ms")), [StrikeMark("tail-slap", start, end)]


def force_tables(case: Any) -> dict[str, Table]:
    """Return tables of strikes and of the largest force over design forces."""
    if not case.scene.contact:
        return {"Design forces": short(design_table(case, case.mean_force(float(case.force.peak_force))))}
    answer = case.answer
    if case.space:
        return {
            "Strikes": strikes_table({"in space": case.space.strikes}),
            "Design forces": short(design_table(case, in_space=case.space.numbers())),
        }
    tables = {"Strikes": strikes_table({"rigid": answer.numbers()["strikes"]})}
    longitudinal = float(answer.longitudinal["mean_50ms"].max())
    return tables | {"Design forces": short(design_table(case, answer.peaks["mean_50ms"], longitudinal))}
