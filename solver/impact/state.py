"""Columns and workspace of the compiled motion of trains."""

from typing import NamedTuple

import numpy as np

STRIKE = (
    "group",
    "start",
    "end",
    "peak",
    "impulse",
    "tangential",
    "along",
    "place",
    "crush",
    "friction",
    "cut",
)
"""Columns of a strike: number of its group; times [s], greatest force [N], impulses [N s],
impulse times place on the vehicle and along the wall [N s m], works [J], 1 where the motion ends before it is over."""
CUT = STRIKE.index("cut")

UNIT = ("x_g", "y_g", "theta", "v_gx", "v_gy", "omega")
SUMS = ("force_normal", "force_tangential", "crush_energy_stored", "crush_energy_lost", "impulse_normal",
        "impulse_tangential", "impulse_angular", "friction_work", "crush_work")  # fmt: skip
"""Columns of a row: `UNIT` of each unit, then `SUMS` of the train: forces [N], energies stored and lost [J], impulses
[N s] and that of their moment about the origin [N m s], works of friction and on the crush [J]. Of more units than one
follow for each the wall's impulses on it, normal and tangential [N s]."""

ALONG, ACROSS, STIFFNESS, INITIAL, PLATEAU, RESTITUTION, UNLOADING, FRICTION, X, Y = range(10)
DEPTH, EARLIER, AHEAD, DEEPEST, NORMAL, TANGENTIAL, PART, RATE, FOOT, HARDENING, PEAK, LINE = range(10, 22)
"""Columns of points: as in `Train`; arm about the centre of mass; depth now, a step before and a step ahead, from the
deepest mean so far, and that itself [m]; forces [N]; part of the step in which the force acts; for trains the rate of
the depth [m/s] and the depth at which the line of unloading ends, from the deepest [m]; hardening as in `Train`; force
[N] at the deepest point, and length [m] of the line of unloading from there. The line may be shorter than a micrometre:
depths add up the motion of each step, and are no differences of coordinates, whose rounding would change the force."""

SLOT, FIRST, LAST, FORCE, BEFORE, STAMP, WHOLE, AFTER = range(8)
"""Columns of groups: number of the latest strike, its start and end so far [s]; forces of this step and the one
before [N]; the step of the last contact; impulses of the strike and of touches after its end so far, the latest
included [N s]."""


def columns(units):
    """Return the number of a row's columns before those of tyres."""
    return 6 * units + len(SUMS) + (2 * units if units > 1 else 0)


class Work(NamedTuple):
    """Workspace of one sample.

    Columns of its tables are named above. points: a row for each point; point_owner: its unit and group; motion, shape
    (3, 3 units): places and angles, velocities half a step ago and half a step ahead; masses: inverse mass of each
    velocity; load: accelerations by the external load; headings: cosine and sine of each unit's angle, sine and
    versine of its rotation in the step; joints: hitch and kingpin of each hinge; ties: its two conditions, as of
    `step`; reach: from each centre of mass to the farthest point; effect: velocities by a unit impulse along and
    across on each point; groups: a row for each; active: points that may touch in this step; sums: impulses and
    works so far.
    """

    points: np.ndarray
    point_owner: np.ndarray
    motion: np.ndarray
    masses: np.ndarray
    load: np.ndarray
    headings: np.ndarray
    joints: np.ndarray
    ties: np.ndarray
    reach: np.ndarray
    effect: np.ndarray
    groups: np.ndarray
    active: np.ndarray
    sums: np.ndarray


def workspace(units: int, hinges: int, points: int, groups: int) -> Work:
    """Return a workspace for one sample."""
    size = 3 * units
    return Work(
        np.zeros((points, 22)), np.zeros((points, 2), dtype=np.int64), np.zeros((3, size)), np.zeros(size),
        np.zeros(size), np.zeros((units, 4)), np.zeros((hinges, 2)), np.zeros((2 * hinges, 2 * size + 1)),
        np.zeros(units), np.zeros((points, 2, size)), np.zeros((groups, 8)), np.zeros(points, dtype=np.int64),
        np.zeros(columns(units) - 6 * units - 4),
    )  # fmt: skip
