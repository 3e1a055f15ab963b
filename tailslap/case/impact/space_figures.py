"""Figures of a vehicle in space: its geometry for the drawings, charts and the animation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from postprocess.figures import space as drawings
from postprocess.figures.animation import write_animation
from postprocess.signals import filters
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units
from solver.space.wall import face_at, profile_points
from tailslap import progress

if TYPE_CHECKING:
    from tailslap.case.impact.space import SpaceAnswer

TALL = (720, 430)
"""Size of the animation [pixels]."""

OVER_CENTRE = 1.6
"""Assumed top of a body over the height of its centre of mass, where no strip is higher."""

FILM = (
    "Vehicle from behind and from above, which moves with the vehicle, and lateral force, ten times slower than the "
    "vehicle"
)


def geometry(answer: SpaceAnswer) -> drawings.Vehicle:
    """Return vehicle and wall of an answer for its drawings."""
    vehicle, wall = answer.inputs.vehicle, answer.inputs.wall
    strips = tuple(
        drawings.Strip(strip.unit, strip.axle, _pair(strip.at), _pair(strip.height), float(strip.inset))
        for strip in vehicle.strips
    )
    units = []
    for number, unit in enumerate(vehicle.units):
        heights = [height for strip in strips if strip.unit == number for height in strip.height]
        own = [
            height for strip in strips if strip.unit == number and strip.axle < 0 for height in strip.height
        ]
        centre = float(unit.centre_height)
        low, top = min(own, default=0.5 * centre), max([*heights, OVER_CENTRE * centre])
        sizes = (float(value) for value in (unit.length, unit.width, unit.mass, unit.centre_of_mass))
        units.append(drawings.Unit(*sizes, centre, low, top))
    names = drawings.Axle._fields[1:]
    axles = tuple(
        drawings.Axle(axle.unit, *(float(getattr(axle, name)) for name in names)) for axle in vehicle.axles
    )
    points, top = profile_points(wall.profile), float(wall.height)
    face = np.array([*points[points[:, 1] < top], (float(face_at(points, top)), top)])
    return drawings.Vehicle(tuple(units), axles, strips, face)


def _pair(ends: tuple[object, ...]) -> tuple[float, float]:
    """Return two floats."""
    start, end = (float(value) for value in ends)  # type: ignore[arg-type]  # floats of one motion
    return start, end


def charts(answer: SpaceAnswer) -> list[Chart]:
    """Return the charts of the section on the vehicle in space."""
    vehicle, one, h = geometry(answer), answer.motion.answers, answer.motion.history
    row = int(np.argmin(np.abs(h["t"] - one.roll_time)))
    resultant = drawings.Resultant(float(one.mean_50ms), float(one.height))
    interval, name = float(h["t"][1]), "mean_50ms"
    force, moment = (
        filters.force_curves(h[column][1:], interval, (name,))[name]
        for column in ("force_normal", "moment_height")
    )
    heights = {
        "wall": float(answer.inputs.wall.height),
        "G at rest": float(answer.inputs.vehicle.units[0].centre_height),
    }
    lifts = [
        drawings.Lift(lift["axle"] - 1, lift["side"], lift["start"], lift["start"] + lift["duration"])
        for lift in answer.lifted
    ]
    return [
        drawings.draw_elevation(vehicle, h, row, resultant),
        drawings.draw_plan(vehicle, h, row),
        drawings.draw_force_height(h["t"][1:], force, moment, heights),
        drawings.draw_angles(vehicle, h, lifts),
    ]


def animation(
    answer: SpaceAnswer, folder: Path, units: Units = SI, size: tuple[int, int] | None = None
) -> Path:
    """Write the motion in space as a GIF.

    units: of the axes; size [pixels].
    """
    h, vehicle = answer.motion.history, geometry(answer)
    with progress.announced("Drawing the animation in space ..."):
        views = drawings.film_views(vehicle, h)
        return write_animation(folder / "space.gif", h["t"], views, h["force_normal"], units, size or TALL)
