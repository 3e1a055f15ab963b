"""What a whole impact must meet, in words: the key, why a value cannot be, and what is allowed instead."""

from __future__ import annotations

import math
from typing import Any

from solver.elementary import number
from solver.errors import Gate, RigidBodyError, Rule

POSITIVE = "positive and finite"

STIFFNESS = Rule("stiffness", "a law without stiffness never stops the vehicle", f"{POSITIVE}, N/m")
INITIAL_FORCE = Rule("initial_force", "the wall only pushes", "0 or more, and finite, N")
RESTITUTION = Rule("restitution", "unloading gives back its square of the energy taken up", "from 0 to 1")
LINE = Rule(
    "restitution",
    "with an initial force an unloading line that gives back more than half of the energy ends in front of the wall",
    "at most sqrt(1/2) = 0.707107 with an initial force, or no initial force",
)
FRICTION = Rule("friction", "friction resists", "0 or more, and finite")
CENTRE = Rule(
    "centre_of_mass", "the centre of mass is in the vehicle", "between 0 and the length, {length:.6g} m"
)
MIN_INERTIA = 1e-3
"""Of the greatest that there can be: nearly all mass at one point is no vehicle, and turns too often to be followed."""
INERTIA = Rule(
    "yaw_inertia",
    "no vehicle of that mass, size and centre of mass has it",
    "from a thousandth of m (a (L - a) + B^2/4) to at most m (a (L - a) + B^2/4) = {most:.6g} kg m^2",
)
UNIFORM = Rule(
    "centre_of_mass",
    "no body with its centre of mass there has the uniform rectangle's inertia, {inertia:.6g} kg m^2",
    "nearer to the middle, or a yaw_inertia of at most {most:.6g} kg m^2",
)
TOUCH_ANGLE = Rule("angle", "the front corner must come first", "between 0 and pi/2 rad")
SPEED = Rule("speed", "nothing strikes the wall", f"{POSITIVE}, m/s")
STATE = Rule("state", "the motion starts from it", "six finite numbers")
INSIDE = Rule(
    "state", "{name} is {depth:.6g} m inside the wall at the start", "outside the wall, or touching it"
)
NEVER = Rule("state", "the vehicle never touches the wall", "a motion towards the wall")
END = Rule("end", "the motion must go on for some time", f"{POSITIVE}, s")
TIME = Rule("time", "the motion is not followed that far", "from 0 to {end:.10g} s")
POINTS = Rule("side_points", "a layer is taken at points along each side", "1 or more")


def positive(rule: Rule, value: Any) -> float:
    """`value` as a positive, finite float; raises RigidBodyError by the rule."""
    return within(rule, value, 0.0, math.inf)


def within(rule: Rule, value: Any, least: float, most: float, **details: Any) -> float:
    """`value` as a float between the bounds, without them."""
    given = one(rule.key, value)
    Gate().demand(rule, least < given < most, given, **details)
    return given


def one(key: str, value: Any) -> float:
    """`value` as a float; raises RigidBodyError for arrays."""
    given = number(key, value)
    if not isinstance(given, float):
        raise RigidBodyError(key, f"of shape {given.shape}", "this is one impact", "a number")
    return given
