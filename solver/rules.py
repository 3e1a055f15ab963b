"""What the inputs must meet, in words: the key, why a value cannot be, and what is allowed instead."""

from __future__ import annotations

from solver.errors import Rule

POSITIVE = "positive and finite"
_ABRUPT = "the angular velocity changes too abruptly on the path for double precision"

LENGTH = Rule("length", "a body without extent has no corner to turn about", f"{POSITIVE}, m")
WIDTH = Rule("width", "a body without extent has no corner to turn about", f"{POSITIVE}, m")
MASS = Rule("mass", "a body without mass has no momentum", f"{POSITIVE}, kg")
SPEED = Rule("speed", "nothing strikes the wall", f"{POSITIVE}, m/s")
ANGLE = Rule(
    "angle",
    "the side must be open to the wall, and the centre of mass behind the corner",
    "more than 0 and less than {most:.6g} rad (phi = angle + corner angle < pi/2)",
)
FRICTION = Rule("friction", "friction resists", "0 or more, and finite")
RESTITUTION = Rule("restitution", "it is a share of the approach", "from 0 to 1")
TURNING = Rule(
    "friction",
    "the impulse then passes on the wrong side of the centre of mass and does not turn the vehicle towards "
    "the wall (beta <= phi = {phi:.6g} rad)",
    "less than cot(phi) = {limit:.6g}",
)

OMEGA = Rule("omega", "the side never reaches the wall", f"{POSITIVE}, rad/s")
CORNER_SPEED = Rule(
    "corner_speed",
    "the corner does not slide forwards, and friction is known for forward sliding alone",
    "finite, and positive where there is friction, m/s",
)
_PATH = "less than 4/3 = 1.33333 for every path, less than {limit:.6g} for this one"
UNIQUE = Rule(
    "friction",
    "the motion is not unique: where 1 + 3 C^2 - 3 mu S C < 0, and it falls to {least:.6g} on the path, the "
    "wall may push as well as pull",
    _PATH,
)
SOLVABLE = Rule(
    "friction",
    "there is no solution: the reaction grows without bound where D = 1 + 3 C^2 - 3 mu S C reaches 0, and it "
    "falls to {least:.6g} on the path",
    _PATH,
)
GROWTH = Rule("friction", _ABRUPT, "less, or another reaction model")
STOP = Rule(
    "corner_speed",
    "the corner stops before the strike, at the angle {angle:.6g} rad and the time {time:.6g} s, and there "
    "friction turns round",
    "more, or no friction, m/s",
)
RANGE = Rule(
    "omega", "the motion is beyond the range of double precision", "smaller, as corner_speed and mass"
)

TIME = Rule(
    "time",
    "the motion is not followed that far",
    "from 0 to {latest:.10g} s (the strike is at {strike:.10g} s)",
)
STOPPED = Rule("time", "the corner has stopped by then, and friction turns round", "up to the strike")
LATERAL_SPEED = Rule("lateral_speed", "nothing strikes at such a speed", "finite, m/s")
DURATION = Rule("duration", "the pulse must begin and end", f"{POSITIVE}, s")

FRONT_DISTANCE = Rule("front_distance", "the centre of mass is behind the front", f"{POSITIVE}, m")
HALF_WIDTH = Rule("half_width", "the centre of mass is inside the vehicle", f"{POSITIVE}, m")
GRAVITY = Rule("gravity", "it is the unit of the deceleration", f"{POSITIVE}, m/s^2")
IMPACT_ANGLE = Rule("angle", "the vehicle must approach the wall at an angle", "between 0 and pi/2 rad")
DEFLECTION = Rule("deflection", "the barrier gives way outwards, or not at all", "0 or more, and finite, m")
TRAVEL = Rule(
    "travel",
    "the centre of mass must come closer to the wall while the vehicle turns parallel to it",
    "positive: front_distance sin(angle) + deflection > half_width (1 - cos(angle)), m",
)
AVERAGE_FORCE = Rule("average_force", "there is no peak without an average", f"{POSITIVE}, N")
