"""Rules that the inputs of the rigid-body theory must meet."""

from solver.conditions import Rule

POSITIVE = "positive and finite"

LENGTH = Rule("length", "the vehicle needs a finite extent", f"{POSITIVE}, m")
WIDTH = Rule("width", "the vehicle needs a finite extent", f"{POSITIVE}, m")
MASS = Rule("mass", "the vehicle needs a mass", f"{POSITIVE}, kg")
SPEED = Rule("speed", "there is no impact", f"{POSITIVE}, m/s")
ANGLE = Rule(
    "angle",
    "the impact must start at the front corner with the centre of mass behind it",
    "more than 0 and less than {most:.6g} rad ({most_deg:.4g} deg) (phi = angle + corner angle < pi/2)",
)
FRICTION = Rule("friction", "friction opposes sliding", "0 or more, and finite")
RESTITUTION = Rule("restitution", "it is a fraction of the approach velocity", "from 0 to 1")
TURNING = Rule(
    "friction",
    "the impulse does not rotate the side of the vehicle towards the wall (beta <= phi = {phi:.6g} rad "
    "({phi_deg:.4g} deg))",
    "less than cot(phi) = {limit:.6g}",
)

OMEGA = Rule("omega", "the side never reaches the wall", f"{POSITIVE}, rad/s")
CORNER_SPEED = Rule(
    "corner_speed",
    "friction is defined for forward sliding of the corner",
    "finite, and positive where there is friction, m/s",
)
_PATH = "less than 4/3 = 1.33333 for every path, less than {limit:.6g} for this one"
UNIQUE = Rule(
    "friction",
    "the motion is not unique: the sign of the reaction is undefined where 1 + 3 C^2 - 3 mu S C < 0, and its minimum "
    "on the path is {least:.6g}",
    _PATH,
)
SOLVABLE = Rule(
    "friction",
    "the reaction is unbounded where D = 1 + 3 C^2 - 3 mu S C = 0, and its minimum on the path is {least:.6g}",
    _PATH,
)
GROWTH = Rule(
    "friction",
    "the angular velocity changes too abruptly on the path for double precision",
    "less, or another reaction model",
)
STOP = Rule(
    "corner_speed",
    "the corner stops before the tail-slap, at the angle {angle:.6g} rad ({angle_deg:.4g} deg) and the time "
    "{time:.6g} s, where friction reverses",
    "more, or no friction, m/s",
)
RANGE = Rule(
    "omega", "the motion is beyond the range of double precision", "smaller, as corner_speed and mass"
)

_FAR = "the motion ends earlier"
TIME = Rule("time", _FAR, "from 0 to {latest:.10g} s (the strike is at {strike:.10g} s)")
STOPPED = Rule("time", "the corner has stopped by then, and friction reverses", "up to the strike")
LATERAL_SPEED = Rule("lateral_speed", "it is not a finite speed", "finite, m/s")
DURATION = Rule("duration", "the pulse needs a finite duration", f"{POSITIVE}, s")

FRONT_DISTANCE = Rule("front_distance", "the centre of mass must be behind the front", f"{POSITIVE}, m")
HALF_WIDTH = Rule("half_width", "the centre of mass must be inside the vehicle", f"{POSITIVE}, m")
GRAVITY = Rule("gravity", "it is the unit of deceleration", f"{POSITIVE}, m/s^2")
IMPACT_ANGLE = Rule("angle", "the vehicle must approach the wall at an angle", "between 0 and pi/2 rad")
DEFLECTION = Rule("deflection", "the barrier deflects away from the vehicle", "0 or more, and finite, m")
TRAVEL = Rule(
    "travel",
    "the centre of mass must approach the wall",
    "positive: front_distance sin(angle) + deflection > half_width (1 - cos(angle)), m",
)
AVERAGE_FORCE = Rule("average_force", "the peak force follows from it", f"{POSITIVE}, N")

STIFFNESS = Rule("stiffness", "crush needs a finite stiffness", f"{POSITIVE}, N/m")
INITIAL_FORCE = Rule("initial_force", "contact is unilateral", "0 or more, and finite, N")
AXLE = Rule("axle", "an axle is below its vehicle", "from 0 to the length, {length:.6g} m")
AXLE_LOAD = Rule(
    "axle",
    "the axles cannot carry the vehicle: this one would have to pull it down",
    "axles before and behind the centre of mass, or a lone one there; of a trailer behind the kingpin",
)
AXLE_UNIT = Rule("axle", "there is no such unit", "from 0 to {most}")
TYRE = Rule("axle", "the side force of the tyres resists sliding", "0 or more, and finite")
PLATEAU = Rule(
    "plateau_force",
    "the crush force rises from the initial force to it",
    "at least that, {initial:.6g}, above 0",
)
UNLOADING = Rule(
    "unloading_stiffness",
    "unloading on a line less steep than loading would return more energy than it takes",
    "at least the stiffness, {stiffness:.6g}, and finite",
)
HARDENING = Rule(
    "hardening",
    "beyond the onset of the plateau the crush force rises no more steeply than before it",
    "with a plateau 0 to the stiffness, {stiffness:.6g}",
)
ONE_UNLOADING = Rule("unloading_stiffness", "the restitution defines the unloading as well", "one of the two")
RETURNED = Rule("restitution", "unloading returns e^2 of the crush energy", "from 0 to 1")
LINE = Rule(
    "restitution",
    "with an initial force or a plateau, unloading that returns more than half of the energy ends in front of the wall",
    "at most sqrt(1/2) = 0.707107, or neither initial force nor plateau",
)
CENTRE = Rule(
    "centre_of_mass",
    "the centre of mass must be inside the vehicle",
    "between 0 and the length, {length:.6g} m",
)
MIN_INERTIA = 1e-3
"""Smallest yaw inertia relative to the largest possible one."""
INERTIA = Rule(
    "yaw_inertia",
    "it is impossible for this mass, size and centre of mass",
    "from 0.001 I to I = m (a (L - a) + B^2/4) = {most:.6g} kg m^2",
)
UNIFORM = Rule(
    "centre_of_mass",
    "the yaw inertia of the uniform rectangle, {inertia:.6g} kg m^2, is impossible for it",
    "closer to the middle, or a yaw_inertia of at most {most:.6g} kg m^2",
)
FORWARDS = Rule("speed", "the vehicle travels ahead", "0 m/s or more, and finite")
TOUCH_ANGLE = Rule("angle", "the front corner must touch the wall first", "between 0 and pi/2 rad")
STATE = Rule("state", "it is the initial state", "six finite numbers")
INSIDE = Rule(
    "state", "{name} is {depth:.6g} m inside the wall at the start", "outside the wall, or touching it"
)
NEVER = Rule("state", "the vehicle never touches the wall", "a motion towards the wall")
END = Rule("end", "the motion needs a finite duration", f"{POSITIVE}, s")
IMPACT_TIME = Rule("time", _FAR, "from 0 to {end:.10g} s")

PROFILE = Rule(
    "wall.profile",
    "the face of a wall leads upwards and does not overhang",
    "a name, or at least two points [y, z], the first [0, 0], z growing and y not",
)
PROFILE_POINTS = Rule("wall.profile", "a profile is a line of few points", "at most {most:.0f} points")
WALL_HEIGHT = Rule("wall.height", "a wall without height holds nothing", f"{POSITIVE}, m")
SPRUNG = Rule("vehicle.mass", "the axles weigh {axles:.6g} kg", "more than the axles")
SPRUNG_INERTIA = Rule(
    "roll_inertia", "the axles and the distances between the masses have more", "more than {least:.6g} kg m^2"
)
CENTRE_ABOVE = Rule(
    "centre_height",
    "the centre of mass is above the axles",
    "more than the radius of the wheels, {radius:.6g} m",
)
STRIP_UNIT = Rule("strip", "there is no such unit", "below the number of units, {most}")
STRIP_AT = Rule("strip", "a strip is a part of its vehicle", "from 0 to the length, {length:.6g} m")
STRIP_HEIGHT = Rule(
    "strip",
    "a strip is a part of its vehicle",
    "up to three times the height of the centre of mass, {most:.6g} m",
)
STRIP_LENGTH = Rule("strip", "the strip has no length", "two heights upwards, or two places rearwards")
INSET = Rule(
    "strip", "the strip is beyond the middle of the vehicle", "less than half of the width, {most:.6g} m"
)

SPACE_POSITIVE = {
    "length": "m", "width": "m", "mass": "kg", "centre_of_mass": "m", "centre_height": "m", "roll_inertia": "kg m^2",
    "pitch_inertia": "kg m^2", "yaw_inertia": "kg m^2", "track": "m", "radius": "m", "spring": "N/m", "spacing": "m",
    "tyre": "N/m", "stiffness": "N/m^2", "plateau": "N/m",
}  # fmt: skip
"""Units of quantities of a vehicle in space that are positive."""
SPACE = {name: Rule(name, "it is a size", f"{POSITIVE}, {unit}") for name, unit in SPACE_POSITIVE.items()}
SPACE |= {
    name: Rule(name, "it is not negative", "0 or more, and finite")
    for name in ("hitch_height", "roll_stiffness", "damping_ratio", "roll_centre", "friction", "cornering", "height",
                 "inset", "initial_force", "restitution", "unloading", "hardening")
}  # fmt: skip
"""Rules of a vehicle in space, by the name of the quantity."""
SPACE_STEPS = Rule(
    "axle",
    "the vehicle oscillates at this rate [rad/s], too fast to be followed",
    "softer springs, or more mass",
)
SPACE_LOST = Rule("axle", "the motion became infinite, at this rate [rad/s]", "softer springs, or more mass")
NO_CONTACT = Rule("wall.height", "all strips are above the wall", "more than the lowest strip's lower end, m")
