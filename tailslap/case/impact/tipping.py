"""Tipping over the wall: roll of the vehicle of a whole impact, the lowest wall that holds it, margins, limits."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from postprocess.report.page import Section
from postprocess.report.tables import Column, Table, columns
from postprocess.units import SYSTEMS, measure
from solver import tipping
from solver.impact import ImpactVehicle
from tailslap import progress
from tailslap.case.impact.answers import ImpactAnswer
from tailslap.scene.schema import Scene, Tipping, Trailer, Vehicle

TITLE, INCH = "Tipping over the wall", 0.0254

GYRATION = 0.45
"""Radius of gyration in roll, over the width, where the scene leaves the roll inertia out: assumed."""

ROWS = (
    Column("force", "Force by"),
    Column("tips", "Tips"),
    Column("largest_roll", "Largest roll", "rad", form=".2f", style="strong"),
    *columns(
        {"lowest_safe_wall": "Lowest wall", "wall_margin": "Margin"},
        unit="m",
        form=".3f",
        group="Wall that retains it",
    ),
    *columns(
        {"highest_safe_centre": "Highest centre", "centre_margin": "Margin"},
        unit="m",
        form=".3f",
        group="Centre retained",
    ),
    Column("far_lifted", "Far wheels lifted", "s", form=".2f"),
)

TIPPED = (
    "A vehicle tips when its centre of mass is beyond the wheels at the wall and roll continues; its largest roll is "
    "then given as 90 deg."
)

LIMITS: Sequence[tuple[str, ...]] = (
    ("force below the top of the wall", "longer lever arm", "+"),
    ("lateral grip of the tyres", "retains the wheels while the vehicle approaches the wall", "+"),
    ("twist of the frame", "the box rolls more than its axles, which lift one after the other", "+"),
    ("separation of box and frame", "the box rolls more, the chassis less", "±"),
    ("shift of the cargo", "displaces the centre of mass towards the wall", "+"),
    ("lateral flexibility and play of the suspension", "additional roll", "+"),
    ("pitch", "absorbs part of the moment of a strike at one end", "−"),
    ("roll flexibility at the contact", "reduces the force", "−"),
)
"""Omitted parts of the model, their effects, and the sign of the change of roll."""

LIMIT_COLUMNS = columns({"0": "Omitted", "1": "Effect", "2": "Roll"})


@dataclass(frozen=True)
class TippingAnswer:
    """Roll of a vehicle by the force of one of both models.

    Attributes
    ----------
    given : Tipping
        The scene's.
    vehicle : RollingVehicle
        What rolls.
    motion : RollMotion
        Its motion.
    lowest_wall, highest_centre : float
        Lowest wall that holds the vehicle, and highest centre of mass that the wall holds [m].
    lost_mass : float
        What the roll would take off the contact's effective mass, over that mass [-].
    units : tuple of TippingAnswer
        Of a train, the roll of each unit by the force on it; this is the one that needs the highest wall.
    """

    given: Tipping
    vehicle: tipping.RollingVehicle
    motion: tipping.RollMotion
    lowest_wall: float
    highest_centre: float
    lost_mass: float
    units: "tuple[TippingAnswer, ...]" = ()

    def numbers(self) -> dict[str, Any]:
        """Part of `summary.json`, SI; wheels are those "near" the wall and "far" from it."""
        lifted = self.motion.lifted()
        each = {"units": [unit.numbers() for unit in self.units]} if self.units else {}
        return each | {
            "tips": self.motion.tips,
            "largest_roll": self.motion.largest_roll,
            "lowest_safe_wall": self.lowest_wall,
            "wall_margin": self.given.wall_height - self.lowest_wall,
            "highest_safe_centre": self.highest_centre,
            "centre_margin": self.highest_centre - float(self.vehicle.centre_height),
            "lifted": [{"wheels": side, "start": a, "duration": b - a} for side, a, b in lifted],
            "effective_mass_change": -self.lost_mass,
            "step": self.motion.step,
            "error": self.motion.error,
        }

    @property
    def verdict(self) -> str:
        """Say whether the wall holds the vehicle, and which one would."""
        heights = self.given.wall_height, self.lowest_wall
        wall, lowest = (f"{measure(height, 'm', '.3f')} ({height / INCH:.1f} in)" for height in heights)
        if self.vehicle.centre_height <= self.given.wall_height:
            return f"The vehicle cannot tip over this wall: its centre of mass is below the top of the wall, {wall}."
        roll = measure(self.motion.largest_roll, "rad", ".1f")
        said = f"The wall of {wall} retains the vehicle with a roll of {roll}"
        if self.motion.tips:
            said = f"The vehicle tips over the wall of {wall}"
        return f"{said}; lowest wall that retains it: {lowest}."

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences on margins, wheels, the force and the error."""
        found = self.numbers()
        wall, centre = (measure(found[f"{name}_margin"], "m", "+.3f") for name in ("wall", "centre"))
        lifted = (
            f"{x['wheels']} side's from {x['start']:.3f} s for {x['duration']:.3f} s" for x in found["lifted"]
        )
        return (
            f"Margin of the wall height {wall}, of the height of the centre of mass {centre}.",
            f"Wheels lifted: {', '.join(lifted) or 'none'}.",
            f"The force is that of the planar motion. Roll would reduce the effective mass of the contact by "
            f"{100.0 * self.lost_mass:.1f} %, and the impulse by at most as much.",
        )

    def text(self, units: str) -> list[str]:
        """Lines for a terminal, without the verdict."""
        return [TITLE, *(f"  {SYSTEMS[units].rendered(said)}" for said in self.sentences)]


def solve(scene: Scene, bodies: Sequence[ImpactVehicle], answer: ImpactAnswer) -> TippingAnswer:
    """Roll of a scene's vehicle, or of each unit of a train, by the forces of one of both models.

    Units roll by themselves: what a fifth wheel carries depends on its play, which is not known. It would hold the unit
    that rolls more, and turn the other. Raises RigidBodyError for springs that are too stiff.
    """
    numbers = (
        [f"force_normal_{unit}" for unit in range(1, len(bodies) + 1)] if scene.trailer else ["force_normal"]
    )
    both = zip(scene.units, bodies, numbers, strict=True)
    found = [
        _rolled(scene, unit, body, answer.history[name][1:], answer.interval) for unit, body, name in both
    ]
    worst = max(found, key=lambda each: each.lowest_wall)
    return replace(worst, units=tuple(found)) if scene.trailer else worst


def _rolled(
    scene: Scene, unit: Vehicle, body: ImpactVehicle, force: np.ndarray, interval: float
) -> TippingAnswer:
    given = scene.tipping
    assert given
    vehicle = rolling_vehicle(scene, given, unit)
    motion = tipping.solve_roll(vehicle, given.wall_height, force, interval, on_compile=progress.compiling)
    lowest = float(tipping.lowest_walls(vehicle, force, interval))
    highest = float(tipping.highest_centres(vehicle, given.wall_height, force, interval))
    return TippingAnswer(given, vehicle, motion, lowest, highest, lost_mass(scene, body, vehicle))


def rolling_vehicle(scene: Scene, given: Tipping, unit: Vehicle) -> tipping.RollingVehicle:
    """A unit of the scene as it rolls; what a trailer leaves out is tipping's."""
    own, impact = unit if isinstance(unit, Trailer) else given, scene.impact
    assert impact
    inertia = own.roll_inertia or unit.mass * (GYRATION * unit.width) ** 2
    heights = own.centre_height or given.centre_height, inertia
    wheels = own.track or given.track, own.suspension or given.suspension, given.damping_ratio
    along = impact.speed * math.cos(impact.angle)
    return tipping.RollingVehicle(unit.mass, *heights, *wheels, unit.width, given.friction, along)


def lost_mass(scene: Scene, body: ImpactVehicle, vehicle: tipping.RollingVehicle) -> float:
    """Fraction that the roll would take off the effective mass of the front corner at first touch, which is the last
    term's of 1/m_eff = 1/m + X (X - mu |Y|)/I_yaw + (z - h)^2/I."""
    impact, given, friction = scene.impact, scene.tipping, scene.needed_contact.friction
    assert impact
    assert given
    s, c, half = math.sin(impact.angle), math.cos(impact.angle), 0.5 * body.width
    x, y = body.front_distance * c - half * s, body.front_distance * s + half * c
    planar = 1.0 / body.mass + x * (x - friction * y) / body.inertia
    roll = (vehicle.centre_height - given.wall_height) ** 2 / vehicle.roll_inertia
    return float(roll / (planar + roll))


def section(answers: Mapping[str, TippingAnswer]) -> Section:
    """The section of a page, of what each model answers, by its name; the first is drawn."""
    from postprocess.figures import tipping as figures

    rolls, rows = {}, []
    for name, each in answers.items():
        found, history = each.numbers(), dict(zip(tipping.ROW, each.motion.rows.T, strict=True))
        t = each.motion.interval * np.arange(len(each.motion.rows), dtype=np.float64)
        rolls[name] = figures.Roll(t, history["roll"], history["load_near"], history["load_far"])
        far = math.fsum(its["duration"] for its in found["lifted"] if its["wheels"] == "far")
        rows.append({"force": name, "far_lifted": far, **found})
    first = next(iter(answers.values()))
    height, roll = max(first.motion.rows[:, :2].tolist(), key=lambda row: row[1])
    given, width = first.given, float(first.vehicle.width)
    shape = figures.Leaning(
        width, float(first.vehicle.track), float(first.vehicle.centre_height), given.wall_height
    )
    drawn = figures.draw_roll(rolls), figures.draw_leaning(shape, height, roll)
    step, error = f"{first.motion.step:.1e} s", f"{first.motion.error:.1e}"
    said = f"Steps of {step}; with twice the step the largest roll changes by {error} (relative)."
    tables = Table(ROWS, rows, notes=(TIPPED,)), Table(LIMIT_COLUMNS, LIMITS)
    return Section(TITLE, "", drawn, tables, (*first.sentences, said), "wide")
