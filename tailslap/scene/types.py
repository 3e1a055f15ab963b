"""Define the values of a scene with unit and bounds."""

import math
import re
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticKnownError

from fem.laws import constraints, materials
from fem.laws.friction import FRICTION_LAWS
from fem.plate import kinds
from fem.registry import Registry
from fem.start import start_kinds
from tailslap.scene.units import Levels as LevelPairs
from tailslap.scene.units import OfStrip, Pair, Quantity

TestLevel = Literal[
    "TL-1", "TL-2", "TL-3", "TL-4", "TL-5", "TL-6",
    "T1", "T2", "T3", "N1", "N2", "H1", "H2", "H3", "H4a", "H4b",
]  # fmt: skip
"""Test levels of MASH, and containment levels of EN 1317-2."""

MAX_ELEMENTS = 4_000_000
"""Largest mesh that fits the memory of a workstation."""

# Bounds lie far outside what is built: within them every number that follows is finite.
Length = Annotated[float, Quantity("a length", "m", '"10 m"', least=1e-6, most=1e6)]
Hitch = Annotated[float, Quantity("a distance behind the front", "m", '"5.6 m"', least=0.0, most=1e6)]
Kingpin = Annotated[
    float, Quantity("a distance behind the front (negative: drawbar)", "m", '"0.9 m"', least=-1e6, most=1e6)
]
Mass = Annotated[float, Quantity("a mass", "kg", '"9979 kg"', least=1e-6, most=1e12)]
Speed = Annotated[float, Quantity("a speed", "m/s", '"56 mph"', least=1e-6, most=1e4)]
Angle = Annotated[float, Quantity("an angle", "rad", '"15 deg"', least=math.radians(1e-4), below=math.pi / 2)]
AngularVelocity = Annotated[
    float,
    Quantity("an angular velocity of the rear towards the wall", "rad/s", "0.707", least=1e-9, most=1e6),
]
Friction = Annotated[float, Quantity("a coefficient of friction", "", "0.47", least=0.0, most=1e3)]
Cornering = Annotated[float, Quantity("a cornering coefficient", "", "6.0", least=0.0, most=1e3)]
Restitution = Annotated[float, Quantity("a coefficient of restitution", "", "0.22", least=0.0, most=1.0)]
Duration = Annotated[float, Quantity("a duration", "s", '"0.1 s"', least=1e-9, most=1e6)]
EndOfImpact = Annotated[float, Quantity("a time", "s", '"1 s"', least=0.05, most=100.0)]
Density = Annotated[float, Quantity("a density", "kg/m^3", "7800", least=1e-6, most=1e9)]
Modulus = Annotated[float, Quantity("a modulus", "Pa", '"200 GPa"', least=1e-3, most=1e18)]
Frequency = Annotated[float, Quantity("a frequency", "Hz", '"8 Hz"', least=1e-6, most=1e9)]
PoissonsRatio = Annotated[float, Quantity("Poisson's ratio", "", "0.3", least=-0.999, most=0.4999)]
Scale = Annotated[float, Quantity("a factor", "", "1.0", least=1e-6, most=1e6)]
Fraction = Annotated[float, Quantity("a fraction", "", "0.9", least=1e-6, most=1.0)]
DampingRatio = Annotated[float, Quantity("a damping ratio", "", "0.1", least=1e-9, most=1.0)]
Viscosity = Annotated[
    float, Quantity("a coefficient of linear bulk viscosity", "", "0.06", least=1e-9, most=10.0)
]
STIFFNESS_BOUNDS = (1e-3, 1e15)
Stiffness = Annotated[
    float, Quantity("a stiffness", "N/m", '"2 MN/m"', least=STIFFNESS_BOUNDS[0], most=STIFFNESS_BOUNDS[1])
]
LayerStiffness = Annotated[
    float, Quantity("a stiffness per length of side", "N/m^2", '"1 MN/m^2"', least=1e-3, most=1e15)
]
Hardening = Annotated[
    float, Quantity("a stiffness", "N/m", '"0.3 MN/m"', least=0.0, most=STIFFNESS_BOUNDS[1])
]
Force = Annotated[float, Quantity("a force", "N", '"100 kN"', least=0.0, most=1e12)]
Height = Annotated[float, Quantity("a height above the ground", "m", '"32 in"', least=0.05, most=20.0)]
Level = Annotated[float, Quantity("a height above the ground", "m", '"0.6 m"', least=0.0, most=20.0)]
SpringDamping = Annotated[float, Quantity("a damping ratio", "", "0.15", least=0.0, most=1.0)]
RollStiffness = Annotated[
    float, Quantity("a stiffness in roll", "N m/rad", '"3.55 MN m/rad"', least=0.0, most=1e12)
]


def _of_strip(
    what: str, units: tuple[str, str], examples: tuple[str, str], least: float, most: float
) -> OfStrip:
    """Return a quantity of a strip.

    units, examples: per length, and of a point.
    """
    of_point = Quantity(f"{what} of a point", units[1], examples[1], least=least, most=most)
    return OfStrip(
        f"{what} per length of strip", units[0], examples[0], least=least, most=most, of_point=of_point
    )


StripStiffness = Annotated[
    float, _of_strip("a stiffness", ("N/m^2", "N/m"), ('"4 MN/m^2"', '"2 MN/m"'), *STIFFNESS_BOUNDS)
]
StripHardening = Annotated[
    float,
    _of_strip("a stiffness", ("N/m^2", "N/m"), ('"0.3 MN/m^2"', '"0.3 MN/m"'), 0.0, STIFFNESS_BOUNDS[1]),
]
StripForce = Annotated[float, _of_strip("a force", ("N/m", "N"), ('"50 kN/m"', '"50 kN"'), 0.0, 1e12)]
StripPlateau = Annotated[float, _of_strip("a force", ("N/m", "N"), ('"700 kN/m"', '"350 kN"'), 1e-3, 1e12)]
Inertia = Annotated[
    float, Quantity("a moment of inertia", "kg m^2", '"88101 kg m^2"', least=1e-12, most=1e15)
]
Rate = Annotated[float, Quantity("a rate", "1/s", '"100 1/s"', least=1e-9, most=1e12)]
Tolerance = Annotated[float, Quantity("a relative tolerance", "", "1e-3", least=1e-15, below=1.0)]
Distortion = Annotated[float, Quantity("a fraction of the element size", "", "0.2", least=0.0, most=0.3)]

Moment = Annotated[float, Quantity("a bending moment", "N m", '"50 kN m"', least=1.0, most=1e12)]
BeamMoment = Annotated[float, Quantity("a bending moment", "N m", '"20 kN m"', least=0.0, most=1e12)]
LineMoment = Annotated[
    tuple[tuple[float, float], ...],
    LevelPairs("a bending moment per length", "N", '"70 kN"', least=1.0, most=1e12),
]
Thickness = Annotated[
    tuple[tuple[float, float], ...], LevelPairs("a thickness", "m", '"0.3 m"', least=0.01, most=20.0)
]
Bars = Annotated[
    tuple[float, float], Pair("an area of bars per length", "m", '"650 mm^2/m"', least=1e-7, most=1.0)
]


def _registered(registry: Registry[Any]) -> BeforeValidator:
    """Return a validator that accepts the present names of a registry."""

    def name(value: object) -> object:
        if not isinstance(value, str) or value not in registry:
            raise PydanticKnownError("literal_error", {"expected": registry.expected})
        return value

    return BeforeValidator(name)


def _element_counts(value: object) -> object:
    """Return two element counts as a tuple.

    Raises ValueError for other values.
    """
    allowed = f"allowed are two whole numbers from 1, at most {MAX_ELEMENTS} elements in all, like [20, 6]"
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError(allowed)
    if any(type(n) is not int or n < 1 for n in value) or value[0] * value[1] > MAX_ELEMENTS:
        raise ValueError(allowed)
    return tuple(value)


def _profile(value: object) -> object:
    """Return a profile by name or points as tuples.

    Raises ValueError for other values.
    """
    from solver.conditions import RigidBodyError
    from solver.space.wall import profile_points

    try:
        points = profile_points(value)  # type: ignore[arg-type]  # any value of a file
    except RigidBodyError as error:
        raise ValueError(f"{error.why}; allowed: {error.allowed}") from None
    return value if isinstance(value, str) else tuple(map(tuple, points.tolist()))


StartName = Annotated[str, _registered(start_kinds.START_KINDS)]
ReactionName = Annotated[str, _registered(FRICTION_LAWS)]
ConstraintName = Annotated[str, _registered(constraints.CONSTRAINTS)]
ElementName = Annotated[str, _registered(kinds.ELEMENT_KINDS)]
LumpingName = Annotated[str, _registered(kinds.LUMPINGS)]
MaterialName = Annotated[str, _registered(materials.MATERIALS)]
ElementCounts = Annotated[tuple[int, int], BeforeValidator(_element_counts)]
Places = Annotated[
    tuple[float, float], Pair("a distance behind the front", "m", '"2 m"', least=0.0, most=1e6)
]
Levels = Annotated[
    tuple[float, float], Pair("a height above the ground", "m", '"0.9 m"', least=0.0, most=20.0)
]
Profile = Annotated[str | tuple[tuple[float, float], ...], BeforeValidator(_profile)]


def _flag(value: object) -> object:
    """Return a truth value.

    Raises ValueError for numbers and texts.
    """
    if not isinstance(value, bool):
        raise ValueError("allowed is true or false")
    return value


def _name(value: object) -> object:
    """Return a name that is safe as that of a folder.

    Results are written to results/NAME: "..", slashes and hidden files are refused.
    """
    if not isinstance(value, str) or not re.fullmatch(r"[\w+-][\w.+-]{0,79}", value):
        raise ValueError('allowed are 1 to 80 letters, digits and "_", "+", "-", ".", no "." in front')
    return value


Name = Annotated[str, BeforeValidator(_name)]
Flag = Annotated[bool, BeforeValidator(_flag)]
UnitNumber = Annotated[int, Field(ge=1, le=8, strict=True)]


def needed(meaning: str) -> Any:
    """Return a required key of a table with its meaning."""
    return Field(description=meaning)


def key(meaning: str, default: Any = None) -> Any:
    """Return an optional key of a table with its meaning."""
    return Field(default, description=meaning)


class SceneTable(BaseModel):
    """Table of a scene that refuses unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
