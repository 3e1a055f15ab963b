"""Columns and workspace of the compiled motion in space.

Axes: X along the wall in the direction of travel, Y away from it, Z up; of a body x ahead, y to the left, z up, about
the centre of mass of its sprung mass. The wall is to the right of the vehicle. SI units and radians.
"""

from typing import NamedTuple

import numpy as np

MASS, I_X, I_Y, I_Z, I_XZ, HEIGHT, WHOLE, WHOLE_X, WHOLE_Z = range(9)
HITCH_X, HITCH_Z, KING_X, KING_Z, TWIST, REACH, SENSOR_X, SENSOR_Z = range(9, 17)
"""Columns of a unit.

Sprung mass [kg], its inertias and product of inertia [kg m^2], height at rest [m]; whole mass with axles [kg] and its
centre in the body's axes [m]; hinges to the unit behind and ahead [m]; stiffness in roll of the hinge ahead [N m/rad];
distance of the farthest point that can touch [m]; place of its sensor in the body's axes [m].
"""

PLACE, CENTRE, AXLE_MASS, AXLE_INERTIA, BELOW, LOWEST, HALF_TRACK, HALF_SPACING = range(8)
SPRING, DAMPER, PRELOAD, TYRE, FRICTION, CORNERING = range(8, 14)
"""Columns of an axle.

Place x and height z of its roll centre in the body's axes at rest [m]; mass [kg], inertia in roll and yaw [kg m^2]; its
centre and the lowest points of its unloaded tyres below the roll centre [m]; half of track and spacing [m]; stiffness
[N/m], damping [N s/m] and load at rest of a spring [N], vertical stiffness of the tyres of a side [N/m], their friction
and cornering coefficient [-].
"""

START, END, STIFFNESS, PLATEAU, RETURNED, UNLOADING, LENGTH, THICK, INITIAL, HARDENING = 0, 3, *range(6, 14)
"""Columns of a strip.

Both ends, in the body's axes or about the roll centre of its axle, y to the left [m]; per metre of its length stiffness
[N/m^2], plateau [N/m], and slope of unloading [N/m^2], 0 where the returned part of the energy defines it [-]; length
[m]; half height of a point; force at zero crush [N/m] and slope beyond the plateau's onset [N/m^2] per metre.
"""

WIDTHS = 17, 14, 14
"""Numbers of columns of a unit, an axle and a strip."""

PUSH, BEFORE, STOPPED, GAP, CLOSING, NORMAL, RESPONSE, ADDED, PUSHES = 0, 1, 2, 3, 4, 5, 13, 21, 29
"""First columns of the forces on a strip.

Four rows a strip: of the right side by the face and by the top, then of the left side. Lateral force summed over the
row, and before this step [N], of both in that by the face. Of a strip that returns no energy: the part by which its
force is reduced, -1 without force; the sum of its points' forces times the velocities that would bring them to their
deepest positions, and times their velocities into the wall before the step [W]; its normal force on body and axle; the
accelerations of the body by its force, and the loads on the axle; what it adds to the sums of forces and to both works
of the wall.
"""

FACE, TOP, ABOVE, RAISED = 0, 3, 6, 7
FOOT, SLOPE = 1, 2
"""Columns of a point of a strip.

For the face and for the top the deepest penetration, then the depth at which unloading ends [m] and its slope [N/m], 0
before; part of the point that was above the top behind the edge of the face; of the first point of a strip, 1 where
any point was.
"""

LATERAL, ALONG, UP, MOMENT, STATION, SPREAD, WALL_WORK, FRICTION_WORK, TYRE_WORK, DAMPING_WORK = range(10)
"""Sums of a row, then works on the vehicle up to now [J].

Force on the vehicle away from the wall, along and up [N]; of the first, times height [N m], times place along the
wall ahead of the first unit's sprung centre of mass [N m] and its square [N m^2].
"""

WORKS = ("wall_work", "friction_work", "tyre_work", "damping_work")
"""Works on the vehicle by normal forces and friction of the wall, side forces of tyres, and dampers [J]."""

FORCES = (
    "force_normal",
    "force_tangential",
    "force_vertical",
    "moment_height",
    "moment_station",
    "moment_spread",
)
ENERGIES = ("kinetic_energy", "gravity_energy", "spring_energy", "tyre_energy")
POSE = ("x_g", "y_g", "z_g", "yaw", "pitch", "roll", "v_gx", "v_gy", "v_gz", "omega_x", "omega_y", "omega_z")
SENSOR = ("sensor_velocity",)
"""Velocity of the first unit's sensor away from the wall at the instant [m/s]."""

WHEELS = ("load_right", "load_left", "heave", "axle_roll")
HINGE = ("hinge_force_x", "hinge_force_y", "hinge_force_z")
"""Columns of a row: `FORCES`, `SENSOR`, `WORKS`, `ENERGIES`, then `POSE` of each unit, `WHEELS` of each axle, `HINGE`
of each hinge, the force of the unit behind on the one ahead, and the lateral force on the right and on the left one of
each strip [N]."""

OUTCOME, ROLL, ROLL_TIME, PITCH, PITCH_TIME, MEAN, MEAN_TIME, MEAN_ALONG, MEAN_UP = range(9)
CENTRE_HEIGHT, CONTACT_LENGTH, MOMENT_MEAN, MOMENT_HEIGHT, MOMENT_LENGTH, RAW = range(9, 15)
EXIT_SPEED, EXIT_ANGLE, EXIT_YAW, REACHED, TOUCHED, ROWS_WRITTEN, INERTIAL, ANSWERS = range(15, 23)
"""Columns of an answer.

Outcome; largest roll and pitch with the sign that they have then, and their instants; largest 50 ms mean of the
lateral force, its end, and the means of the other forces then [N]; height of its resultant and length of the uniform
force with the same standard deviation along the wall [m]; largest 50 ms mean of the moment of the lateral force about
the ground [N m], with height and length of the force then [m]; largest mean of an interval [N]; at the last contact
speed [m/s], direction of travel and of the vehicle away from the wall [rad]; end and last contact [s]; rows written;
mass of the first unit times the largest 50 ms mean of the acceleration of its sensor away from the wall [N].
"""

UPRIGHT, ON_ITS_SIDE, OVER, LOST = range(4)
"""Outcomes; the last where the motion became infinite."""

TURNED, AT, SPEED, TURN, SPIN, RATE, NOW, LOAD, MATRIX = 0, 9, 12, 15, 19, 22, 28, 34, 40
LARGEST, BODY_STATE = 76, 79
"""First columns of the state of a body.

Rotation matrix by rows; place and velocity of the sprung centre in space; quaternion; spin in the body's axes;
accelerations of velocity and spin over the last step; velocity and spin at this instant; force and moment in the
body's axes; mass matrix by rows; sine, cosine and instant of the largest roll [s].
"""

JOINT, JOINT_SPEED, JOINT_RATE, JOINT_NOW, JOINT_LOAD, WHEEL = range(0, 12, 2)
COLUMN, SHARE, COSINE, SINE, AXLE_STATE = 12, 24, 27, 28, 29
"""First columns of the state of an axle.

Heave and roll relative to the body, their rates half a step ago and ahead, accelerations, rates at this instant, and
loads; loads of the right and left tyres; mass with that of the body, for heave and for roll; inverse of the own mass;
cosine and sine of the roll.
"""


SENSED = 6
"""Column of `SENSOR` in a row and in the rows of means."""


class Fleet(NamedTuple):
    """Vehicles of n samples, with columns named above.

    units: shape (n, units, 17); axles: (n, axles, 14); strips: (n, strips, 14), of the right side; axle_unit,
    strip_unit: unit of each; strip_axle: axle of each or -1; strip_points: points of each; profile, shape (points, 2):
    of all walls; height, friction: of each wall; speed, angle: of the train at first touch.
    """

    units: np.ndarray
    axles: np.ndarray
    strips: np.ndarray
    axle_unit: np.ndarray
    strip_unit: np.ndarray
    strip_axle: np.ndarray
    strip_points: np.ndarray
    profile: np.ndarray
    height: np.ndarray
    friction: np.ndarray
    speed: np.ndarray
    angle: np.ndarray


class Clock(NamedTuple):
    """Steps of n samples.

    interval: of a row [s]; parts, shape (n,): steps in it; window: rows of the mean; longest: latest end [s];
    is_end_fixed: True if the end is the longest, whatever the motion; push, shape (rows, 5): force on the first unit in
    each interval, see `solve_space`.
    """

    interval: float
    parts: np.ndarray
    window: int
    longest: float
    is_end_fixed: bool
    push: np.ndarray


class SpaceWork(NamedTuple):
    """Workspace of one sample.

    bodies, shape (units, 79); joints, shape (axles, 29); wall, (facets, 7): from y, z to y, z, normal and dy/dz;
    memory, (points of both sides, 8); pushes, (4 strips, 29); sums, (10,): sums of the row and works;
    effect, (6 hinges, 6): accelerations of both units by unit forces; tie, (3 hinges, 3 hinges + 1), flat; windows,
    (rows, 7): means of the rows so far;
    before, (10,): sums before the step; pulls, (2, 3 hinges): forces of hinges summed over the row, and before the step
    [N]; answer, rolls: of one motion in a search for a wall.
    """

    bodies: np.ndarray
    joints: np.ndarray
    wall: np.ndarray
    memory: np.ndarray
    pushes: np.ndarray
    sums: np.ndarray
    effect: np.ndarray
    tie: np.ndarray
    windows: np.ndarray
    before: np.ndarray
    pulls: np.ndarray
    answer: np.ndarray
    rolls: np.ndarray


def workspace(units: int, axles: int, strips: int, points: int, facets: int, rows: int) -> SpaceWork:
    """Return a workspace for one sample."""
    hinges = units - 1
    return SpaceWork(
        np.zeros((units, BODY_STATE)), np.zeros((axles, AXLE_STATE)), np.zeros((facets, 7)),
        np.zeros((2 * points, 8)), np.zeros((4 * strips, PUSHES)), np.zeros(10), np.zeros((6 * hinges, 6)),
        np.zeros(3 * hinges * (3 * hinges + 1)), np.zeros((rows, 7)), np.zeros(10), np.zeros((2, 3 * hinges)),
        np.zeros(ANSWERS), np.zeros(units),
    )  # fmt: skip


def column_names(units: int, axles: int) -> tuple[str, ...]:
    """Return the column names of a row."""
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    poses = [f"{name}{end}" for end in ends for name in POSE]
    wheels = [f"{name}_{axle}" for axle in range(1, axles + 1) for name in WHEELS]
    pulls = [f"{name}_{hinge}" for hinge in range(1, units) for name in HINGE]
    return (*FORCES, *SENSOR, *WORKS, *ENERGIES, *poses, *wheels, *pulls)


def row_columns(units: int, axles: int, strips: int) -> int:
    """Return the number of columns of a row."""
    return len(column_names(units, axles)) + 2 * strips


FIRST_ROLL = column_names(1, 0).index("roll")
"""Column of the roll of the first unit in a row."""
