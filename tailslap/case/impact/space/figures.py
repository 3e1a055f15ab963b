"""Figures of a vehicle in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.figures import space as drawings
from postprocess.figures.animation import write_animation
from postprocess.signals import filters
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units
from solver.space import SpaceMotion, SpaceUnit, SpaceVehicle, SpaceWall
from solver.space.wall import face_at, profile_points
from tailslap import progress

TALL = (720, 430)
"""Size of the animation [pixels]."""

OVER_CENTRE = 1.6
"""Assumed top of a body over the height of its centre of mass, where no strip is higher."""


def geometry(vehicle: SpaceVehicle, wall: SpaceWall) -> drawings.DrawnVehicle:
    """Return vehicle and wall for drawings."""
    strips = tuple(
        drawings.DrawnStrip(strip.unit, strip.axle, _pair(strip.at), _pair(strip.height), float(strip.inset))
        for strip in vehicle.strips
    )
    units = tuple(
        _unit(unit, [strip for strip in strips if strip.unit == k]) for k, unit in enumerate(vehicle.units)
    )
    names = drawings.DrawnAxle._fields[1:]
    axles = tuple(
        drawings.DrawnAxle(axle.unit, *(float(getattr(axle, name)) for name in names))
        for axle in vehicle.axles
    )
    points, top = profile_points(wall.profile), float(wall.height)
    face = np.array([*points[points[:, 1] < top], (float(face_at(points, top)), top)])
    return drawings.DrawnVehicle(units, axles, strips, face)


def _unit(unit: SpaceUnit, strips: Sequence[drawings.DrawnStrip]) -> drawings.DrawnUnit:
    """Return a unit to draw, with body edges by its strips."""
    centre = float(unit.centre_height)
    low = min((min(strip.height) for strip in strips if strip.axle < 0), default=0.5 * centre)
    top = max([OVER_CENTRE * centre, *(max(strip.height) for strip in strips)])
    length, width, mass, behind = (
        float(v) for v in (unit.length, unit.width, unit.mass, unit.centre_of_mass)
    )
    return drawings.DrawnUnit(length, width, mass, behind, centre, low, top)


def _pair(ends: tuple[object, ...]) -> tuple[float, float]:
    """Return two floats."""
    start, end = (float(value) for value in ends)  # type: ignore[arg-type]  # floats of one motion
    return start, end


def charts(
    vehicle: SpaceVehicle, wall: SpaceWall, motion: SpaceMotion, lifted: Sequence[Mapping[str, Any]]
) -> list[Chart]:
    """Return the charts of a motion.

    lifted: see `SpaceAnswer.lifted`.
    """
    drawn, one, h = geometry(vehicle, wall), motion.answers, motion.history
    row = int(np.argmin(np.abs(h["t"] - one.roll_time)))
    interval, name = float(h["t"][1]), "mean_50ms"
    force, moment = (
        filters.force_curves(h[column][1:], interval, (name,))[name]
        for column in ("force_normal", "moment_height")
    )
    heights = {"wall": float(wall.height), "G at rest": float(vehicle.units[0].centre_height)}
    return [
        *drawings.draw_films(drawn, h),
        drawings.draw_elevation(drawn, h, row, float(one.mean_50ms), float(one.height)),
        drawings.draw_plan(drawn, h, row),
        drawings.draw_force_height(h["t"], force, moment, heights),
        drawings.draw_angles(drawn, h, lifted),
    ]


def animation(
    vehicle: SpaceVehicle,
    wall: SpaceWall,
    motion: SpaceMotion,
    folder: Path,
    units: Units = SI,
    size: tuple[int, int] | None = None,
) -> Path:
    """Write a motion in space as a GIF.

    units: of the axes; size [pixels].
    """
    h = motion.history
    with progress.announced("Drawing the animation in space ..."):
        views = drawings.film_views(geometry(vehicle, wall), h)
        return write_animation(folder / "space.gif", h["t"], views, h["force_normal"], units, size or TALL)
