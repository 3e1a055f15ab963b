"""Figures 10 to 14: the course of the motion, and what the paper reads off its charts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.elementary import Array
from tailslap.paper.method import Cell, beside, printed_motion
from tailslap.paper.printed import ABAQUS, ANALYTICAL, CHART_TIME, CHART_V_GY, START

FIGURES = {10: "theta", 11: "v_gy", 12: "v_gx", 13: "omega", 14: "slide"}
"""The paper's number of a figure and the quantity in it."""

INSTANTS = 201
ROUND_TIMES = (0.0, 0.1, 0.2, 0.3)  # s; the tail-slap is added


@dataclass(frozen=True)
class Reading:
    """A value that the paper takes from a figure: at which instant, in words; the value beside the exact one."""

    figure: int
    quantity: str
    where: str
    value: Cell


@dataclass(frozen=True)
class Figures:
    """courses: of the reactions "drag" and "none", columns t and those of FIGURES, SI, shape (201,).

    instants: [s], those of the table in the page; readings: what the paper takes from the charts.
    """

    courses: dict[str, dict[str, Array]]
    instants: tuple[float, ...]
    readings: tuple[Reading, ...]


def figures() -> Figures:
    """The exact motions from the printed start, up to the tail-slap."""
    drag = printed_motion("drag")
    strike = drag.strike
    at_strike = [
        Reading(number, name, "θ = 0", beside(ANALYTICAL[name], getattr(strike, name)))
        for number, name in FIGURES.items()
        if name in ANALYTICAL
    ]
    charts = (
        Reading(10, "t", "θ = 0", beside(CHART_TIME, strike.t)),
        Reading(11, "v_gy", f"t = {CHART_TIME} s", beside(CHART_V_GY, float(drag.at(CHART_TIME).v_gy))),
    )
    courses = {reaction: course(reaction) for reaction in ("drag", "none")}
    return Figures(courses, (*ROUND_TIMES, strike.t), (*charts, *at_strike))


def course(reaction: str, instants: Array | None = None) -> dict[str, Array]:
    """Columns t [s] and those of FIGURES, SI, at evenly spaced instants up to the strike, or at these."""
    motion = printed_motion(reaction)
    t = np.linspace(0.0, motion.strike.t, INSTANTS) if instants is None else instants
    states = motion.at(t)
    return {"t": t, **{name: np.asarray(getattr(states, name)) for name in FIGURES.values()}}


def marks(name: str) -> dict[str, tuple[tuple[float, float], ...]]:
    """Printed points (t [s], value in SI) of a quantity of FIGURES: the start's, and those of Table 3's columns."""
    starts = {"theta": START.angle, "omega": START.omega, "slide": 0.0}
    analytical = [(0.0, starts[name])] if name in starts else []
    analytical.append((CHART_TIME, 0.0) if name == "theta" else (ANALYTICAL["t"], ANALYTICAL[name]))
    return {
        "paper": tuple(analytical),
        "ABAQUS": ((ABAQUS["t"], ABAQUS[name]),) if name in ABAQUS else (),
    }
