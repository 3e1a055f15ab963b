"""Table 1, Table 3 and Figures 10 to 14: what stands in their columns."""

from __future__ import annotations

import numpy as np

from postprocess.comparison.comparison import QUANTITIES, Quantity
from postprocess.report.table import Column, Table
from tailslap.paper.figures import FIGURES, Figures, course
from tailslap.paper.printed import ABAQUS, INPUTS, KM_PER_HOUR, LATERAL_SPEED, MPH, START, Input
from tailslap.paper.report.columns import computed, printed
from tailslap.paper.table_1 import Table1
from tailslap.paper.table_3 import Table3

DECIMALS = {"theta": 4, "v_gy": 4, "v_gx": 3, "omega": 5, "slide": 4}
NAMES = {"theta": Quantity("theta", "Angle between side PE and the wall", "θ", "rad"), **QUANTITIES}
ORDER = ("t", "v_gy", "v_gx", "omega", "slide")  # of Table 3

INPUT = (
    Column("title", "Input"),
    Column("symbol", ""),
    Column("given", "printed", form=str, style="soft"),
    Column("value", "SI", form=".7g"),
    Column("unit", ""),
    Column("place", "where"),
)
START_FROM = (
    Column("from", "Stage 1"),
    *computed("omega", ".6f", "ω_0 [rad/s]"),
    *computed("corner_speed", ".6f", "v_P0 [m/s]"),
    *computed("lateral_speed", lambda speed: f"{speed / KM_PER_HOUR:.3f}", "v_0 sin θ [km/h]"),
)
READING = (
    Column("figure", "Figure"),
    Column("quantity", "quantity", form=lambda name: NAMES[name].label),
    Column("where", "read at", form=str),
    printed("value"),
    *computed("value"),
)


def table_1_inputs(result: Table1) -> Table:
    """The inputs as printed and in SI, and what follows from vehicle and angle."""
    its = result.derived
    follows = (
        Input("gamma", "γ", "Corner angle, atan(B/L)", "", its.gamma, "rad", "Eq 63"),
        Input("phi", "φ", "Angle between wall and PG, θ + γ", "", its.phi, "rad", "Eq 63"),
        Input("beta", "β", "Direction of the impulse, atan(1/μ_k)", "", its.beta, "rad", "Eq 7"),
        Input("corner_radius", "r_PG", "Corner to centre of mass", "", its.corner_radius, "m", "Eq 15"),
        Input("inertia", "I_G", "Moment of inertia", "", its.moment_of_inertia, "kg m²", "Eq 26"),
    )
    return Table(INPUT, (*INPUTS, *follows), "Inputs, and what follows from them")


def table_1_start(result: Table1) -> Table:
    """Stage 1 from either speed, beside the printed start of Stage 2."""
    rows = [{"from": name, **vars(start)} for name, start in result.starts.items()]
    speed = result.implied_speed
    note = (
        f"Printed: ω_0 = {START.omega:g} rad/s, v_P0 = {START.corner_speed:g} m/s, v_0 sin θ = "
        f"{LATERAL_SPEED / KM_PER_HOUR:g} km/h. This v_P0 is reached from {speed:.4f} m/s, that is "
        f"{speed / MPH:.3f} mph or {speed / KM_PER_HOUR:.3f} km/h."
    )
    title = "The printed start of Stage 2, computed from 56 mph and from 90 km/h"
    return Table(START_FROM, rows, title, (note,))


def table_3_analytical(result: Table3) -> Table:
    """The analytical column beside the exact motion with friction, from three starts."""
    columns = {"analytical": "as printed", "analytical_56": "from 56 mph", "analytical_15": "56 mph, 15°"}
    force = result.peak_force
    notes = (
        'Exact motion with friction μ_k |N| ("drag", Eqs 66-67) at θ = 0. As printed: from the paper\'s start, '
        f"θ_0 = {START.angle:g} rad, ω_0 = {START.omega:g} rad/s, v_P0 = {START.corner_speed:g} m/s. From 56 mph: ω_0 "
        "and v_P0 by Stage 1, θ_0 as printed; then θ_0 = 15 deg as well, not rounded. The paper prints the magnitude "
        "of v_GY; towards the wall it is negative.",
        f"Peak force 2 m |v_GY|/Δt (Eqs 72-73) for Δt = 0.1 s: {force.computed / 1e3:.1f} kN from the printed "
        f"start, {force.printed / 1e3:.1f} kN from the printed v_GY.",
    )
    return _table_3("Analytical column", result, columns, notes)


def table_3_abaqus(result: Table3) -> Table:
    """The ABAQUS column beside the motion without friction, twice, and that with friction."""
    columns = {
        "abaqus": "none, θ = 0",
        "abaqus_read": f"none, {result.reading:g} s",
        "abaqus_drag": "drag, same s",
    }
    note = (
        'The printed start without friction ("none") at θ = 0 and at an earlier instant; last, the motion with '
        f"friction at the instant at which its corner has slid the printed {ABAQUS['slide']:g} m."
    )
    return _table_3("ABAQUS column", result, columns, (note,))


def figure_readings(result: Figures) -> Table:
    """What the paper reads off its charts, beside the exact motion."""
    note = "Computed is the exact motion with friction, from the printed start."
    return Table(READING, result.readings, "What the paper reads off the charts", (note,))


def figure_course(result: Figures) -> Table:
    """The exact motion at a few instants, to lay over the charts."""
    values = course("drag", np.array(result.instants))
    columns = [
        Column(name, NAMES[name].symbol, NAMES[name].unit, f"z.{DECIMALS[name]}f", group=f"Fig. {number}")
        for number, name in FIGURES.items()
    ]
    rows = [dict(zip(values, row, strict=True)) for row in zip(*values.values(), strict=True)]
    title = "The exact motion with friction, to lay over the charts"
    return Table((Column("t", "t", "s", ".4f"), *columns), rows, title)


def _table_3(title: str, result: Table3, columns: dict[str, str], notes: tuple[str, ...]) -> Table:
    """Printed values, and what each of the record's columns has beside them."""
    heads = [
        Column("quantity.label", "", below=Column("quantity.title", "")),
        printed(next(iter(columns))),
        *(column for name, group in columns.items() for column in computed(name, group=group)),
    ]
    rows = [
        {"quantity": NAMES[name], **{key: getattr(result, key)[name] for key in columns}} for name in ORDER
    ]
    return Table(tuple(heads), rows, title, notes)
