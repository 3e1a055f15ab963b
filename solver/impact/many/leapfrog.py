"""One step of many impacts at once: leapfrog, each impact with a step of its own that ends where a point's mode does.

Arrays have the shape (n,), those of the four corners (4, n). Forces follow from the positions, so that half a kick,
a drift and half a kick are exact to second order; what is not smooth lies at the ends of steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.elementary import Array
from solver.impact.crush_law import line_length, line_share, virgin_force

PHASE = 0.02  # rad of the stiffest oscillation in a step
TURN = 0.02  # rad of rotation in a step
LEAST = 2e-3  # shortest step before an event, as a share of the longest
SWEEPS = 40  # over the corners, where friction brings several to rest
LEAST_RESTITUTION = 0.02  # an upright line is made as steep as this


class Batch(NamedTuple):
    """What does not change: law, friction, body; corners as (4, n) from the centre of mass along and across [m]."""

    stiffness: Array
    initial_force: Array
    restitution: Array
    friction: Array
    mass: Array
    inertia: Array
    along: Array
    across: Array
    reach: Array


class Moving(NamedTuple):
    """Time, position, velocity and greatest crushes of every impact; SI."""

    t: Array
    y: Array
    theta: Array
    v_x: Array
    v_y: Array
    omega: Array
    most: Array


class Pushed(NamedTuple):
    """Crush, its rate, velocity along the wall, levers, and normal force of the corners, shape (4, n)."""

    crush: Array
    rate: Array
    v_x: Array
    r_x: Array
    r_y: Array
    normal: Array


def pushed(batch: Batch, at: Moving) -> Pushed:
    """The corners at a state, forces from the positions."""
    c, s = np.cos(at.theta), np.sin(at.theta)
    r_x, r_y = batch.along * c + batch.across * s, batch.across * c - batch.along * s
    crush = -(at.y + r_y)
    line = virgin_force(batch, at.most) * line_share(batch, crush, at.most)
    pressed = np.where(crush >= at.most, virgin_force(batch, crush), line)
    normal = np.where(crush > 0.0, pressed, 0.0)
    return Pushed(crush, -(at.v_y + at.omega * r_x), at.v_x - at.omega * r_y, r_x, r_y, normal)


_BODY = ("friction", "mass", "inertia")


def accelerations(batch: Batch, p: Pushed, omega: Array, h: Array) -> tuple[Array, Array, Array]:
    """Of the centre of mass along X and Y, and about it, during a kick of h [s].

    A corner that friction brings to rest within the kick sticks; corners in turn (Gauss-Seidel), for two may stick.
    """
    limit = batch.friction * p.normal
    tangential = -limit * np.sign(p.v_x)
    lightness = 1.0 / batch.mass + p.r_y**2 / batch.inertia
    v_lost = h * (_most_along(batch, p, omega, limit) + limit * lightness)
    slow = (limit > 0.0) & (np.abs(p.v_x) <= v_lost)
    for rows, sweeps in ((slow.sum(axis=0) == 1, 1), (slow.sum(axis=0) > 1, SWEEPS)):
        if rows.any():
            some = Pushed(*(value[:, rows] for value in p))
            few = batch._replace(**{key: getattr(batch, key)[rows] for key in _BODY})
            start = np.where(slow[:, rows], 0.0, tangential[:, rows])
            tangential[:, rows] = _stuck(few, some, omega[rows], h[rows], start, sweeps)
    torque = (p.r_x * p.normal - p.r_y * tangential).sum(axis=0)
    return tangential.sum(axis=0) / batch.mass, p.normal.sum(axis=0) / batch.mass, torque / batch.inertia


def _most_along(batch: Batch, p: Pushed, omega: Array, limit: Array) -> Array:
    """Bound of a corner's acceleration along the wall by all forces."""
    most = (np.abs(p.r_x) * p.normal + np.abs(p.r_y) * limit).sum(axis=0) / batch.inertia
    return limit.sum(axis=0) / batch.mass + most * np.abs(p.r_y) + omega**2 * np.abs(p.r_x)


def _stuck(batch: Batch, p: Pushed, omega: Array, h: Array, tangential: Array, sweeps: int) -> Array:
    """Friction at the corners: what stops each within the kick, or its limit."""
    lightness = 1.0 / batch.mass + p.r_y**2 / batch.inertia
    limit, out = batch.friction * p.normal, tangential.copy()
    u, w = out.sum(axis=0) / batch.mass, (p.r_x * p.normal - p.r_y * out).sum(axis=0) / batch.inertia
    for i in list(range(4)) * sweeps:
        demanded = u - w * p.r_y[i] - omega**2 * p.r_x[i] + p.v_x[i] / h
        new = np.clip(out[i] - demanded / lightness[i], -limit[i], limit[i])
        u, w = u + (new - out[i]) / batch.mass, w - (new - out[i]) * p.r_y[i] / batch.inertia
        out[i] = new
    return out


def kicked(at: Moving, by: tuple[Array, Array, Array], h: Array) -> Moving:
    """Velocities after h under the accelerations."""
    return at._replace(v_x=at.v_x + h * by[0], v_y=at.v_y + h * by[1], omega=at.omega + h * by[2])


def stepped(batch: Batch, at: Moving, p: Pushed, h: Array) -> tuple[Moving, Pushed]:
    """The state and its corners after a step; h is 0 for an impact that is over."""
    half = np.where(h > 0.0, 0.5 * h, 1e-12)
    at = kicked(at, accelerations(batch, p, at.omega, half), 0.5 * h)
    at = at._replace(t=at.t + h, y=at.y + h * at.v_y, theta=at.theta - h * at.omega)
    p = pushed(batch, at)
    at = kicked(at, accelerations(batch, p, at.omega, half), 0.5 * h)
    at = at._replace(most=np.maximum(at.most, p.crush))
    return at, p._replace(rate=-(at.v_y + at.omega * p.r_x), v_x=at.v_x - at.omega * p.r_y)


def step_of(batch: Batch, at: Moving, p: Pushed) -> Array:
    """The next step of every impact, to its next event at most."""
    touch = np.maximum(at.most - line_length(batch, at.most), 0.0)
    slope = _slope(batch, at, p)
    lightness = 1.0 / batch.mass + (p.r_x**2 + batch.friction * np.abs(p.r_x * p.r_y)) / batch.inertia
    stiffest = np.sqrt(batch.stiffness * lightness.max(axis=0))
    frequency = np.sqrt((slope * lightness).sum(axis=0))
    longest = PHASE / np.maximum(frequency, 1e-300)
    turn = TURN / np.maximum(np.abs(at.omega), 1e-300)
    _, a_y, w = accelerations(batch, p, at.omega, longest)
    bend = -(a_y + w * p.r_x - at.omega**2 * p.r_y)
    free = p.normal <= 0.0
    flat = at.omega**2 * batch.reach + np.abs(np.where(free.all(axis=0), 0.0, bend))
    ahead = np.where(
        free,
        _root(touch - p.crush, -p.rate, -flat),
        np.where(p.crush >= at.most, _root(p.rate, bend, 0.0 * bend), _on_line(at, p, touch, bend)),
    )
    least = LEAST * PHASE / stiffest
    return np.minimum(np.minimum(longest, turn), np.maximum(ahead.min(axis=0), least))


def _on_line(at: Moving, p: Pushed, touch: Array, bend: Array) -> Array:
    """To either end of the unloading line."""
    leave, over = p.crush - touch, at.most - p.crush
    return np.minimum(_root(leave, p.rate, bend), _root(over, -p.rate, -bend))


def _slope(batch: Batch, at: Moving, p: Pushed) -> Array:
    """Of each corner's force over its crush; 0 where it is free."""
    length = line_length(batch, at.most)
    line = np.divide(virgin_force(batch, at.most), length, out=np.zeros_like(length), where=length > 0.0)
    return np.where(
        p.normal > 0.0, np.where((p.crush >= at.most) & (p.rate > 0.0), batch.stiffness, line), 0.0
    )


def _root(value: Array, rate: Array, bend: Array) -> Array:
    """The first h > 0 at which value + rate h + bend h^2/2 falls to 0; infinite where it never does."""
    value = np.maximum(value, 0.0)
    inside = rate * rate - 2.0 * bend * value
    below = np.sqrt(np.maximum(inside, 0.0)) - rate
    falls = (inside >= 0.0) & (below > 0.0)
    return np.where(falls, 2.0 * value / np.where(falls, below, 1.0), np.inf)
