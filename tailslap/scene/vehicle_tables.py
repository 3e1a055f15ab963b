"""Define the tables of a scene on vehicle, impact and contact."""

from typing import Annotated, Literal

from pydantic import Field

from fem.laws.friction import FRICTION_LAWS
from tailslap.scene import types
from tailslap.scene.types import SceneTable, key, needed


class Vehicle(SceneTable):
    """Rigid rectangle that represents the vehicle."""

    length: types.Length = needed("length from front to rear")
    width: types.Length = needed("width over the body")
    mass: types.Mass = needed("mass, load included")
    centre_of_mass: types.Length | None = key(
        "distance of the centre of mass behind the front, whole impacts only; default: half the length"
    )
    yaw_inertia: types.Inertia | None = key(
        "yaw moment of inertia about the centre of mass, whole impacts only; default: uniform rectangle"
    )


class Trailer(Vehicle):
    """Trailer of a train, hinged to the unit ahead.

    The hinge lies on the centre lines of both units. Trailers require a whole impact.
    """

    hitch: types.Hitch = needed(
        "distance of the hinge behind the front of the unit ahead, a tow ball beyond its rear"
    )
    kingpin: types.Kingpin = needed(
        "distance of the hinge behind the front of the trailer; negative for a drawbar"
    )
    hitch_length: types.Length | None = key(
        "length of both plates over which the force of the hinge is distributed; default: one node, "
        "or half the vehicle's width if plate.elements is omitted"
    )
    centre_height: types.Height | None = key("height of the centre of mass; default: body.centre_height")
    roll_inertia: types.Inertia | None = key(
        "roll moment of inertia about it; default: mass times (0.45 width)^2"
    )
    pitch_inertia: types.Inertia | None = key("pitch moment of inertia about it; default: the yaw inertia")
    hitch_height: types.Level | None = key("height of the hinge; required with [body]")
    roll_stiffness: types.RollStiffness | None = key("stiffness of the hinge in roll; default: 3.55 MN m/rad")


class Impact(SceneTable):
    """First contact between the front corner and the wall.

    In a whole impact, friction and restitution enter only the rigid-body method quoted for comparison.
    """

    speed: types.Speed = needed("speed before the impact")
    angle: types.Angle = needed("angle between the side of the vehicle and the wall")
    friction: types.Friction | None = key(
        "coefficient of friction at the front corner in Stage 1; required without [contact]"
    )
    restitution: types.Restitution | None = key(
        "coefficient of restitution at the front corner in Stage 1; required without [contact]"
    )
    convention: Literal["paper", "newton"] = key(
        "definition of restitution in Stage 1: factor (1 - e) of the paper, or Newton's (1 + e)", "paper"
    )
    test_level: types.TestLevel | None = key(
        "level whose design forces are compared with the result: of MASH with those of AASHTO, of EN 1317-2 with the "
        "classes of EN 1991-2"
    )


class StartTable(SceneTable):
    """Initial state of Stage 2.

    Omitted values follow from Stage 1.
    """

    angle: types.Angle | None = key(
        "initial angle between the side of the vehicle and the wall; default: from Stage 1"
    )
    omega: types.AngularVelocity | None = key(
        "initial angular velocity, positive as the rear rotates towards the wall; default: from Stage 1"
    )
    corner_speed: types.Speed | None = key(
        "initial speed of the corner along the wall; default: from Stage 1"
    )


class CornerTable(SceneTable):
    """Constrained corner of Stage 2.

    By default the program selects the constraint.
    """

    reaction: types.ReactionName = key("friction law of the sliding corner", "drag")
    friction: types.Friction | None = key(
        "coefficient of friction of the sliding corner; default: impact.friction"
    )
    constraint: types.ConstraintName = key("constraint of the corner to the wall in the FE model", "penalty")
    penalty_scale: types.Scale = key(
        "penalty stiffness of the corner, relative to the default stiffness", 1.0
    )
    damping_ratio: types.DampingRatio | None = key("damping ratio of the penalty spring")
    patch_length: types.Length | None = key(
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

    stiffness: types.Stiffness | None = key(
        "crush stiffness k of both corners of each unit without [[strip]]; default: no crush"
    )
    strike_duration: types.Duration | None = key(
        "duration of a strike of the rear corner, which defines the crush stiffness in place of stiffness"
    )
    initial_force: types.Force = key("crush force F0 at zero crush depth", 0.0)
    plateau_force: types.Force | None = key(
        "crush force Fy of each corner, from which on it is constant or rises by hardening; default: no plateau"
    )
    hardening: types.Hardening = key("slope k2 of the crush force beyond the onset of its plateau", 0.0)
    restitution: types.Restitution | None = key(
        "coefficient of restitution e: unloading returns e^2 of the crush energy, also that of strips without "
        "unloading; required with stiffness, unless unloading_stiffness is given"
    )
    unloading_stiffness: types.Stiffness | None = key(
        "slope of unloading of each corner, in place of restitution"
    )
    friction: types.Friction = needed("coefficient of friction between vehicle and wall")
    patch_length: types.Length | None = key(
        "length of the side over which the force of a corner, or of a point, is distributed; default: one node, "
        "or half the vehicle's width if plate.elements is omitted"
    )
    enforcement: Literal["penalty", "exact"] = key("enforcement of contact without crush", "penalty")
    penalty_scale: types.Scale = key(
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

    position: types.Hitch = needed("distance of the axle behind the front of its unit")
    friction: types.Friction = key(
        "coefficient of friction of the tyres on the road; 0 for no side force", 0.0
    )
    cornering: types.Cornering = key(
        "cornering coefficient: side force over load and slip angle at small slip", 6.0
    )
    unit: types.UnitNumber = key("number of the unit of a train that has the axle; 1 for the vehicle", 1)
    track: types.Length | None = key("distance between the tyres of both sides; required with [body]")
    radius: types.Height | None = key("height of the axle; required with [body]")
    mass: types.Mass | None = key("mass of axle and wheels, part of that of the unit; required with [body]")
    spring: types.Stiffness | None = key("stiffness of the spring of one side; required with [body]")
    spacing: types.Length | None = key("distance between the springs; required with [body]")
    damping_ratio: types.SpringDamping | None = key("damping ratio of the springs; default: 0.15, assumed")
    tyre: types.Stiffness | None = key("vertical stiffness of the tyres of one side; required with [body]")
    roll_centre: types.Level | None = key(
        "height at which side force enters the body; default: 0.6 m, assumed"
    )


class Body(SceneTable):
    """Vehicle in space.

    It has roll and pitch, and its forces have heights; whole impacts only. Axles carry the vehicle and strips touch the
    wall, whose height [wall] defines.
    """

    centre_height: types.Height = needed("height of the centre of mass of the vehicle with its axles")
    roll_inertia: types.Inertia | None = key(
        "roll moment of inertia about it; default: mass times (0.45 width)^2"
    )
    pitch_inertia: types.Inertia | None = key("pitch moment of inertia about it; default: the yaw inertia")


class Sensor(SceneTable):
    """Accelerometer on the centre line of a single vehicle, whole impacts only.

    Mass times the 50 ms mean of its acceleration away from the wall is the inertial estimate of the force, which crash
    tests publish. Without this table its place is assumed.
    """

    position: types.Hitch | None = key(
        "distance of the sensor behind the front; default: behind_centre behind the centre of mass"
    )
    behind_centre: types.Kingpin | None = key(
        "distance of the sensor behind the centre of mass; default: 0.25 m, assumed 0 to 0.5 m"
    )
    height: types.Level | None = key(
        "height of the sensor, with [body]; default: 0.95 m of a truck's frame, assumed, or that of the centre of mass "
        "if lower"
    )


class StripTable(SceneTable):
    """Point or line of the vehicle that can touch the wall.

    It is on both sides. In the plane it is a point, or a line between two places; with [body] it has heights, and all
    values are per length. Without restitution and unloading_stiffness it unloads by contact.restitution.
    """

    at: types.Places = needed("distance behind the front of its unit: one, or two of a line along the side")
    height: types.Levels | None = key(
        "height above the ground, required with [body]: two of an upright strip, or one of a line"
    )
    inset: types.Level = key("distance inwards from the side", 0.0)
    stiffness: types.StripStiffness = needed("crush stiffness k per length; of a point in the plane k itself")
    initial_force: types.StripForce = key("crush force F0 at zero crush depth, as stiffness", 0.0)
    plateau: types.StripPlateau | None = key(
        "crush force Fy, as stiffness, from which on it is constant or rises by hardening; default: no plateau"
    )
    hardening: types.StripHardening = key("slope k2 beyond the onset of the plateau, as stiffness", 0.0)
    restitution: types.Restitution | None = key(
        "coefficient of restitution e: unloading returns e^2 of the crush energy; default: contact.restitution"
    )
    unloading_stiffness: types.StripStiffness | None = key(
        "slope of unloading, as stiffness, in place of restitution"
    )
    axle: Annotated[int, Field(ge=0, le=100, strict=True)] | None = key(
        "number of the axle, from 0, that carries it, with [body]; default: the body carries it"
    )
    unit: types.UnitNumber = key("number of the unit of a train that has the strip; 1 for the vehicle", 1)

    @property
    def is_point(self) -> bool:
        """True for a point in the plane."""
        return self.height is None and self.at[0] == self.at[1]


class StrikeTable(SceneTable):
    """Force of the tail-slap in Stage 3."""

    duration: types.Duration = key("duration of the triangular force pulse", 0.1)
