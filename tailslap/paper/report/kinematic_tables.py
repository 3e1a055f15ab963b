"""Table 1, Table 3 and Figures 10 to 14 as tables of text."""

from __future__ import annotations

import numpy as np

from postprocess.comparison.comparison import QUANTITIES, Quantity
from postprocess.pages.paper_page import PRINTED, Column, Row, Table
from tailslap.paper.figures import FIGURES, Figures, course
from tailslap.paper.printed import ABAQUS, INPUTS, KM_PER_HOUR, MPH, START
from tailslap.paper.report.text import cells, columns, fixed, shared
from tailslap.paper.table_1 import Table1
from tailslap.paper.table_3 import Column as Cells
from tailslap.paper.table_3 import Table3

DECIMALS = {"theta": 4, "t": 5, "v_gy": 4, "v_gx": 3, "omega": 5, "slide": 4}
"""Decimals of a computed value in SI."""

NAMES = {"theta": Quantity("theta", "Angle between side PE and the wall", "θ", "rad"), **QUANTITIES}
ORDER = ("t", "v_gy", "v_gx", "omega", "slide")  # of Table 3


def table_1_inputs(result: Table1) -> Table:
    """The inputs as printed and in SI, and what follows from vehicle and angle."""
    given = [
        Row(item.symbol, (item.given, f"{item.value:.7g}", item.place), item.unit, item.title)
        for item in INPUTS
    ]
    derived = result.derived
    follows = (
        ("γ", "Corner angle, atan(B/L)", derived.gamma, "rad", "Eq 63"),
        ("φ", "Angle between wall and PG, θ + γ", derived.phi, "rad", "Eq 63"),
        ("β", "Direction of the impulse, atan(1/μ_k)", derived.beta, "rad", "Eq 7"),
        ("r_PG", "Corner to centre of mass", derived.corner_radius, "m", "Eq 15"),
        ("I_G", "Moment of inertia", derived.moment_of_inertia, "kg m²", "Eq 26"),
    )
    derivations = (
        Row(symbol, ("", f"{value:.7g}", where), unit, title) for symbol, title, value, unit, where in follows
    )
    heads = (Column("printed", PRINTED), Column("SI"), Column("where"))
    return Table(
        "Inputs, and what follows from them",
        "Input",
        heads,
        (*given, *derivations),
        spelled=True,
        symbols=True,
    )


def table_1_start(result: Table1) -> Table:
    """The printed start of Stage 2 beside Stage 1 from either speed."""
    quantities = (
        ("ω_0", "rad/s", "Angular velocity after Stage 1", "omega", fixed(6), "0.707"),
        ("v_P0", "m/s", "Corner speed after Stage 1", "corner_speed", fixed(6), "25.053"),
        ("v_0Y", "km/h", "Speed across the wall, v_0 sin θ", "lateral_speed", fixed(3, KM_PER_HOUR), "23.3"),
    )
    rows = []
    for head, unit, title, name, show, printed in quantities:
        mph, metric = (getattr(result.starts[words], name) for words in ("56 mph", "90 km/h"))
        rows.append(Row(head, (*cells(mph, show, printed=printed), *cells(metric, show)[1:]), unit, title))
    speed = result.implied_speed
    note = (
        f"v_P0 = {START.corner_speed:g} m/s is reached from {speed:.4f} m/s, "
        f"that is {speed / MPH:.3f} mph or {speed / KM_PER_HOUR:.3f} km/h."
    )
    heads = (Column("printed", PRINTED), *shared("56 mph", "90 km/h"))
    title = "The printed start of Stage 2, computed from 56 mph and from 90 km/h"
    return Table(title, "Stage 1", heads, tuple(rows), (note,), symbols=True)


def table_3_analytical(result: Table3) -> Table:
    """The analytical column beside the exact motion with friction, from three starts."""
    rows = [_row(name, result.analytical, result.analytical_56, result.analytical_15) for name in ORDER]
    heads = shared("as printed", "from 56 mph", "56 mph, 15°")
    force = result.peak_force
    notes = (
        'Exact motion with friction μ_k |N| ("drag", Eqs 66-67) at θ = 0. As printed: from the paper\'s start, '
        f"θ_0 = {START.angle:g} rad, ω_0 = {START.omega:g} rad/s, v_P0 = {START.corner_speed:g} m/s. From 56 mph: ω_0 "
        "and v_P0 by Stage 1, θ_0 as printed; then θ_0 = 15 deg as well, not rounded. The paper prints the magnitude "
        "of v_GY; towards the wall it is negative.",
        f"Peak force 2 m |v_GY|/Δt (Eqs 72-73) for Δt = 0.1 s: {force.computed / 1e3:.1f} kN from the printed "
        f"start, {force.printed / 1e3:.1f} kN from the printed v_GY.",
    )
    return _table_3("Analytical column", heads, rows, notes)


def table_3_abaqus(result: Table3) -> Table:
    """The ABAQUS column beside the motion without friction, twice, and that with friction."""
    rows = [_row(name, result.abaqus, result.abaqus_read, result.abaqus_drag) for name in ORDER]
    heads = shared("none, θ = 0", f"none, {result.reading:g} s", "drag, same s")
    note = (
        'The printed start without friction ("none") at θ = 0 and at an earlier instant; last, the motion with '
        f"friction at the instant at which its corner has slid the printed {ABAQUS['slide']:g} m."
    )
    return _table_3("ABAQUS column", heads, rows, (note,))


def figure_readings(result: Figures) -> Table:
    """What the paper reads off its charts, beside the exact motion."""
    rows = []
    for reading in result.readings:
        quantity = NAMES[reading.quantity]
        shown = cells(reading.value, fixed(DECIMALS[reading.quantity]), printed=f"{reading.value.printed:g}")
        title = f"{quantity.symbol} [{quantity.unit}]"
        rows.append(Row(f"{reading.figure}", (title, reading.where, *shown)))
    heads = (Column("quantity"), Column("read at"), *columns())
    note = "Computed is the exact motion with friction, from the printed start."
    return Table("What the paper reads off the charts", "Figure", heads, tuple(rows), (note,))


def figure_course(result: Figures) -> Table:
    """The exact motion at a few instants, to lay over the charts."""
    values = course("drag", np.array(result.instants))
    rows = tuple(
        Row(f"{t:.4f}", tuple(fixed(DECIMALS[name])(values[name][i]) for name in FIGURES.values()))
        for i, t in enumerate(values["t"])
    )
    heads = tuple(
        Column(f"{NAMES[name].symbol} [{NAMES[name].unit}]", group=f"Fig. {number}")
        for number, name in FIGURES.items()
    )
    return Table("The exact motion with friction, to lay over the charts", "t [s]", heads, rows)


def _table_3(title: str, heads: tuple[Column, ...], rows: list[Row], notes: tuple[str, ...]) -> Table:
    return Table(title, "", (Column("printed", PRINTED), *heads), tuple(rows), notes, symbols=True)


def _row(name: str, *columns: Cells) -> Row:
    """The printed value, and what each column has beside it."""
    quantity, show = NAMES[name], fixed(DECIMALS[name])
    texts = [text for column in columns for text in cells(column[name], show)[1:]]
    return Row(quantity.symbol, (f"{columns[0][name].printed:g}", *texts), quantity.unit, quantity.title)
