"""Curves of histories and contour pictures of a constrained corner."""

import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from fem.explicit.columns import COLUMNS
from fem.plate.discretisation import nodal_spin
from postprocess.fields import contours
from postprocess.figures.histories import Panel, draw_histories
from postprocess.figures.positions import draw_positions, vehicle_outlines
from postprocess.report.page import Section
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units
from tailslap import progress
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.run_fields import element_fields

CAPTIONS = {
    "contour_v_gx": "Velocity along the wall at the tail-slap (the paper's Figure 15).",
    "contour_v_gy": "Velocity across the wall at the tail-slap (the paper's Figure 16).",
    "contour_omega": "Angular velocity, half the curl of the velocity, at the tail-slap (the paper's Figure 17).",
    "contour_von_mises": "Von Mises stress of the plate at the tail-slap.",
}

INSTANTS = 5
"""Number of positions of the vehicle that are drawn."""


def curves(outcome: CornerOutcome) -> list[Section]:
    """Draw all histories, with registered columns that have a symbol."""
    plotted = [(name, column) for name, column in COLUMNS.items() if column.symbol]
    title = "Further columns"
    further = tuple(Panel(name, ((name, name),), c.symbol, c.unit, title, c.caption) for name, c in plotted)
    charts = draw_histories(outcome.fe_history, outcome.rigid_history, further)
    groups = dict.fromkeys(chart.group for chart in charts)
    layouts = {"Motion": "wide", "Reaction": "wide"}
    return [
        Section("Positions along the wall", figures=positions(outcome), layout="tall"),
        *(
            Section(
                group,
                figures=[chart for chart in charts if chart.group == group],
                layout=layouts.get(group, ""),
            )
            for group in groups
        ),
    ]


def positions(outcome: CornerOutcome) -> list[Chart]:
    """Draw the vehicle at even instants and its motion until the tail-slap.

    A run without rows has no drawing.
    """
    vehicle, h = outcome.fe_plan.case.scene.vehicle, outcome.fe_history
    finite = np.isfinite(h["theta"]) & np.isfinite(h["slide"])
    t, theta, slide = (h[name][finite] for name in ("t", "theta", "slide"))
    if t.size < 2:
        return []
    ahead, aside = 0.5 * vehicle.length, 0.5 * vehicle.width
    x = slide - ahead * np.cos(theta) + aside * np.sin(theta)
    y = ahead * np.sin(theta) + aside * np.cos(theta)
    outlines = vehicle_outlines(x, y, theta, vehicle.length, vehicle.width, ahead)
    rows = np.unique(np.linspace(0, t.size - 1, INSTANTS).astype(int))
    return [draw_positions(outlines[rows], t[rows], motion=(t, outlines))]


def draw_pictures(
    outcome: CornerOutcome, folder: Path, units: Units = SI, size: contours.Size | None = None
) -> CornerOutcome:
    """Draw the contours of the plate at the tail-slap into a folder.

    Returns the outcome with its pictures, none without a tail-slap or on a machine that cannot draw. size: width and
    height [pixels].
    """
    began, fe_plan, strike = time.perf_counter(), outcome.fe_plan, outcome.run.strike
    if strike is None:
        return outcome
    discretisation, masses, wall = fe_plan.model.discretisation, fe_plan.model.parameters.mass, fe_plan.wall
    spin = nodal_spin(discretisation.scalar, strike.positions, strike.velocities)
    # Nodes on the sides of quadratic elements come after the corner nodes.
    corners = discretisation.cells.max() + 1
    fields = [
        contours.ContourField(name, title, unit, values, of_centre=strike.values[name])
        for name, title, unit, values in (
            ("v_gx", "Velocity v_X", "m/s", strike.velocities[0, :corners]),
            ("v_gy", "Velocity v_Y", "m/s", strike.velocities[1, :corners]),
            ("omega", "Angular velocity", "rad/s", spin),
        )
    ]
    stress = element_fields(fe_plan.model, strike.positions[None])["stress_von_mises"][0]
    fields.append(contours.ContourField("von_mises", "Von Mises stress", "Pa", stress, "element"))
    with progress.announced("Drawing the pictures ..."):
        situation = contours.Situation(
            (strike.positions.T[:corners], discretisation.cells),
            wall=None if wall is None else (wall.points[:, :2], wall.cells_dict["quad"]),
            corner=strike.positions[:, discretisation.corner].tolist(),
            centroid=(strike.positions @ masses / masses.sum()).tolist(),
            scene=fe_plan.case.scene.name,
            time=strike.values["t"],
        )
        try:
            pictures = contours.draw_contours(situation, fields, folder, units, size or contours.SIZE)
        except ImportError as error:
            warnings.warn(f"no pictures are drawn: {error}", stacklevel=2)
            return outcome
    return replace(outcome, pictures=tuple(pictures), pictures_s=time.perf_counter() - began)
