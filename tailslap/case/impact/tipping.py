"""Tipping over the wall in a whole impact.

Roll of the vehicle, lowest wall that retains it, margins, limits of the model.
"""

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
"""Assumed radius of gyration in roll over the width, where the scene has no roll inertia."""

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
    """Roll of a vehicle by the force of one model.

    Attributes
    ----------
    settings : Tipping
        Table [tipping] of the scene.
    vehicle : RollingVehicle
        Body that rolls.
    motion : RollMotion
        Its motion.
    lowest_wall, highest_centre : float
        Lowest wall that retains the vehicle, and highest centre of mass that the wall retains [m].
    lost_mass : float
        Reduction of the contact's effective mass by the roll, over that mass [-].
    units : tuple of TippingAnswer
        Of a train, the roll of each unit by the force on it; this is the one that needs the highest wall.
    """

    settings: Tipping
    vehicle: tipping.RollingVehicle
    motion: tipping.RollMotion
    lowest_wall: float
    highest_centre: float
    lost_mass: float
    units: "tuple[TippingAnswer, ...]" = ()

    def numbers(self) -> dict[str, Any]:
        """Return the part of `summary.json`, SI.

        Wheels are "near" the wall or "far" from it.
        """
        lifted = self.motion.lifted()
        units = {"units": [unit.numbers() for unit in self.units]} if self.units else {}
        return units | {
            "tips": self.motion.tips,
            "largest_roll": self.motion.largest_roll,
            "lowest_safe_wall": self.lowest_wall,
            "wall_margin": self.settings.wall_height - self.lowest_wall,
            "highest_safe_centre": self.highest_centre,
            "centre_margin": self.highest_centre - float(self.vehicle.centre_height),
            "lifted": [{"wheels": side, "start": a, "duration": b - a} for side, a, b in lifted],
            "effective_mass_change": -self.lost_mass,
            "step": self.motion.step,
            "error": self.motion.error,
        }

    @property
    def verdict(self) -> str:
        """Sentence on whether the wall retains the vehicle."""
        heights = self.settings.wall_height, self.lowest_wall
        wall, lowest = (f"{measure(height, 'm', '.3f')} ({height / INCH:.1f} in)" for height in heights)
        if self.vehicle.centre_height <= self.settings.wall_height:
            return f"The vehicle cannot tip over this wall: its centre of mass is below the top of the wall, {wall}."
        roll = measure(self.motion.largest_roll, "rad", ".1f")
        said = f"The wall of {wall} retains the vehicle with a roll of {roll}"
        if self.motion.tips:
            said = f"The vehicle tips over the wall of {wall}"
        return f"{said}; lowest wall that retains it: {lowest}."

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences on margins, wheels and force."""
        numbers = self.numbers()
        wall, centre = (measure(numbers[f"{name}_margin"], "m", "+.3f") for name in ("wall", "centre"))
        lifted = (
            f"{x['wheels']} side's from {x['start']:.3f} s for {x['duration']:.3f} s"
            for x in numbers["lifted"]
        )
        return (
            f"Margin of the wall height {wall}, of the height of the centre of mass {centre}.",
            f"Wheels lifted: {', '.join(lifted) or 'none'}.",
            f"The force is that of the planar motion. Roll would reduce the effective mass of the contact by "
            f"{100.0 * self.lost_mass:.1f} %, and the impulse by at most as much.",
        )

    def text(self, units: str) -> list[str]:
        """Return lines for a terminal without the verdict."""
        return [TITLE, *(f"  {SYSTEMS[units].rendered(said)}" for said in self.sentences)]


def solve(scene: Scene, bodies: Sequence[ImpactVehicle], answer: ImpactAnswer) -> TippingAnswer:
    """Compute the roll of each unit by the forces of one model.

    Units roll independently: the moment in a fifth wheel depends on its play, which is unknown. It would restrain the
    unit that rolls more, and rotate the other. Raises RigidBodyError for springs that are too stiff.
    """
    numbers = (
        [f"force_normal_{unit}" for unit in range(1, len(bodies) + 1)] if scene.trailer else ["force_normal"]
    )
    both = zip(scene.units, bodies, numbers, strict=True)
    rolls = [
        _rolled(scene, unit, body, answer.history[name][1:], answer.interval) for unit, body, name in both
    ]
    worst = max(rolls, key=lambda roll: roll.lowest_wall)
    return replace(worst, units=tuple(rolls)) if scene.trailer else worst


def _rolled(
    scene: Scene, unit: Vehicle, body: ImpactVehicle, force: np.ndarray, interval: float
) -> TippingAnswer:
    settings = scene.tipping
    assert settings
    vehicle = rolling_vehicle(scene, settings, unit)
    motion = tipping.solve_roll(vehicle, settings.wall_height, force, interval, on_compile=progress.compiling)
    lowest = float(tipping.lowest_walls(vehicle, force, interval))
    highest = float(tipping.highest_centres(vehicle, settings.wall_height, force, interval))
    return TippingAnswer(settings, vehicle, motion, lowest, highest, lost_mass(scene, body, vehicle))


def rolling_vehicle(scene: Scene, settings: Tipping, unit: Vehicle) -> tipping.RollingVehicle:
    """Return a unit of the scene as a rolling vehicle.

    Values that a trailer does not have are those of [tipping].
    """
    values, impact = unit if isinstance(unit, Trailer) else settings, scene.impact
    assert impact
    inertia = values.roll_inertia or unit.mass * (GYRATION * unit.width) ** 2
    heights = values.centre_height or settings.centre_height, inertia
    wheels = values.track or settings.track, values.suspension or settings.suspension, settings.damping_ratio
    along = impact.speed * math.cos(impact.angle)
    return tipping.RollingVehicle(unit.mass, *heights, *wheels, unit.width, settings.friction, along)


def lost_mass(scene: Scene, body: ImpactVehicle, vehicle: tipping.RollingVehicle) -> float:
    """Return the relative reduction of the effective mass by the roll.

    It is that of the front corner at first touch, by the last term of
    1/m_eff = 1/m + X (X - mu |Y|)/I_yaw + (z - h)^2/I.
    """
    impact, settings, friction = scene.impact, scene.tipping, scene.needed_contact.friction
    assert impact
    assert settings
    s, c, half = math.sin(impact.angle), math.cos(impact.angle), 0.5 * body.width
    x, y = body.front_distance * c - half * s, body.front_distance * s + half * c
    planar = 1.0 / body.mass + x * (x - friction * y) / body.inertia
    roll = (vehicle.centre_height - settings.wall_height) ** 2 / vehicle.roll_inertia
    return float(roll / (planar + roll))


def section(answers: Mapping[str, TippingAnswer]) -> Section:
    """Return the section of a page.

    answers: of each model by its name; the first is drawn.
    """
    from postprocess.figures import tipping as figures

    rolls, rows = {}, []
    for name, answer in answers.items():
        numbers, history = answer.numbers(), dict(zip(tipping.ROW, answer.motion.rows.T, strict=True))
        t = answer.motion.interval * np.arange(len(answer.motion.rows), dtype=np.float64)
        rolls[name] = figures.Roll(t, history["roll"], history["load_near"], history["load_far"])
        far = math.fsum(lift["duration"] for lift in numbers["lifted"] if lift["wheels"] == "far")
        rows.append({"force": name, "far_lifted": far, **numbers})
    first = next(iter(answers.values()))
    height, roll = max(first.motion.rows[:, :2].tolist(), key=lambda row: row[1])
    settings, width = first.settings, float(first.vehicle.width)
    shape = figures.Leaning(
        width, float(first.vehicle.track), float(first.vehicle.centre_height), settings.wall_height
    )
    drawn = figures.draw_roll(rolls), figures.draw_leaning(shape, height, roll)
    step, error = f"{first.motion.step:.1e} s", f"{first.motion.error:.1e}"
    said = f"Steps of {step}; with twice the step the largest roll changes by {error} (relative)."
    tables = Table(ROWS, rows, notes=(TIPPED,)), Table(LIMIT_COLUMNS, LIMITS)
    return Section(TITLE, "", drawn, tables, (*first.sentences, said), "wide")
