"""From a scene to a plan: the rigid-body answer, and what the finite-element run takes from it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from fem.kept import kept
from solver import (
    CONVENTIONS,
    ImpulseResult,
    PlaneMotion,
    RectangularBody,
    RigidBodyError,
    StrikeForce,
    corner_impulse,
    plane_motion,
    strike_force,
)
from tailslap.errors import InputError, Verbatim
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, varied


@dataclass(frozen=True)
class StageTwoStart:
    """What Stage 2 starts from.

    Attributes
    ----------
    angle : float
        Between the side and the wall [rad].
    omega : float
        Angular velocity [rad/s], positive towards the wall.
    corner_speed : float
        Of the corner along the wall [m/s].
    """

    angle: float
    omega: float
    corner_speed: float


@dataclass(frozen=True)
class Plan:
    """A scene with everything that follows from it without a mesh.

    Attributes
    ----------
    scene : Scene
        As read, SI.
    source : Source
        Where it came from.
    body : RectangularBody
        The vehicle.
    stage1 : ImpulseResult or None
        None without [impact].
    start : StageTwoStart
        What the scene gives, else what Stage 1 computes.
    motion : PlaneMotion
        Stage 2, exact.
    force : StrikeForce
        Stage 3.
    """

    scene: Scene
    source: Source
    body: RectangularBody[float]
    stage1: ImpulseResult[float] | None
    start: StageTwoStart
    motion: PlaneMotion
    force: StrikeForce[float]

    def motion_of_mass(self, mass: float) -> PlaneMotion:
        """The same motion of a body of another mass: forces and energies change with it, nothing else.

        Parameters
        ----------
        mass : float
            Of the body [kg].

        Returns
        -------
        PlaneMotion
            Stage 2, exact.
        """
        return _motion(self.scene, replace(self.body, mass=mass), self.start)


def make_plan(scene: Scene, source: Source | None = None) -> Plan:
    """Solve Stages 1 to 3 of a scene.

    Parameters
    ----------
    scene : Scene
        Of `read_scene`.
    source : Source, optional
        Where it came from, for the report.

    Returns
    -------
    Plan
        Without mesh or finite-element model.

    Raises
    ------
    InputError
        Where the rigid-body method has no answer; it names the scene's key.
    """
    if scene.contact is not None:
        allowed = "this command or study is of the paper's constrained corner; of a whole impact there are run, rigid, "
        raise InputError(
            "contact", "a table", allowed + "check, sweep, and study strike, flexibility, cost, stability"
        )
    vehicle = scene.vehicle
    with _refusals(scene, "vehicle"):
        body = RectangularBody(vehicle.length, vehicle.width, vehicle.mass)
    stage1 = stage_one(scene, body)
    start = _start(scene, stage1)
    motion = _motion(scene, body, start)
    with _refusals(scene, "strike"):
        force = strike_force(vehicle.mass, motion.strike.v_gy, scene.strike.duration)
    return Plan(scene, source or Source.of(scene), body, stage1, start, motion, force)


def stage_one(scene: Scene, body: RectangularBody[float]) -> ImpulseResult[float] | None:
    """Stage 1 of the scene; None without [impact]."""
    impact = scene.impact
    if impact is None or impact.friction is None or impact.restitution is None:
        return None
    with _refusals(scene, "impact"):
        return corner_impulse(
            body,
            impact.speed,
            impact.angle,
            impact.friction,
            impact.restitution,
            convention=impact.convention,
        )


def other_convention(plan: Plan) -> tuple[str, Plan] | None:
    """The other convention of restitution and the plan it gives; None where Stage 1 does not set the start."""
    impact, start = plan.scene.impact, plan.scene.start
    if impact is None or (start and start.omega is not None):
        return None
    (other,) = (name for name in CONVENTIONS if name != impact.convention)
    try:
        return other, make_plan(varied(plan.scene, {"impact.convention": other}))
    except InputError:
        return None


def with_changes(plan: Plan, changes: Changes) -> Plan:
    """The plan with keys of its scene changed on which the rigid motion does not depend; its source stays as given."""
    return replace(plan, scene=varied(plan.scene, changes))


def _start(scene: Scene, stage1: ImpulseResult[float] | None) -> StageTwoStart:
    given: dict[str, Any] = scene.start.model_dump() if scene.start else {}
    if stage1 is not None and scene.impact is not None:
        computed = {
            "angle": scene.impact.angle,
            "omega": stage1.omega,
            "corner_speed": stage1.corner_speed,
        }
    else:
        computed = {}
    return StageTwoStart(**(computed | {key: value for key, value in given.items() if value is not None}))


def _motion(scene: Scene, body: RectangularBody[float], start: StageTwoStart) -> PlaneMotion:
    with _refusals(scene, "start"):
        motion: PlaneMotion = _solved_motion(
            body,
            start.angle,
            start.omega,
            start.corner_speed,
            scene.corner_friction,
            scene.corner.rigid_reaction,
        )
    return motion


@kept("rigid motion")
def _solved_motion(body: RectangularBody[float], *given: Any) -> PlaneMotion:
    return plane_motion(body, *given)


@contextmanager
def _refusals(scene: Scene, table: str) -> Iterator[None]:
    """Turn what the theory refuses into a message that names the scene's key."""
    try:
        yield
    except RigidBodyError as error:
        key, allowed = _key(scene, table, error.key), f"{error.why}; allowed: {error.allowed}"
        if key == "impact.restitution" and scene.impact:  # it shows as an angular velocity of zero
            raise InputError(key, scene.impact.restitution, f"{error.why}; allowed: less than 1") from None
        given = f"{error.given} rad" if key.endswith(".angle") else str(error.given)
        raise InputError(key, Verbatim(_with_degrees(given)), _with_degrees(allowed)) from None


def _with_degrees(text: str) -> str:
    """Angles in the text in degrees too: they may have been given so."""
    return re.sub(r"([0-9.]+) rad\b(?!/)", lambda m: f"{m[0]} ({math.degrees(float(m[1])):.4g} deg)", text)


def _key(scene: Scene, table: str, name: str) -> str:
    """The key of the scene behind an input of the theory."""
    if table != "start":
        return f"{table}.{name}"
    if name == "friction":
        return "corner.friction" if scene.corner.friction is not None else "impact.friction"
    if name == "reaction":
        return "corner.reaction"
    if scene.start and getattr(scene.start, name, None) is not None:
        return f"start.{name}"
    return "impact.restitution" if name == "omega" else f"impact.{'angle' if name == 'angle' else 'speed'}"
