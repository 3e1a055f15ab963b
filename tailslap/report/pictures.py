"""Contour pictures of the plate at the tail-slap."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from postprocess.fields.contours import ContourField, Situation, draw_contours
from postprocess.report.units import SI, Units
from tailslap.progress import announced
from tailslap.scene_run import Outcome


def draw_pictures(outcome: Outcome, folder: Path, units: Units = SI) -> Outcome:
    """The outcome with contour pictures of the plate at the tail-slap, in these units; as it is where it was not
    reached."""
    from fem.plate.elements import nodal_spin

    began, fe_plan, strike = time.perf_counter(), outcome.fe_plan, outcome.run.strike
    if strike is None:
        return outcome
    discretisation, masses, wall = fe_plan.model.discretisation, fe_plan.model.loop.mass, fe_plan.wall
    spin = nodal_spin(discretisation.scalar, strike.positions, strike.velocities)
    drawn = (
        discretisation.cells.max() + 1
    )  # corner nodes; those on the sides of quadratic elements come after
    fields = [
        ContourField("v_gx", "Velocity v_X", "m/s", strike.velocities[0, :drawn]),
        ContourField("v_gy", "Velocity v_Y", "m/s", strike.velocities[1, :drawn]),
        ContourField("omega", "Angular velocity", "rad/s", spin),
    ]
    with announced("Drawing the pictures ..."):
        situation = Situation(
            (strike.positions.T[:drawn], discretisation.cells),
            wall=None if wall is None else (wall.points[:, :2], wall.cells_dict["quad"]),
            corner=strike.positions[:, discretisation.corner].tolist(),
            centroid=(strike.positions @ masses / masses.sum()).tolist(),
            scene=fe_plan.case.scene.name,
            time=strike.values["t"],
        )
        pictures = draw_contours(situation, fields, folder, units)
    return replace(outcome, pictures=tuple(pictures), pictures_s=time.perf_counter() - began)
