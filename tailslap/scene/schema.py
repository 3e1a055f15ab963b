"""The scene: what a TOML file may say, each key with its meaning, unit, bounds and default.

SI after validation; a table that is None is a part left out.
"""

import math
import re
from types import MappingProxyType
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticKnownError

from fem.laws import constraints, materials
from fem.laws.friction import FRICTION_LAWS
from fem.plate import kinds
from fem.registry import Registry
from fem.start import start_kinds
from tailslap.errors import InputError, Missing
from tailslap.scene.units import Quantity

MAX_ELEMENTS = 4_000_000
"""A mesh above this would not fit the memory of the machines this is made for."""

# Bounds lie far outside what is built: within them every number that follows is finite.
Length = Annotated[float, Quantity("a length", "m", '"10 m"', least=1e-6, most=1e6)]
Hitch = Annotated[float, Quantity("a distance behind the front", "m", '"5.6 m"', least=0.0, most=1e6)]
Kingpin = Annotated[
    float,
    Quantity("a distance behind the front, of a drawbar negative", "m", '"0.9 m"', least=-1e6, most=1e6),
]
Mass = Annotated[float, Quantity("a mass", "kg", '"9979 kg"', least=1e-6, most=1e12)]
Speed = Annotated[float, Quantity("a speed", "m/s", '"56 mph"', least=1e-6, most=1e4)]
Angle = Annotated[float, Quantity("an angle", "rad", '"15 deg"', least=1e-6, below=math.pi / 2)]
AngularVelocity = Annotated[
    float, Quantity("an angular velocity that closes the angle", "rad/s", "0.707", least=1e-9, most=1e6)
]
Friction = Annotated[float, Quantity("a coefficient of friction", "", "0.47", least=0.0, most=1e3)]
Restitution = Annotated[float, Quantity("a coefficient of restitution", "", "0.22", least=0.0, most=1.0)]
Duration = Annotated[float, Quantity("a duration", "s", '"0.1 s"', least=1e-9, most=1e6)]
EndOfImpact = Annotated[float, Quantity("an end of the impact", "s", '"1 s"', least=0.05, most=100.0)]
Density = Annotated[float, Quantity("a density", "kg/m^3", "7800", least=1e-6, most=1e9)]
Modulus = Annotated[float, Quantity("a modulus", "Pa", '"200 GPa"', least=1e-3, most=1e18)]
Frequency = Annotated[float, Quantity("a frequency in cycles a second", "Hz", '"8 Hz"', least=1e-6, most=1e9)]
PoissonsRatio = Annotated[float, Quantity("Poisson's ratio", "", "0.3", least=-0.999, most=0.4999)]
Scale = Annotated[float, Quantity("a factor", "", "1.0", least=1e-6, most=1e6)]
Fraction = Annotated[float, Quantity("a fraction", "", "0.9", least=1e-6, most=1.0)]
DampingRatio = Annotated[float, Quantity("a damping ratio", "", "0.1", least=1e-9, most=1.0)]
Viscosity = Annotated[
    float, Quantity("a coefficient of linear bulk viscosity", "", "0.06", least=1e-9, most=10.0)
]
Stiffness = Annotated[float, Quantity("a stiffness", "N/m", '"2 MN/m"', least=1e-3, most=1e15)]
LayerStiffness = Annotated[
    float, Quantity("a stiffness per length of side", "N/m^2", '"1 MN/m^2"', least=1e-3, most=1e15)
]
Force = Annotated[float, Quantity("a force", "N", '"100 kN"', least=0.0, most=1e12)]
Inertia = Annotated[
    float, Quantity("a moment of inertia", "kg m^2", '"88101 kg m^2"', least=1e-12, most=1e15)
]
Rate = Annotated[float, Quantity("a rate", "1/s", '"100 1/s"', least=1e-9, most=1e12)]
Tolerance = Annotated[float, Quantity("a relative tolerance", "", "1e-3", least=1e-15, below=1.0)]
Distortion = Annotated[float, Quantity("a fraction of the element's size", "", "0.2", least=0.0, most=0.3)]


def _registered(registry: Registry[Any]) -> BeforeValidator:
    """One of the names in a registry, whenever the scene is read."""

    def name(given: object) -> object:
        if not isinstance(given, str) or given not in registry:
            raise PydanticKnownError("literal_error", {"expected": registry.expected})
        return given

    return BeforeValidator(name)


def _element_counts(given: object) -> object:
    allowed = f"allowed are two whole numbers from 1, at most {MAX_ELEMENTS} elements in all, like [20, 6]"
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise ValueError(allowed)
    if any(type(n) is not int or n < 1 for n in given) or given[0] * given[1] > MAX_ELEMENTS:
        raise ValueError(allowed)
    return tuple(given)


FORMER_STARTS = {"quiet": "inertia-relief", "sudden": "unstressed"}
"""Names of starts in scenes of earlier versions, and what they are called."""


def _start_name(given: object) -> object:
    if isinstance(given, str) and given in FORMER_STARTS:
        raise ValueError(f'this start is called "{FORMER_STARTS[given]}"')
    return given


StartName = Annotated[str, _registered(start_kinds.START_KINDS), BeforeValidator(_start_name)]
ReactionName = Annotated[str, _registered(FRICTION_LAWS)]
ConstraintName = Annotated[str, _registered(constraints.CONSTRAINTS)]
ElementCounts = Annotated[tuple[int, int], BeforeValidator(_element_counts)]


def _flag(given: object) -> object:
    if not isinstance(given, bool):
        raise ValueError("allowed is true or false")
    return given


def _name(given: object) -> object:
    """A name of a file, for results go to results/NAME: no "..", and nothing hidden."""
    if not isinstance(given, str) or not re.fullmatch(r"[\w+-][\w.+-]{0,79}", given):
        raise ValueError('allowed are 1 to 80 letters, digits and "_", "+", "-", ".", with no "." in front')
    return given


Name = Annotated[str, BeforeValidator(_name)]


def needed(meaning: str) -> Any:
    """A key that a table must have; meaning: in a line, for new scenes and the reference."""
    return Field(description=meaning)


def key(meaning: str, default: Any = None) -> Any:
    """A key that may be left out."""
    return Field(default, description=meaning)


class SceneTable(BaseModel):
    """A table of the scene: unknown keys are errors, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Vehicle(SceneTable):
    """The rigid body; the last two are of whole impacts, left out: the uniform rectangle's."""

    length: Length = needed("of the rectangle, along the direction of travel")
    width: Length = needed("of the rectangle")
    mass: Mass = needed("of the vehicle")
    centre_of_mass: Length | None = key("behind the front, of a whole impact; if left out half the length")
    yaw_inertia: Inertia | None = key(
        "about the centre of mass, of a whole impact; if left out the uniform rectangle's"
    )


class Trailer(Vehicle):
    """A unit of a train, [[trailer]]: hinged to the one ahead, on the centre lines of both; of a whole impact."""

    hitch: Hitch = needed("where the hinge is, behind the front of the unit ahead")
    kingpin: Kingpin = needed("where the hinge is, behind the trailer's own front; negative for a drawbar")
    stiffness: Stiffness | None = key("of the crush law of its corners; if left out contact.stiffness")
    hitch_length: Length | None = key(
        "length of both units over which the hinge of the FE plates is spread; if left out one node"
    )


class Impact(SceneTable):
    """Stage 1; of a whole impact the first touch, and then friction and restitution feed the paper's method alone."""

    speed: Speed = needed("before the impact")
    angle: Angle = needed("between the vehicle's side and the wall")
    friction: Friction | None = key("between the front corner and the wall, in Stage 1")
    restitution: Restitution | None = key("of the front corner, in Stage 1")
    convention: Literal["paper", "newton"] = key(
        "of restitution: the paper's (1 - e) or Newton's (1 + e)", "paper"
    )
    test_level: Literal["TL-1", "TL-2", "TL-3", "TL-4", "TL-5", "TL-6"] | None = key(
        "of MASH; design forces of this level stand beside the result"
    )


class StartTable(SceneTable):
    """The state Stage 2 starts from; what is left out comes from Stage 1."""

    angle: Angle | None = key("between side and wall where Stage 2 starts, in place of Stage 1's")
    omega: AngularVelocity | None = key("angular velocity where Stage 2 starts, in place of Stage 1's")
    corner_speed: Speed | None = key(
        "of the corner along the wall where Stage 2 starts, in place of Stage 1's"
    )


class CornerTable(SceneTable):
    """The constrained corner. Where neither constraint nor spring is given, the program chooses the constraint."""

    reaction: ReactionName = key("friction law of the corner that slides", "drag")
    friction: Friction | None = key("of the corner that slides; if left out impact.friction")
    constraint: ConstraintName = key("how the FE model holds the corner on the wall", "penalty")
    penalty_scale: Scale = key("stiffness of the corner's spring, times the program's own choice", 1.0)
    damping_ratio: DampingRatio | None = key("of the corner's spring, to critical")
    patch_length: Length | None = key("length of side over which the corner is held; if left out one node")

    @property
    def frictionless(self) -> bool:
        """True if the reaction is one without friction."""
        return FRICTION_LAWS[self.reaction].frictionless

    @property
    def rigid_reaction(self) -> str:
        """Name of the reaction in the rigid-body theory."""
        return FRICTION_LAWS[self.reaction].rigid

    @property
    def constraint_is_open(self) -> bool:
        """True if the scene leaves the choice of the constraint to the program."""
        return not self.model_fields_set & {"constraint", "penalty_scale", "damping_ratio"}


class Contact(SceneTable):
    """A whole impact: where the vehicle touches a wall that only pushes.

    stiffness, initial_force, restitution: of the crush law at each corner, F0 + k d, whose unloading gives back e^2 of
    the energy; side_stiffness: of a layer along the sides. Without stiffness the vehicle does not crush: then
    enforcement and penalty_scale.
    """

    stiffness: Stiffness | None = key("of the crush law of each corner; if left out nothing crushes")
    initial_force: Force = key("of the crush law, at no crush", 0.0)
    restitution: Restitution | None = key("its square is the fraction of the crush energy that is given back")
    friction: Friction = needed("between vehicle and wall")
    side_stiffness: LayerStiffness | None = key(
        "of a layer along the sides; if left out the corners alone touch"
    )
    patch_length: Length | None = key("length of side over which a corner's force is spread")
    enforcement: Literal["penalty", "exact"] = key("of contact that does not crush", "penalty")
    penalty_scale: Scale = key("stiffness of the penalty, times the program's own choice", 1.0)

    @property
    def crushes(self) -> bool:
        """True if the vehicle crushes."""
        return self.stiffness is not None


class StrikeTable(SceneTable):
    """Stage 3."""

    duration: Duration = key("of the tail-slap in Stage 3", 0.1)


class Plate(SceneTable):
    """The FE model of the vehicle: its modulus, or the first frequency in its plane that the modulus gives it.

    Without elements, or without element, the program chooses them.
    """

    thickness: Length = needed("of the FE plate")
    density: Density | None = key("if left out the vehicle's mass spread over the plate")
    youngs_modulus: Modulus | None = key("of the plate; this or first_frequency")
    first_frequency: Frequency | None = key("of the free plate in its plane, which gives the modulus")
    poissons_ratio: PoissonsRatio = needed("of the plate")
    elements: ElementCounts | None = key("along and across; if left out the program chooses")
    element: Annotated[str, _registered(kinds.ELEMENT_KINDS)] = key("kind of element", "quad4")
    distortion: Distortion = key("of the mesh, as a fraction of the element's size", 0.0)
    lumping: Annotated[str, _registered(kinds.LUMPINGS)] = key("how the mass is put on the nodes", "exact")
    start: StartName = key("elastic state at the start", "inertia-relief")

    @property
    def counts(self) -> tuple[int, int]:
        """Elements along and across, where the scene gives them or the program has chosen."""
        if self.elements is None:
            raise ValueError("the elements are not chosen yet")
        return self.elements

    @property
    def modulus(self) -> float:
        """Young's modulus [Pa], where the scene gives it or the first frequency has given it."""
        if self.youngs_modulus is None:
            raise ValueError("the modulus is not resolved yet")
        return self.youngs_modulus

    @property
    def relieved(self) -> bool:
        """True if the plate starts with the elastic state of its acceleration."""
        return start_kinds.START_KINDS[self.start].relieved


class MaterialTable(SceneTable):
    """The plate's material law; Young's modulus and Poisson's ratio are the plate's."""

    law: Annotated[str, _registered(materials.MATERIALS)] = needed("of the plate")


class Damping(SceneTable):
    """Damping of the plate. kind and rate: of its elastic velocities; without kind the program decides.

    ratio: stiffness-proportional, to critical at the model's highest frequency. bulk_viscosity: linear.
    """

    kind: Literal["elastic-velocity", "none"] | None = key(
        "of the plate's elastic motion; if left out the program decides"
    )
    rate: Rate | None = key("of the elastic velocities")
    ratio: DampingRatio | None = key("in proportion to stiffness, to critical at the highest frequency")
    bulk_viscosity: Viscosity | None = key("linear")


class Verify(SceneTable):
    """Demands of the scene on its own result, and companions: runs of the same vehicle on other meshes, from which a
    run states its numerical error; without them it states none.

    tolerance: of the five quantities of a constrained corner. mesh: of a whole impact's first two strikes of weight.
    """

    tolerance: Tolerance | None = key("largest difference from the rigid motion that the scene allows")
    mesh: Tolerance = key(
        "largest numerical error of a strike's peak, impulse, 50 ms mean and duration", 0.02
    )
    companion: Annotated[bool, BeforeValidator(_flag)] = key(
        "whether a run states its numerical error, by runs on other meshes", True
    )


class Time(SceneTable):
    """Fraction of the stable time step that is taken; rows of the history; threads of the time loop; end of a whole
    impact, which is left out 0.1 s after the second strike."""

    safety_factor: Fraction = key("time step over the stable one", 0.9)
    rows: Annotated[int, Field(ge=10, le=1_000_000, strict=True)] = key("of the history", 400)
    threads: Annotated[int, Field(ge=1, le=256, strict=True)] = key("of the time loop", 1)
    end: EndOfImpact | None = key("of a whole impact; if left out 0.1 s after the second strike")


class Output(SceneTable):
    """Output of a run beside its report. fields: instants of a run at which displacement, velocity and stress of the
    whole plate are kept."""

    fields: Annotated[int, Field(ge=1, le=10_000, strict=True)] = needed(
        "instants of a run at which displacement, velocity and stress of the plate are kept"
    )


class Wall(SceneTable):
    """The wall's mesh; of a whole impact a deformable wall, on a foundation along it. Material left out: the paper's
    concrete (Table 2)."""

    length: Length = needed("of the wall's mesh")
    depth: Length = needed("of the wall's mesh")
    elements: ElementCounts = needed("along and across")
    height: Length | None = key("of a wall that gives")
    foundation_stiffness: LayerStiffness | None = key("of a wall that gives, along it")
    density: Density = key("of the wall", 2400.0)
    youngs_modulus: Modulus = key("of the wall", 24.82e9)
    poissons_ratio: PoissonsRatio = key("of the wall", 0.18)


class Scene(SceneTable):
    """A whole scene."""

    name: Name = needed("names the result folder")
    vehicle: Vehicle
    trailer: tuple[Trailer, ...] = ()
    impact: Impact | None = None
    start: StartTable | None = None
    corner: CornerTable = CornerTable()
    contact: Contact | None = None
    strike: StrikeTable = StrikeTable()
    plate: Plate | None = None
    material: MaterialTable | None = None
    damping: Damping | None = None
    verify: Verify = Verify()
    time: Time = Time()
    output: Output | None = None
    wall: Wall | None = None

    @property
    def units(self) -> tuple[Vehicle, ...]:
        """The vehicle and its trailers."""
        return (self.vehicle, *self.trailer)

    @property
    def needed_plate(self) -> Plate:
        """The plate. Raises InputError where the scene has none."""
        if self.plate is None:
            raise InputError("plate", Missing, "a run needs this table; `tailslap rigid` does without it")
        return self.plate

    @property
    def needed_contact(self) -> Contact:
        """The contact of a whole impact. Raises InputError where the scene has none."""
        if self.contact is None:
            raise InputError("contact", Missing, "a whole impact needs this table")
        return self.contact

    @property
    def kept_fields(self) -> int:
        """Instants at which fields are kept."""
        return self.output.fields if self.output else 0

    @property
    def corner_friction(self) -> float:
        """Friction of Stage 2: the corner's, else the impact's, and 0 with reaction "none"."""
        if self.corner.frictionless:
            return 0.0
        given = self.corner.friction
        given = self.impact.friction if given is None and self.impact else given
        return math.nan if given is None else given


TABLES: dict[str, type[SceneTable]] = {
    name: kind
    for name, field in Scene.model_fields.items()
    for kind in (field.annotation, *get_args(field.annotation))
    if isinstance(kind, type) and issubclass(kind, SceneTable)
}
"""Tables of a scene by name, of a list of tables one."""

LISTED = ("trailer",)
"""Names of lists of tables, [[NAME]]."""

MEANINGS = MappingProxyType(
    {"name": Scene.model_fields["name"].description or ""}
    | {f"{n}.{k}": own.description or "" for n, its in TABLES.items() for k, own in its.model_fields.items()}
)
"""Meaning of each key of a scene, by its dotted name."""
