"""Compiled columns of vehicles in space, from the values of their parts.

The sprung mass of a unit is what remains without its axles. Springs and tyres carry the vehicle at rest with its floor
level: their loads follow from the levers of the axles, of more than two from loads that vary linearly along the unit.
"""

import math
from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from solver.body import GRAVITY
from solver.impact.strips import ROUNDING
from solver.impact.tyres import set_axle_loads
from solver.space import state as col

AXLE_GYRATION = math.sqrt(1.0 / 6.0)
"""Assumed radius of gyration of an axle over the track: half of its mass in the wheels, half along the beam."""

SLACK = 1.0
"""Largest heave of an axle that is assumed where the distance from the wall is judged [m]."""

EDGE, LEAST = 0.02, 1e-4
"""Half heights within which a strip along the vehicle passes the top, and of an upright point at least [m]."""

LENGTH, WIDTH, MASS, CENTRE, CENTRE_HEIGHT, ROLL, PITCH, YAW, HITCH, KINGPIN, HITCH_HEIGHT, TWIST = range(12)
POSITION, TRACK, RADIUS, AXLE_MASS, SPRING, SPACING, TYRE, DAMPING, ROLL_CENTRE, FRICTION, CORNERING = range(
    11
)
AT, HEIGHT, STIFFNESS, INSET, PLATEAU, RESTITUTION, UNLOADING, INITIAL, HARDENING = 0, 2, *range(4, 11)
"""Values of a unit, an axle and a strip, in the order of their fields; both ends of a strip from `AT` and `HEIGHT`."""

REASONS = (
    "", "SPRUNG", "CENTRE_ABOVE", "SPRUNG_INERTIA", "SPRUNG_INERTIA", "SPRUNG_INERTIA", "AXLE", "AXLE_LOAD",
    "STRIP_AT", "STRIP_HEIGHT", "STRIP_LENGTH", "INSET", "HARDENING",
)  # fmt: skip
"""Rules by the number of the reason why a sample is impossible; the inertias are in roll, pitch and yaw."""

PLACES = (
    ("", ""), ("units", "mass"), ("units", "centre_height"), ("units", "roll_inertia"), ("units", "pitch_inertia"),
    ("units", "yaw_inertia"), ("axles", "position"), ("axles", "position"), ("strips", "at"), ("strips", "height"),
    ("strips", "height"), ("strips", "inset"), ("strips", "hardening"),
)  # fmt: skip
"""Part and quantity that a reason refuses."""

POSSIBLE, LIGHT, LOW, OF_ROLL, _, OF_YAW, OUTSIDE, LIFTED = range(8)
STRIP_OUTSIDE, STRIP_HIGH, STRIP_SHORT, STRIP_INSET, STRIP_HARD = range(8, 13)


class Values(NamedTuple):
    """Values of n vehicles, and room for the loads of one.

    units, shape (n, units, 12); axles, (n, axles, 11); strips, (n, strips, 11); sensor, (n, 2): behind the front and
    above the ground, NaN for the sprung centre. mass, hitch, kingpin, along, load: of `set_axle_loads`, (m, 1).
    """

    units: np.ndarray
    axles: np.ndarray
    strips: np.ndarray
    sensor: np.ndarray
    mass: np.ndarray
    hitch: np.ndarray
    kingpin: np.ndarray
    along: np.ndarray
    load: np.ndarray


def room_for(n: int, units: int, axles: int, strips: int) -> Values:
    """Return values of n vehicles, of 0, without a sensor."""
    shapes = (n, units, 12), (n, axles, 11), (n, strips, 11)
    loads = ((m, 1) for m in (units, units - 1, units - 1, axles, axles))
    return Values._make([*map(np.zeros, shapes), np.full((n, 2), math.nan), *map(np.zeros, loads)])


@compact
def fill(values, fleet):
    """Fill units, axles and strips of all samples.

    Returns the reason why one is impossible, its sample, the number of its unit, axle or strip, and the limit of the
    value.
    """
    for i in range(fleet.units.shape[0]):
        reason, item, limit = fill_sample(values, fleet, i)
        if reason != POSSIBLE:
            return reason, i, item, limit
    return POSSIBLE, 0, 0, 0.0


@compact
def fill_rates(fleet, rates):
    """Fill the highest frequencies of all samples [rad/s]."""
    for i in range(rates.size):
        rates[i] = fastest(fleet, i)


@compiled
def fill_sample(values, fleet, i):
    """Fill the columns of sample i, see `fill`."""
    for u in range(fleet.units.shape[1]):
        reason, limit = _set_unit(values, fleet, i, u)
        if reason != POSSIBLE:
            return reason, u, limit
    _set_loads(values, fleet, i)
    for a in range(fleet.axles.shape[1]):
        reason, limit = _set_axle(values, fleet, i, a)
        if reason != POSSIBLE:
            return reason, a, limit
    for k in range(fleet.strips.shape[1]):
        reason, limit = _set_strip(values, fleet, i, k)
        if reason != POSSIBLE:
            return reason, k, limit
    return POSSIBLE, 0, 0.0


@compiled
def _sprung(values, fleet, i, u):
    """Return the sprung mass, its place and height."""
    unit = values.units[i, u]
    unsprung, along, up = 0.0, 0.0, 0.0
    for a in range(fleet.axle_unit.size):
        if fleet.axle_unit[a] == u:
            axle = values.axles[i, a]
            unsprung += axle[AXLE_MASS]
            along += axle[AXLE_MASS] * axle[POSITION]
            up += axle[AXLE_MASS] * axle[RADIUS]
    mass = unit[MASS] - unsprung
    return mass, (along - unit[MASS] * unit[CENTRE]) / mass, (unit[MASS] * unit[CENTRE_HEIGHT] - up) / mass


@compiled
def _set_unit(values, fleet, i, u):
    """Fill a unit.

    Returns the reason why it is impossible, and the limit.
    """
    unit, column, (mass, place, height) = values.units[i, u], fleet.units[i, u], _sprung(values, fleet, i, u)
    if not mass > 0.0:
        return LIGHT, unit[MASS] - mass
    x, z = -unit[CENTRE] - place, unit[CENTRE_HEIGHT] - height
    roll, pitch, yaw, product = mass * z * z, mass * (x * x + z * z), mass * x * x, mass * x * z
    for a in range(fleet.axle_unit.size):
        if fleet.axle_unit[a] == u:
            axle = values.axles[i, a]
            if not unit[CENTRE_HEIGHT] > axle[RADIUS]:
                return LOW, axle[RADIUS]
            m, dx, dz = axle[AXLE_MASS], unit[CENTRE] - axle[POSITION], axle[RADIUS] - unit[CENTRE_HEIGHT]
            turned = m * (AXLE_GYRATION * axle[TRACK]) ** 2
            roll, pitch, yaw = (
                roll + m * dz * dz + turned,
                pitch + m * (dx * dx + dz * dz),
                yaw + m * dx * dx + turned,
            )
            product += m * dx * dz
    for k, least in ((0, roll), (1, pitch), (2, yaw)):
        if not unit[ROLL + k] > least:
            return OF_ROLL + k, least
        column[col.I_X + k] = unit[ROLL + k] - least
    column[col.MASS], column[col.I_XZ], column[col.HEIGHT] = mass, -product, height
    column[col.WHOLE], column[col.WHOLE_X], column[col.WHOLE_Z] = unit[MASS], x, z
    behind = values.units[i, min(u + 1, fleet.units.shape[1] - 1)]
    column[col.HITCH_X], column[col.HITCH_Z] = -behind[HITCH] - place, behind[HITCH_HEIGHT] - height
    column[col.KING_X], column[col.KING_Z] = -unit[KINGPIN] - place, unit[HITCH_HEIGHT] - height
    column[col.TWIST], column[col.REACH] = unit[TWIST], _reach(values, fleet, i, u, place, height)
    column[col.SENSOR_X], column[col.SENSOR_Z] = 0.0, 0.0
    if u == 0 and not np.isnan(values.sensor[i, 0]):
        column[col.SENSOR_X], column[col.SENSOR_Z] = (
            -values.sensor[i, 0] - place,
            values.sensor[i, 1] - height,
        )
    return POSSIBLE, 0.0


@compiled
def _reach(values, fleet, i, u, place, height):
    """Return the largest distance of strips from the sprung centre [m]."""
    unit, up = values.units[i, u], 0.0
    for k in range(fleet.strip_unit.size):
        if fleet.strip_unit[k] == u:
            for end in range(2):
                up = max(up, abs(values.strips[i, k, HEIGHT + end] - height))
    along = max(abs(place), abs(unit[LENGTH] + place))
    return SLACK + np.sqrt(along * along + up * up + 0.25 * unit[WIDTH] * unit[WIDTH])


@compiled
def _set_loads(values, fleet, i):
    """Fill the loads of the axles at rest [N]."""
    for u in range(fleet.units.shape[1]):
        unit = values.units[i, u]
        values.mass[u, 0] = unit[MASS]
        if u > 0:
            values.hitch[u - 1, 0] = values.units[i, u - 1, CENTRE] - unit[HITCH]
            values.kingpin[u - 1, 0] = unit[CENTRE] - unit[KINGPIN]
    for a in range(fleet.axle_unit.size):
        values.along[a, 0] = values.units[i, fleet.axle_unit[a], CENTRE] - values.axles[i, a, POSITION]
    set_axle_loads(values.mass, values.hitch, values.kingpin, fleet.axle_unit, values.along, values.load, 0)


@compiled
def _set_axle(values, fleet, i, a):
    """Fill an axle.

    Returns the reason why it is impossible, and the limit.
    """
    axle, column, u = values.axles[i, a], fleet.axles[i, a], fleet.axle_unit[a]
    length, load = values.units[i, u, LENGTH], values.load[a, 0]
    if not (axle[POSITION] >= 0.0 and axle[POSITION] <= length):
        return OUTSIDE, length
    carried = load - GRAVITY * axle[AXLE_MASS]
    if not carried >= 0.0:
        return LIFTED, carried
    _, place, height = _sprung(values, fleet, i, u)
    preload = 0.5 * carried
    column[col.PLACE], column[col.CENTRE] = -axle[POSITION] - place, axle[ROLL_CENTRE] - height
    column[col.AXLE_MASS] = axle[AXLE_MASS]
    column[col.AXLE_INERTIA] = axle[AXLE_MASS] * (AXLE_GYRATION * axle[TRACK]) ** 2
    column[col.BELOW] = axle[ROLL_CENTRE] - axle[RADIUS]
    column[col.LOWEST] = axle[ROLL_CENTRE] + 0.5 * load / axle[TYRE]
    column[col.HALF_TRACK], column[col.HALF_SPACING] = 0.5 * axle[TRACK], 0.5 * axle[SPACING]
    column[col.SPRING], column[col.PRELOAD], column[col.TYRE] = axle[SPRING], preload, axle[TYRE]
    column[col.DAMPER] = 2.0 * axle[DAMPING] * np.sqrt(axle[SPRING] * preload / GRAVITY)
    column[col.FRICTION], column[col.CORNERING] = axle[FRICTION], axle[CORNERING]
    return POSSIBLE, 0.0


@compiled
def _set_strip(values, fleet, i, k):
    """Fill a strip.

    Returns the reason why it is impossible, and the limit.
    """
    strip, column, u = values.strips[i, k], fleet.strips[i, k], fleet.strip_unit[k]
    unit, (_, place, height) = values.units[i, u], _sprung(values, fleet, i, u)
    x0, x1, z0, z1 = strip[AT], strip[AT + 1], strip[HEIGHT], strip[HEIGHT + 1]
    if not (min(x0, x1) >= 0.0 and max(x0, x1) <= unit[LENGTH] * (1.0 + ROUNDING)):
        return STRIP_OUTSIDE, unit[LENGTH]
    if not max(z0, z1) <= 3.0 * unit[CENTRE_HEIGHT]:
        return STRIP_HIGH, 3.0 * unit[CENTRE_HEIGHT]
    if not (z1 > z0 or x1 > x0):
        return STRIP_SHORT, 0.0
    if not strip[INSET] < 0.5 * unit[WIDTH]:
        return STRIP_INSET, 0.5 * unit[WIDTH]
    rises = strip[HARDENING] == 0.0 or (strip[HARDENING] <= strip[STIFFNESS] and strip[PLATEAU] < math.inf)
    if not rises:
        return STRIP_HARD, strip[STIFFNESS]
    base = height
    if fleet.strip_axle[k] >= 0:
        base = values.axles[i, fleet.strip_axle[k], ROLL_CENTRE]
    length = np.hypot(x1 - x0, z1 - z0)
    for end in range(2):
        column[col.START + 3 * end] = -strip[AT + end] - place
        column[col.START + 3 * end + 1] = 0.5 * unit[WIDTH] - strip[INSET]
        column[col.START + 3 * end + 2] = strip[HEIGHT + end] - base
    column[col.STIFFNESS], column[col.PLATEAU] = strip[STIFFNESS], strip[PLATEAU]
    column[col.RETURNED], column[col.UNLOADING] = strip[RESTITUTION] * strip[RESTITUTION], strip[UNLOADING]
    column[col.LENGTH], column[col.THICK] = length, max(EDGE * abs(x1 - x0) / length, LEAST)
    column[col.INITIAL], column[col.HARDENING] = strip[INITIAL], strip[HARDENING]
    return POSSIBLE, 0.0


@compiled
def fastest(fleet, i):
    """Estimate the highest frequency of sample i [rad/s]."""
    upward, square = 0.0, 0.0
    for p in range(fleet.profile.shape[0] - 1):
        dy = fleet.profile[p + 1, 0] - fleet.profile[p, 0]
        dz = fleet.profile[p + 1, 1] - fleet.profile[p, 1]
        upward = max(upward, dy * dy / (dy * dy + dz * dz))
    for a in range(fleet.axle_unit.size):
        axle = fleet.axles[i, a]
        vertical = 2.0 * (axle[col.TYRE] + axle[col.SPRING])
        turning = 2.0 * (
            axle[col.TYRE] * axle[col.HALF_TRACK] ** 2 + axle[col.SPRING] * axle[col.HALF_SPACING] ** 2
        )
        for k in range(fleet.strip_axle.size):
            if fleet.strip_axle[k] == a:
                vertical += upward * fleet.strips[i, k, col.STIFFNESS] * fleet.strips[i, k, col.LENGTH]
        square = max(square, vertical / axle[col.AXLE_MASS], turning / axle[col.AXLE_INERTIA])
    for k in range(fleet.strip_unit.size):
        crush = fleet.strips[i, k, col.STIFFNESS] * fleet.strips[i, k, col.LENGTH]
        square = max(square, 4.0 * crush / fleet.units[i, fleet.strip_unit[k], col.MASS])
    for u in range(fleet.units.shape[1] if fleet.units.shape[1] > 1 else 0):
        square = max(square, fleet.units[i, u, col.TWIST] / fleet.units[i, u, col.I_X])
    return np.sqrt(square)
