"""Strips of plates that crush at their corners, and a truck."""

import math

from fem.laws.contact_forces import PointCrush
from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.model.plate_model import PlateModel
from fem.plate.properties import (
    ContactProperties,
    Inertia,
    PlateProperties,
    StepProperties,
    StripProperties,
    UnitProperties,
    WallProperties,
)
from fem.run.impact import FirstTouch
from meshes import plate_mesh

MASS, ANGLE, SPEED = 9979.0, math.radians(15.0), 25.034
TOUCH = FirstTouch(ANGLE, SPEED * math.cos(ANGLE), -SPEED * math.sin(ANGLE))
"""First touch of the truck of the paper's Table 1."""


def corner_strips(
    length: float,
    stiffness: float,
    initial_force: float = 0.0,
    restitution: float = 1.0,
    plateau_force: float = math.inf,
    unloading_stiffness: float = 0.0,
    hardening: float = 0.0,
) -> tuple[StripProperties, StripProperties]:
    """Return front and rear of a plate, both by one law.

    length: of the plate [m].
    """
    crush = PointCrush(
        stiffness, initial_force, restitution**2, plateau_force, unloading_stiffness, hardening
    )
    return StripProperties(0.0, 0.0, 0.0, crush), StripProperties(length, length, 0.0, crush)


def layer(length: float, stiffness: float, restitution: float) -> StripProperties:
    """Return a line over a length from the front.

    length [m], stiffness [N/m per m].
    """
    return StripProperties(0.0, length, 0.0, PointCrush(stiffness, 0.0, restitution**2, math.inf, 0.0, 0.0))


def truck_model(
    law: str = "crush",
    elements: tuple[int, int] = (20, 6),
    modulus: float = 200e9,
    inertia: Inertia | None = None,
    longest: float = 1e-4,
    layered: float = 0.0,
    patch_length: float = 0.0,
    wall: WallProperties | None = None,
) -> PlateModel:
    """Return the truck of Table 1 as a plate of steel.

    layered: stiffness of a layer along its sides [N/m per m].
    """
    plate = PlateProperties(0.053, MASS / (10.0 * 2.438 * 0.053), modulus, 0.3, inertia=inertia)
    strips = corner_strips(10.0, 2e6, restitution=0.22) if law == "crush" else ()
    sides = (layer(10.0, layered, 0.22),) if layered else ()
    contact = ContactProperties(Drag(0.47), law, strips + sides, patch_length=patch_length)
    unit = UnitProperties(plate_mesh(10.0, 2.438, elements), plate, contact)
    return build_impact_model([unit], StepProperties(longest=longest), wall)
