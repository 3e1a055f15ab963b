"""Figures of a constrained corner: curves of the histories, and contour pictures of the plate at the tail-slap."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from fem.explicit.columns import COLUMNS
from fem.plate.discretisation import nodal_spin
from postprocess.fields import contours
from postprocess.figures.histories import Panel, draw_histories
from postprocess.figures.positions import draw_positions, vehicle_outlines
from postprocess.report.page import Picture, Section
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units
from tailslap import progress
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.run_report import element_fields

CAPTIONS = {
    "contour_v_gx": "Velocity along the wall at the tail-slap (the paper's Figure 15).",
    "contour_v_gy": "Velocity across the wall at the tail-slap (the paper's Figure 16).",
    "contour_omega": "Angular velocity, half the curl of the velocity, at the tail-slap (the paper's Figure 17).",
    "contour_von_mises": "Von Mises stress of the plate at the tail-slap.",
}


def curves(outcome: CornerOutcome) -> list[Section]:
    """Curves of all histories, those of the columns that bring a plot of their own among them."""
    own = [(name, column) for name, column in COLUMNS.items() if column.symbol]
    title = "Further columns"
    further = tuple(Panel(name, ((name, name),), c.symbol, c.unit, title, c.caption) for name, c in own)
    drawn = draw_histories(outcome.fe_history, outcome.rigid_history, further)
    groups = dict.fromkeys(curve.group for curve in drawn)
    layouts = {"Motion": "wide", "Reaction": "wide"}
    return [
        Section("Positions along the wall", figures=positions(outcome), layout="tall"),
        *(
            Section(group, figures=[c for c in drawn if c.group == group], layout=layouts.get(group, ""))
            for group in groups
        ),
    ]


INSTANTS = 5
"""Positions of the vehicle that are drawn."""


def positions(outcome: CornerOutcome) -> list[Chart]:
    """Draw the vehicle at even instants, and how it moves until the tail-slap; nothing for a run that has no rows."""
    vehicle, h = outcome.fe_plan.case.scene.vehicle, outcome.fe_history
    known = np.isfinite(h["theta"]) & np.isfinite(h["slide"])
    t, theta, slide = (h[name][known] for name in ("t", "theta", "slide"))
    if t.size < 2:
        return []
    ahead, aside = 0.5 * vehicle.length, 0.5 * vehicle.width
    x = slide - ahead * np.cos(theta) + aside * np.sin(theta)
    y = ahead * np.sin(theta) + aside * np.cos(theta)
    every = vehicle_outlines(x, y, theta, vehicle.length, vehicle.width, ahead)
    shown = np.unique(np.linspace(0, t.size - 1, INSTANTS).astype(int))
    return [draw_positions(every[shown], t[shown], motion=(t, every))]


def draw_pictures(
    outcome: CornerOutcome, folder: Path, units: Units = SI, size: contours.Size | None = None
) -> CornerOutcome:
    """The outcome with contour pictures of the plate at the tail-slap, in these units and of this size [pixels]; as it
    is where it was not reached."""
    began, fe_plan, strike = time.perf_counter(), outcome.fe_plan, outcome.run.strike
    if strike is None:
        return outcome
    discretisation, masses, wall = fe_plan.model.discretisation, fe_plan.model.loop.mass, fe_plan.wall
    spin = nodal_spin(discretisation.scalar, strike.positions, strike.velocities)
    # Corner nodes; those on the sides of quadratic elements come after.
    drawn = discretisation.cells.max() + 1
    fields = [
        contours.ContourField(name, title, unit, values, of_centre=strike.values[name])
        for name, title, unit, values in (
            ("v_gx", "Velocity v_X", "m/s", strike.velocities[0, :drawn]),
            ("v_gy", "Velocity v_Y", "m/s", strike.velocities[1, :drawn]),
            ("omega", "Angular velocity", "rad/s", spin),
        )
    ]
    stress = element_fields(fe_plan.model, strike.positions[None])["stress_von_mises"][0]
    fields.append(contours.ContourField("von_mises", "Von Mises stress", "Pa", stress, "element"))
    with progress.announced("Drawing the pictures ..."):
        situation = contours.Situation(
            (strike.positions.T[:drawn], discretisation.cells),
            wall=None if wall is None else (wall.points[:, :2], wall.cells_dict["quad"]),
            corner=strike.positions[:, discretisation.corner].tolist(),
            centroid=(strike.positions @ masses / masses.sum()).tolist(),
            scene=fe_plan.case.scene.name,
            time=strike.values["t"],
        )
        pictures = contours.draw_contours(situation, fields, folder, units, size or contours.SIZE)
    return replace(outcome, pictures=tuple(pictures), pictures_s=time.perf_counter() - began)


def shown_pictures(outcome: CornerOutcome) -> list[Picture]:
    """The pictures with their captions."""
    return [Picture(path, CAPTIONS[path.stem]) for path in outcome.pictures]
