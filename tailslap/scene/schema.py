"""Define the keys of a scene with meaning, unit, bounds and default.

Values are in SI after validation; a table that is None is absent from the model.
"""

import math
import re
from types import MappingProxyType
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic.fields import FieldInfo
from pydantic_core import PydanticKnownError

from fem.laws import constraints, materials
from fem.laws.friction import FRICTION_LAWS
from fem.plate import kinds
from fem.registry import Registry
from fem.start import start_kinds
from tailslap.errors import InputError, Missing
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

LISTED = ("trailer", "axle", "strip")
"""Names of lists of tables, [[NAME]]."""


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


class Vehicle(SceneTable):
    """Rigid rectangle that represents the vehicle."""

    length: Length = needed("length from front to rear")
    width: Length = needed("width over the body")
    mass: Mass = needed("mass, load included")
    centre_of_mass: Length | None = key(
        "distance of the centre of mass behind the front, whole impacts only; default: half the length"
    )
    yaw_inertia: Inertia | None = key(
        "yaw moment of inertia about the centre of mass, whole impacts only; default: uniform rectangle"
    )


class Trailer(Vehicle):
    """Trailer of a train, hinged to the unit ahead.

    The hinge lies on the centre lines of both units. Trailers require a whole impact.
    """

    hitch: Hitch = needed(
        "distance of the hinge behind the front of the unit ahead, a tow ball beyond its rear"
    )
    kingpin: Kingpin = needed("distance of the hinge behind the front of the trailer; negative for a drawbar")
    hitch_length: Length | None = key(
        "length of both plates over which the force of the hinge is distributed; default: one node, "
        "or half the vehicle's width if plate.elements is omitted"
    )
    centre_height: Height | None = key("height of the centre of mass; default: body.centre_height")
    roll_inertia: Inertia | None = key("roll moment of inertia about it; default: mass times (0.45 width)^2")
    pitch_inertia: Inertia | None = key("pitch moment of inertia about it; default: the yaw inertia")
    hitch_height: Level | None = key("height of the hinge; required with [body]")
    roll_stiffness: RollStiffness | None = key("stiffness of the hinge in roll; default: 3.55 MN m/rad")


class Impact(SceneTable):
    """First contact between the front corner and the wall.

    In a whole impact, friction and restitution enter only the rigid-body method quoted for comparison.
    """

    speed: Speed = needed("speed before the impact")
    angle: Angle = needed("angle between the side of the vehicle and the wall")
    friction: Friction | None = key(
        "coefficient of friction at the front corner in Stage 1; required without [contact]"
    )
    restitution: Restitution | None = key(
        "coefficient of restitution at the front corner in Stage 1; required without [contact]"
    )
    convention: Literal["paper", "newton"] = key(
        "definition of restitution in Stage 1: factor (1 - e) of the paper, or Newton's (1 + e)", "paper"
    )
    test_level: TestLevel | None = key(
        "level whose design forces are compared with the result: of MASH with those of AASHTO, of EN 1317-2 with the "
        "classes of EN 1991-2"
    )


class StartTable(SceneTable):
    """Initial state of Stage 2.

    Omitted values follow from Stage 1.
    """

    angle: Angle | None = key(
        "initial angle between the side of the vehicle and the wall; default: from Stage 1"
    )
    omega: AngularVelocity | None = key(
        "initial angular velocity, positive as the rear rotates towards the wall; default: from Stage 1"
    )
    corner_speed: Speed | None = key("initial speed of the corner along the wall; default: from Stage 1")


class CornerTable(SceneTable):
    """Constrained corner of Stage 2.

    By default the program selects the constraint.
    """

    reaction: ReactionName = key("friction law of the sliding corner", "drag")
    friction: Friction | None = key("coefficient of friction of the sliding corner; default: impact.friction")
    constraint: ConstraintName = key("constraint of the corner to the wall in the FE model", "penalty")
    penalty_scale: Scale = key("penalty stiffness of the corner, relative to the default stiffness", 1.0)
    damping_ratio: DampingRatio | None = key("damping ratio of the penalty spring")
    patch_length: Length | None = key(
        "length of the side over which the corner is supported; default: one node"
    )

    @property
    def frictionless(self) -> bool:
        """True if the reaction has no friction."""
        return FRICTION_LAWS[self.reaction].frictionless

    @property
    def rigid_reaction(self) -> str:
        """Name of the reaction in the rigid-body theory."""
        return FRICTION_LAWS[self.reaction].rigid

    @property
    def constraint_is_open(self) -> bool:
        """True if the program selects the constraint."""
        return not self.model_fields_set & {"constraint", "penalty_scale", "damping_ratio"}


class Contact(SceneTable):
    """Unilateral contact between vehicle and wall in a whole impact.

    stiffness, initial_force, plateau_force and hardening define the crush law of both corners of each unit without
    [[strip]], F0 + k d up to the plateau and a slope k2 beyond it; restitution or unloading_stiffness its unloading.
    strike_duration may replace stiffness. Without both and without strips the vehicle does not crush; enforcement and
    penalty_scale then apply.
    """

    stiffness: Stiffness | None = key(
        "crush stiffness k of both corners of each unit without [[strip]]; default: no crush"
    )
    strike_duration: Duration | None = key(
        "duration of a strike of the rear corner, which defines the crush stiffness in place of stiffness"
    )
    initial_force: Force = key("crush force F0 at zero crush depth", 0.0)
    plateau_force: Force | None = key(
        "crush force Fy of each corner, from which on it is constant or rises by hardening; default: no plateau"
    )
    hardening: Hardening = key("slope k2 of the crush force beyond the onset of its plateau", 0.0)
    restitution: Restitution | None = key(
        "coefficient of restitution e: unloading returns e^2 of the crush energy, also that of strips without "
        "unloading; required with stiffness, unless unloading_stiffness is given"
    )
    unloading_stiffness: Stiffness | None = key("slope of unloading of each corner, in place of restitution")
    friction: Friction = needed("coefficient of friction between vehicle and wall")
    patch_length: Length | None = key(
        "length of the side over which the force of a corner, or of a point, is distributed; default: one node, "
        "or half the vehicle's width if plate.elements is omitted"
    )
    enforcement: Literal["penalty", "exact"] = key("enforcement of contact without crush", "penalty")
    penalty_scale: Scale = key(
        "penalty stiffness of contact without crush, relative to the default stiffness", 1.0
    )

    @property
    def of_corners(self) -> bool:
        """True with a crush law of corners."""
        return self.stiffness is not None or self.strike_duration is not None


class Axle(SceneTable):
    """Solid axle of a whole impact.

    Its tyres resist sliding across it. With [body] it carries the vehicle on springs and tyres; without [body] its load
    is that of the vehicle at rest.
    """

    position: Hitch = needed("distance of the axle behind the front of its unit")
    friction: Friction = key("coefficient of friction of the tyres on the road; 0 for no side force", 0.0)
    cornering: Cornering = key(
        "cornering coefficient: side force over load and slip angle at small slip", 6.0
    )
    unit: UnitNumber = key("number of the unit of a train that has the axle; 1 for the vehicle", 1)
    track: Length | None = key("distance between the tyres of both sides; required with [body]")
    radius: Height | None = key("height of the axle; required with [body]")
    mass: Mass | None = key("mass of axle and wheels, part of that of the unit; required with [body]")
    spring: Stiffness | None = key("stiffness of the spring of one side; required with [body]")
    spacing: Length | None = key("distance between the springs; required with [body]")
    damping_ratio: SpringDamping | None = key("damping ratio of the springs; default: 0.15, assumed")
    tyre: Stiffness | None = key("vertical stiffness of the tyres of one side; required with [body]")
    roll_centre: Level | None = key("height at which side force enters the body; default: 0.6 m, assumed")


class Body(SceneTable):
    """Vehicle in space.

    It has roll and pitch, and its forces have heights; whole impacts only. Axles carry the vehicle and strips touch the
    wall, whose height [wall] defines.
    """

    centre_height: Height = needed("height of the centre of mass of the vehicle with its axles")
    roll_inertia: Inertia | None = key("roll moment of inertia about it; default: mass times (0.45 width)^2")
    pitch_inertia: Inertia | None = key("pitch moment of inertia about it; default: the yaw inertia")


class Sensor(SceneTable):
    """Accelerometer on the centre line of a single vehicle, whole impacts only.

    Mass times the 50 ms mean of its acceleration away from the wall is the inertial estimate of the force, which crash
    tests publish. Without this table its place is assumed.
    """

    position: Hitch | None = key(
        "distance of the sensor behind the front; default: behind_centre behind the centre of mass"
    )
    behind_centre: Kingpin | None = key(
        "distance of the sensor behind the centre of mass; default: 0.25 m, assumed 0 to 0.5 m"
    )
    height: Level | None = key(
        "height of the sensor, with [body]; default: 0.95 m of a truck's frame, assumed, or that of the centre of mass "
        "if lower"
    )


class StripTable(SceneTable):
    """Point or line of the vehicle that can touch the wall.

    It is on both sides. In the plane it is a point, or a line between two places; with [body] it has heights, and all
    values are per length. Without restitution and unloading_stiffness it unloads by contact.restitution.
    """

    at: Places = needed("distance behind the front of its unit: one, or two of a line along the side")
    height: Levels | None = key(
        "height above the ground, required with [body]: two of an upright strip, or one of a line"
    )
    inset: Level = key("distance inwards from the side", 0.0)
    stiffness: StripStiffness = needed("crush stiffness k per length; of a point in the plane k itself")
    initial_force: StripForce = key("crush force F0 at zero crush depth, as stiffness", 0.0)
    plateau: StripPlateau | None = key(
        "crush force Fy, as stiffness, from which on it is constant or rises by hardening; default: no plateau"
    )
    hardening: StripHardening = key("slope k2 beyond the onset of the plateau, as stiffness", 0.0)
    restitution: Restitution | None = key(
        "coefficient of restitution e: unloading returns e^2 of the crush energy; default: contact.restitution"
    )
    unloading_stiffness: StripStiffness | None = key(
        "slope of unloading, as stiffness, in place of restitution"
    )
    axle: Annotated[int, Field(ge=0, le=100, strict=True)] | None = key(
        "number of the axle, from 0, that carries it, with [body]; default: the body carries it"
    )
    unit: UnitNumber = key("number of the unit of a train that has the strip; 1 for the vehicle", 1)

    @property
    def is_point(self) -> bool:
        """True for a point in the plane."""
        return self.height is None and self.at[0] == self.at[1]


class StrikeTable(SceneTable):
    """Force of the tail-slap in Stage 3."""

    duration: Duration = key("duration of the triangular force pulse", 0.1)


class Plate(SceneTable):
    """FE model of the vehicle as a plate in plane stress.

    Either youngs_modulus or first_frequency defines its stiffness.
    """

    thickness: Length = needed("thickness of the plate")
    density: Density | None = key(
        "density of the plate; default: mass of the vehicle over the volume of the plate"
    )
    youngs_modulus: Modulus | None = key("Young's modulus; required unless first_frequency is given")
    first_frequency: Frequency | None = key(
        "lowest natural frequency of the free plate in its plane; required unless youngs_modulus is given"
    )
    poissons_ratio: PoissonsRatio = needed("Poisson's ratio")
    elements: ElementCounts | None = key("number of elements along and across; default: automatic")
    element: Annotated[str, _registered(kinds.ELEMENT_KINDS)] = key("element type", "quad4")
    distortion: Distortion = key("distortion of the mesh, as a fraction of the element size", 0.0)
    lumping: Annotated[str, _registered(kinds.LUMPINGS)] = key("mass lumping", "exact")
    start: StartName = key("elastic state at t = 0", "inertia-relief")

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of elements along and across.

        Raises ValueError before they are selected.
        """
        if self.elements is None:
            raise ValueError("the elements are not chosen yet")
        return self.elements

    @property
    def modulus(self) -> float:
        """Young's modulus [Pa].

        Raises ValueError before it follows from the first frequency.
        """
        if self.youngs_modulus is None:
            raise ValueError("the modulus is not resolved yet")
        return self.youngs_modulus

    @property
    def relieved(self) -> bool:
        """True if the start is by inertia relief."""
        return start_kinds.START_KINDS[self.start].relieved


class MaterialTable(SceneTable):
    """Material law of the plate.

    Young's modulus and Poisson's ratio are keys of [plate].
    """

    law: Annotated[str, _registered(materials.MATERIALS)] = needed("material law of the plate")


class Damping(SceneTable):
    """Damping of the plate.

    By default the program selects it.
    """

    kind: Literal["elastic-velocity", "none"] | None = key(
        "damping of the elastic velocities; default: automatic"
    )
    rate: Rate | None = key("rate c of the damping of the elastic velocities")
    ratio: DampingRatio | None = key(
        "stiffness-proportional damping: damping ratio at the highest natural frequency"
    )
    bulk_viscosity: Viscosity | None = key("coefficient of linear bulk viscosity")


class Verify(SceneTable):
    """Limits on the result, and companion runs.

    Companion runs repeat a run on other meshes; the numerical error is estimated from them.
    """

    tolerance: Tolerance | None = key(
        "largest allowed difference from the rigid-body motion, constrained corners only"
    )
    mesh: Tolerance = key(
        "largest allowed numerical error of peak force, impulse, 50 ms mean and duration, whole impacts only",
        0.02,
    )
    companion: Annotated[bool, BeforeValidator(_flag)] = key(
        "estimate the numerical error by companion runs", True
    )


class Time(SceneTable):
    """Time integration and history."""

    safety_factor: Fraction = key("time step divided by the critical time step", 0.9)
    rows: Annotated[int, Field(ge=10, le=1_000_000, strict=True)] = key("number of rows of the history", 400)
    threads: Annotated[int, Field(ge=1, le=256, strict=True)] = key("number of threads of the time loop", 1)
    end: EndOfImpact | None = key(
        "end time of a whole impact; default: 0.1 s after the second strike, or the end of a strike then in progress"
    )


class Output(SceneTable):
    """Additional output of a run."""

    fields: Annotated[int, Field(ge=1, le=10_000, strict=True)] = needed(
        "number of instants at which displacement, velocity and stress of the plate are stored"
    )


class Wall(SceneTable):
    """Wall with its mesh, its elasticity or its profile.

    In a whole impact a wall with a mesh is elastic, on an elastic foundation. The default material is the concrete of
    the paper (Table 2). With [body] the wall is rigid and has height and profile only.
    """

    length: Length | None = key("length of the wall; required without [body]")
    depth: Length | None = key("depth of the wall; required without [body]")
    elements: ElementCounts | None = key("number of elements along and across; required without [body]")
    height: Length | None = key("height of the elastic wall, or with [body] of any wall")
    profile: Profile | None = key(
        "profile with [body], by name or as points [y, z] from [0, 0] upwards; default: vertical"
    )
    foundation_stiffness: LayerStiffness | None = key(
        "stiffness of the foundation per length of the elastic wall"
    )
    density: Density = key("density of the wall", 2400.0)
    youngs_modulus: Modulus = key("Young's modulus of the wall", 24.82e9)
    poissons_ratio: PoissonsRatio = key("Poisson's ratio of the wall", 0.18)

    @property
    def mesh(self) -> tuple[float, float, tuple[int, int]]:
        """Length, depth and element counts of the mesh.

        Raises ValueError for a wall without mesh.
        """
        if self.length is None or self.depth is None or self.elements is None:
            raise ValueError("the wall has no mesh")
        return self.length, self.depth, self.elements


class ParapetSection(SceneTable):
    """Reinforced section of the parapet, in place of its strengths.

    Areas of bars are those of the traffic face and of the back.
    """

    thickness: Thickness = needed("thickness of the wall, or pairs [height, thickness]")
    concrete_strength: Modulus = needed("compressive strength of the concrete")
    yield_strength: Modulus = needed("yield strength of the bars")
    cover: Length = needed("distance of the axes of the bars from their face")
    vertical_bars: Bars = needed("area of upright bars per length of wall")
    horizontal_bars: Bars = needed("area of longitudinal bars per height")


class Parapet(SceneTable):
    """Strength of the wall as a plate fixed at the deck.

    Either [parapet.section] or wall_strength and base_strength define it.
    """

    height: Length = needed("height of the parapet above the deck")
    length: Length | None = key("length of the wall between ends or joints; default: long")
    end_distance: Level | None = key(
        "distance from the nearer end or joint to the loaded length; default: middle and end of the wall"
    )
    beam_strength: BeamMoment = key("strength M_b of a beam at the top beside the wall", 0.0)
    wall_strength: Moment | None = key("strength M_w about the vertical axis, over the height")
    base_strength: LineMoment | None = key(
        "strength M_c about the longitudinal axis per length, one value or pairs [height, value]"
    )
    load_length: Length | None = key("length L_t of the load; default: that of impact.test_level")
    load_height: Length | None = key("height of the load; default: the top")
    section: ParapetSection | None = key("reinforced section, in place of the strengths")


class Scene(SceneTable):
    """One impact, with the models that represent it."""

    name: Name = needed("name of the scene and of its result folder")
    vehicle: Vehicle
    trailer: tuple[Trailer, ...] = ()
    impact: Impact | None = None
    start: StartTable | None = None
    corner: CornerTable = CornerTable()
    contact: Contact | None = None
    axle: tuple[Axle, ...] = ()
    body: Body | None = None
    strip: tuple[StripTable, ...] = ()
    sensor: Sensor | None = None
    strike: StrikeTable = StrikeTable()
    plate: Plate | None = None
    material: MaterialTable | None = None
    damping: Damping | None = None
    verify: Verify = Verify()
    time: Time = Time()
    output: Output | None = None
    wall: Wall | None = None
    parapet: Parapet | None = None

    @property
    def units(self) -> tuple[Vehicle, ...]:
        """The vehicle and its trailers, front to rear."""
        return (self.vehicle, *self.trailer)

    @property
    def starts_later(self) -> bool:
        """True if [start] defines the whole initial state of Stage 2.

        [impact] is then not used.
        """
        start = self.start or StartTable()
        return None not in (start.angle, start.omega, start.corner_speed)

    @property
    def needed_plate(self) -> Plate:
        """The plate of a finite-element run.

        Raises InputError where the scene has none.
        """
        if self.plate is None:
            raise InputError("plate", Missing, "this table is required for a finite-element run")
        return self.plate

    @property
    def needed_contact(self) -> Contact:
        """The contact of a whole impact.

        Raises InputError where the scene has none.
        """
        if self.contact is None:
            raise InputError("contact", Missing, "this table is required for a whole impact")
        return self.contact

    @property
    def crushes(self) -> bool:
        """True if what touches the wall crushes."""
        return bool(self.strip) or self.needed_contact.of_corners

    @property
    def has_points(self) -> bool:
        """True if a corner or a point touches the wall."""
        return bool(self.of_corners) or any(strip.at[0] == strip.at[1] for strip in self.strip)

    @property
    def of_corners(self) -> tuple[int, ...]:
        """Numbers from 1 of the units without strips, whose corners touch."""
        return tuple(u for u in range(1, 1 + len(self.units)) if all(strip.unit != u for strip in self.strip))

    @property
    def meshed_wall(self) -> Wall | None:
        """The wall, if it has a mesh."""
        return self.wall if self.wall and self.wall.elements else None

    @property
    def kept_fields(self) -> int:
        """Number of instants at which fields are stored."""
        return self.output.fields if self.output else 0

    @property
    def corner_friction(self) -> float:
        """Coefficient of friction in Stage 2.

        corner.friction, by default impact.friction; 0 for a reaction without friction.
        """
        if self.corner.frictionless:
            return 0.0
        friction = self.corner.friction
        friction = self.impact.friction if friction is None and self.impact else friction
        return math.nan if friction is None else friction


def table_of(field: FieldInfo) -> type[SceneTable] | None:
    """Return the table that a key holds, None for a value.

    Of a list of tables it is that of the elements.
    """
    kinds = (field.annotation, *get_args(field.annotation))
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, SceneTable)), None)


def values_of(table: type[SceneTable]) -> dict[str, FieldInfo]:
    """Return the keys of a table that are no tables themselves."""
    return {name: field for name, field in table.model_fields.items() if table_of(field) is None}


def _tables(table: type[SceneTable], prefix: str = "") -> dict[str, type[SceneTable]]:
    """Return the tables in a table by dotted name.

    Each table comes before those in it.
    """
    tables: dict[str, type[SceneTable]] = {}
    for name, field in table.model_fields.items():
        if inner := table_of(field):
            tables |= {f"{prefix}{name}": inner, **_tables(inner, f"{prefix}{name}.")}
    return tables


TABLES = _tables(Scene)
"""Tables of a scene by dotted name; of a list of tables, its element."""


def value_at(scene: Any, key: str) -> Any:
    """Return the value of a dotted key, e.g. "trailer.0.mass".

    It is None in an omitted table.
    """
    for name in key.split("."):
        if scene is not None:
            scene = scene[int(name)] if isinstance(scene, tuple) else getattr(scene, name)
    return scene


MEANINGS = MappingProxyType(
    {"name": Scene.model_fields["name"].description or ""}
    | {
        f"{name}.{k}": field.description or ""
        for name, table in TABLES.items()
        for k, field in values_of(table).items()
    }
)
"""Meaning of each key of a scene, by its dotted name."""
