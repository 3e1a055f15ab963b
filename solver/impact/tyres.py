"""Tyres of a train, with loads in equilibrium.

Loads are those at rest. Axles of a vehicle have springs of one stiffness; those of a trailer have equal loads, and its
kingpin loads the unit ahead at the hitch. Compiled side forces are taken at the velocities of the instant, which
are extrapolated from the step before: the scheme stays of second order.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fem.laws.contact_forces import side_force
from machine_code.compiled import compiled
from solver import rules
from solver.body import GRAVITY
from solver.conditions import Array, Gate, demand
from solver.impact.train import Train

CORNERING = 6.0
"""Assumed value of C for a dual-tyred truck axle."""

OFF_CENTRE = 1e-3
"""Largest distance of a lone axle from the place at which it carries its unit in balance [m]."""

AXLE = ("position", "friction", "cornering")
"""Quantities of an axle, besides its unit."""

SUMS = ("tyre_work", "tyre_impulse_tangential", "tyre_impulse_normal", "tyre_impulse_angular")
"""Columns of each unit: work of its tyres on it [J], their impulses along and across the wall [N s], and that of their
moment about the origin [N m s]."""


class Tyres(NamedTuple):
    """Axles of n trains and workspace, without axles where none has friction.

    unit, shape (axles,): of each axle; along, load, friction, cornering, shape (axles, n): from the unit's centre of
    mass along its heading [m], N [N], mu and C [-]. Workspace of one sample: force, shape (axles,), side force to the
    left [N]; rate, shape (3 units,), mean accelerations of the step before; sums, shape (4 units,), as of `SUMS`, both
    empty without axles.
    """

    unit: np.ndarray
    along: np.ndarray
    load: np.ndarray
    friction: np.ndarray
    cornering: np.ndarray
    force: np.ndarray
    rate: np.ndarray
    sums: np.ndarray


@dataclass(frozen=True)
class TyreAxle:
    """Axle whose tyres oppose sliding across the heading.

    Parameters
    ----------
    position : float
        Distance behind the front of its unit [m].
    friction : float
        Friction coefficient mu of the tyres across, on the road [-]; 0: no side force.
    cornering : float
        Cornering coefficient C, side force over load and slip angle at small slip [-].
    unit : int
        Number of its unit in a train, from 0.
    """

    position: float
    friction: float = 0.0
    cornering: float = CORNERING
    unit: int = 0


def tyres_of(train: Train, axles: Sequence[Mapping[str, Any]], centres: Array, lengths: Array) -> Tyres:
    """Return the tyres of n trains, with loads in equilibrium.

    There are no axles where none has friction. axles: fields of `TyreAxle` for each axle, floats or of shape (n,);
    centres: of mass, behind the front, and lengths of the units [m], shape (units, n). Raises RigidBodyError for an
    axle outside its unit, negative values, and axles that cannot carry a unit.
    """
    if not axles:
        return no_tyres(train)
    count, n = train.mass.shape
    unit = np.array([int(axle["unit"]) for axle in axles])
    position, friction, cornering = (
        np.array([np.broadcast_to(np.asarray(axle[name], dtype=np.float64), n) for axle in axles])
        for name in AXLE
    )
    for a, u in enumerate(unit):
        demand(rules.AXLE_UNIT, f"axle.{a}.unit", bool(0 <= u < count), u, most=count - 1)
        inside = (position[a] >= 0.0) & (position[a] <= lengths[u])
        demand(rules.AXLE, f"axle.{a}.position", inside, position[a], length=lengths[u])
        for name, values in (("friction", friction), ("cornering", cornering)):
            Gate().not_negative(rules.TYRE._replace(key=f"axle.{a}.{name}"), values[a])
    along = centres[unit] - position
    load = axle_loads(train.mass, train.hitch, train.kingpin, unit, along)
    for a in range(len(unit)):
        demand(rules.AXLE_LOAD, f"axle.{a}.position", load[a] >= 0.0, position[a])
    if not friction.any():
        return no_tyres(train)
    workspace = np.zeros(len(unit)), np.zeros(3 * count), np.zeros(count * len(SUMS))
    return Tyres(unit, along, load, friction, cornering, *workspace)


def no_tyres(train: Train) -> Tyres:
    """Return tyres without axles."""
    nothing = np.zeros((0, train.mass.shape[1]))
    return Tyres(np.zeros(0, dtype=np.int64), *4 * (nothing,), np.zeros(0), np.zeros(0), np.zeros(0))


def axle_loads(mass: Array, hitch: Array, kingpin: Array, unit: NDArray[np.int64], along: Array) -> Array:
    """Return the loads of the axles at rest [N], shape (axles, n).

    mass: of each unit [kg], shape (units, n); hitch, kingpin: distance of each hinge ahead of the centres of mass of
    the units that it joins [m], shape (units - 1, n); unit: number of each axle's unit, from 0; along: distance of the
    axles ahead of the centre of mass of their unit [m], shape (axles, n).
    """
    load = np.zeros(along.shape)
    count = along.shape[1]
    of_units = [np.ascontiguousarray(values).reshape(-1, count) for values in (mass, hitch, kingpin)]
    for i in range(count):
        set_axle_loads(*of_units, np.ascontiguousarray(unit), np.ascontiguousarray(along), load, i)
    return load


@compiled
def set_axle_loads(mass, hitch, kingpin, unit, along, load, i):
    """Set the loads of the axles of a sample.

    They follow from the last unit on.
    """
    pressed = 0.0  # by the kingpin of the unit behind
    for u in range(mass.shape[0] - 1, -1, -1):
        weight, ahead, pin = GRAVITY * mass[u, i], 0.0, 0.0
        if u < hitch.shape[0]:
            ahead = hitch[u, i]
        if u > 0:
            pin = kingpin[u - 1, i]
        count, first, second = 0.0, 0.0, 0.0
        for a in range(unit.size):
            if unit[a] == u:
                count, first, second = count + 1.0, first + along[a, i], second + along[a, i] ** 2
        force, moment, slope = weight + pressed, pressed * ahead, 0.0
        spread = count * second - first**2
        if u > 0 and count > 0.0:
            force = count * (moment - force * pin) / (first - count * pin)
        elif spread > 1e-9 * max(second, 1e-300):
            slope = (count * moment - first * force) / spread
        elif u == 0 and abs(first * force - count * moment) > OFF_CENTRE * count * abs(force):
            force = -np.inf  # of axles ever closer to each other
        for a in range(unit.size):
            if unit[a] == u:
                load[a, i] = (force - slope * first) / count + slope * along[a, i]
        pressed = weight + pressed - force if u > 0 and count > 0.0 else 0.0


@compiled
def start_tyres(tyres, i, masses, headings, load, motion, h):
    """Begin sample i.

    Velocities half a step back are those by the side forces at the start.
    """
    tyres.sums[:], tyres.rate[:] = 0.0, 0.0
    for m in range(motion.shape[1]):
        motion[1, m] = motion[2, m] + 0.5 * h * load[m]
    for u in range(headings.shape[0]):
        headings[u, 0], headings[u, 1] = np.cos(motion[0, 3 * u + 2]), np.sin(motion[0, 3 * u + 2])
    steer(tyres, i, masses, headings, motion, 0.0, -0.5 * h)
    _add_tyres(tyres, i, headings, motion, -0.5 * h, tyres.sums)
    for m in range(motion.shape[1]):
        tyres.rate[m] = (motion[1, m] - motion[2, m]) / (0.5 * h)


@compiled
def steer(tyres, i, masses, headings, motion, last, kick):
    """Add the side forces of this instant to the velocities ahead."""
    for a in range(tyres.unit.size):
        j, arm = 3 * tyres.unit[a], tyres.along[a, i]
        c, s = headings[tyres.unit[a], 0], headings[tyres.unit[a], 1]
        u = motion[1, j] + 0.5 * last * tyres.rate[j]
        v = motion[1, j + 1] + 0.5 * last * tyres.rate[j + 1]
        w = motion[1, j + 2] + 0.5 * last * tyres.rate[j + 2]
        ahead, across = u * c - v * s, u * s + v * c + w * arm
        force = side_force(tyres.load[a, i], tyres.friction[a, i], tyres.cornering[a, i], ahead, across)
        tyres.force[a] = force
        motion[2, j] += kick * masses[j] * force * s
        motion[2, j + 1] += kick * masses[j + 1] * force * c
        motion[2, j + 2] += kick * masses[j + 2] * force * arm


@compiled
def _add_tyres(tyres, i, headings, motion, h, sums):
    """Add impulses and works of the tyres over h to the sums.

    sums: shape (4 units,), those of each unit together.
    """
    for a in range(tyres.unit.size):
        j, arm, impulse, first = 3 * tyres.unit[a], tyres.along[a, i], h * tyres.force[a], 4 * tyres.unit[a]
        c, s = headings[tyres.unit[a], 0], headings[tyres.unit[a], 1]
        u, v = motion[1, j] + motion[2, j], motion[1, j + 1] + motion[2, j + 1]
        w = motion[1, j + 2] + motion[2, j + 2]
        sums[first] += 0.5 * impulse * (u * s + v * c + w * arm)
        sums[first + 1] += impulse * s
        sums[first + 2] += impulse * c
        sums[first + 3] += impulse * ((motion[0, j] + arm * c) * c - (motion[0, j + 1] - arm * s) * s)


@compiled
def end_tyre_step(tyres, i, headings, motion, kick):
    """Add impulses and works of the tyres over a step.

    Its accelerations are stored for the next.
    """
    _add_tyres(tyres, i, headings, motion, kick, tyres.sums)
    for m in range(motion.shape[1]):
        tyres.rate[m] = (motion[2, m] - motion[1, m]) / kick


@compiled
def record_tyres(tyres, i, headings, motion, h, row):
    """Fill the columns of the tyres in the row of this instant.

    h: time since the end of the sums [s].
    """
    columns = row[row.size - tyres.sums.size :]
    for k in range(columns.size):
        columns[k] = tyres.sums[k]
    _add_tyres(tyres, i, headings, motion, h, columns)
