"""Stick or slip: which touching points without velocity along the wall begin to slide.

Their friction keeps them from sliding, or comes nearest to it: the accelerations of the body minimise Gauss's function
    m (u - u0)^2/2 + I (w - w0)^2/2 + sum of mu N_i |a_i|,   a_i = u - w y_i - omega^2 x_i,
with u = a_gx and w = d omega/dt, u0 and w0 those of all other forces. It is strictly convex, so they are unique.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.elementary import Array

_BISECTIONS = 200
_REST = 1e-9  # a point is at rest below this share of the accelerations at work


class Candidates(NamedTuple):
    """Points without velocity along the wall; arrays of shape (n,).

    Attributes
    ----------
    y : ndarray
        From the centre of mass, along Y [m].
    centripetal : ndarray
        omega^2 x [m/s^2].
    limit : ndarray
        mu N [N].
    """

    y: Array
    centripetal: Array
    limit: Array


class Body(NamedTuple):
    """Mass [kg], yaw inertia [kg m^2], and their accelerations u0 [m/s^2], w0 [rad/s^2] without the candidates."""

    mass: float
    inertia: float
    u: float
    w: float


def sliding_of(body: Body, points: Candidates) -> Array:
    """Sign of the sliding that begins at each candidate, 0 where it sticks; shape (n,)."""
    u, w = _one(body, points) if points.y.size == 1 else _several(body, points)
    acceleration = u - w * points.y - points.centripetal
    scale = abs(body.u) + np.abs(body.w * points.y).max() + np.abs(points.centripetal).max()
    scale += points.limit.sum() * (1.0 / body.mass + (points.y**2).max() / body.inertia)
    return np.where(np.abs(acceleration) <= _REST * scale, 0.0, np.sign(acceleration))


def _one(body: Body, points: Candidates) -> tuple[float, float]:
    (y,), (centripetal,), (limit,) = points
    free = body.u - body.w * y - centripetal
    force = np.clip(-free / (1.0 / body.mass + y * y / body.inertia), -limit, limit)
    return body.u + force / body.mass, body.w - force * y / body.inertia


def _several(body: Body, points: Candidates) -> tuple[float, float]:
    """Bisection over w, whose best u is a median."""
    span = float(np.abs(points.y) @ points.limit) / body.inertia
    low, high = body.w - span, body.w + span
    for _ in range(_BISECTIONS):
        w = 0.5 * (low + high)
        if _slope(body, points, w) > 0.0:
            high = w
        else:
            low = w
        if high - low <= 1e-16 * (abs(low) + abs(high)):
            break
    w = 0.5 * (low + high)
    return _best(body, points, w), w


def _best(body: Body, points: Candidates, w: float) -> float:
    """u that minimises Gauss's function at w: the median of the kinks and of the minima between them."""
    kinks = w * points.y + points.centripetal
    weight = points.limit[np.argsort(kinks)]
    below = np.concatenate([[0.0], np.cumsum(weight)])
    between = body.u - (2.0 * below - below[-1]) / body.mass
    return float(np.median(np.concatenate([kinks, between])))


def _slope(body: Body, points: Candidates, w: float) -> float:
    """Derivative of Gauss's function along w, at the best u: what rests at a kink carries what balances u."""
    u = _best(body, points, w)
    a = u - w * points.y - points.centripetal
    force = -points.limit * np.sign(a)
    nearest = int(np.argmin(np.abs(a)))
    rest = body.mass * (u - body.u) - (force.sum() - force[nearest])
    force[nearest] = np.clip(rest, -points.limit[nearest], points.limit[nearest])
    return float(body.inertia * (w - body.w) + force @ points.y)


def stick_margin(y: Array, limit: Array, force: Array) -> float:
    """How far the friction of stuck points is from its limit [N]; below 0 they do not all stick.

    What they can bear together, sum and moment, is a zonotope; the margin is the least over its sides.
    """
    if force.size == 1:
        return float(limit[0] - abs(force[0]))
    return float(_sides(y, limit, force).min())


def _sides(y: Array, limit: Array, force: Array) -> Array:
    """Margin at each side of the zonotope, scaled to newtons; side j is parallel to the pair (1, y_j)."""
    lever = y[None, :] - y[:, None]
    spread = np.abs(lever).max()
    if spread <= 1e-9 * np.abs(y).max():
        return np.array([limit.sum() - abs(force.sum())])
    return (np.abs(lever) @ limit - np.abs(lever @ force)) / spread


def released(y: Array, limit: Array, force: Array) -> Array:
    """Sign of the sliding of each stuck point when the margin is used up; 0 where it goes on sticking."""
    if force.size == 1:
        return -np.sign(force)
    sides = _sides(y, limit, force)
    if sides.size == 1:
        return np.full(force.size, -np.sign(force.sum()))
    lever = y - y[int(np.argmin(sides))]
    return -np.sign(lever) * np.sign(lever @ force)


def within_limits(y: Array, limit: Array, force: Array) -> Array:
    """Friction of stuck points (k, n) with the same sums and moments, and none above its limit.

    Of three or more stuck points it is not unique; where the least forces pass a limit, others carry the rest.
    """
    from scipy.optimize import lsq_linear

    out = np.clip(force, -limit, limit)
    for i in np.flatnonzero((np.abs(force) > limit * (1.0 + 1e-9)).any(axis=0)):
        size = np.abs(y[:, i]).max()
        equal = np.vstack([np.ones_like(y[:, i]), y[:, i] / size]) * limit[:, i]
        found = lsq_linear(equal, equal @ (force[:, i] / limit[:, i]), (-1.0, 1.0), method="bvls")
        out[:, i] = found.x * limit[:, i]
    return out
