"""From the modes before an event to those after it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solver.elementary import Array
from solver.impact.crush_law import line_length
from solver.impact.dynamics import Dynamics, Forces, Kinematics, kinematics
from solver.impact.events import Event, Kind
from solver.impact.friction import Body, Candidates, released, sliding_of
from solver.impact.modes import FREE, HELD, LINE, LOADING

_STILL = 1e-11  # m/s: a point that touches with less has no velocity along the wall


def start_dynamics(dynamics: Dynamics, y: Array) -> Dynamics:
    """The modes at the start: what touches the wall and moves on into it is pressed."""
    at = _all_points(dynamics, y)
    touching = (at.crush >= -1e-12) & (at.rate > 0.0)
    crush = np.where(touching, LOADING, FREE)[:, 0]
    changed = replace(dynamics, modes=dynamics.modes._replace(crush=crush))
    return _settle(dynamics, changed, y, -1)


def after(dynamics: Dynamics, event: Event, y: Array) -> Dynamics:
    """The dynamics after an event at the state y."""
    if event.kind == Kind.SLIP:
        return _slip(dynamics, y)
    changed = _press(dynamics, event, y) if event.kind != Kind.SLIDE else dynamics
    return _settle(dynamics, changed, y, event.point)


def _all_points(dynamics: Dynamics, y: Array) -> Kinematics:
    return kinematics(dynamics.points.along, dynamics.points.across, y[:, None])


def _set(dynamics: Dynamics, point: int, mode: int, most: float) -> Dynamics:
    crush, max_crush = dynamics.modes.crush.copy(), dynamics.modes.max_crush.copy()
    crush[point], max_crush[point] = mode, most
    return replace(dynamics, modes=dynamics.modes._replace(crush=crush, max_crush=max_crush))


def _sliding(dynamics: Dynamics, sliding: Array) -> Dynamics:
    return replace(dynamics, modes=dynamics.modes._replace(sliding=sliding))


def _press(dynamics: Dynamics, event: Event, y: Array) -> Dynamics:
    kind, i = event.kind, event.point
    most = float(dynamics.modes.max_crush[i])
    if kind == Kind.PEAK:
        return _peak(dynamics, i, y)
    if kind == Kind.TOUCH:
        return _set(dynamics, i, LINE if _length(dynamics, i, most) > 0.0 else LOADING, most)
    return _set(dynamics, i, LOADING if kind in (Kind.OVER, Kind.YIELD) else FREE, most)


def _length(dynamics: Dynamics, i: int, most: float) -> float:
    return float(line_length(dynamics.points, np.full(dynamics.points.along.size, most))[i])


def _peak(dynamics: Dynamics, i: int, y: Array) -> Dynamics:
    """Unloading begins; on an upright line the point leaves, unless the others press it on."""
    at = _all_points(dynamics, y)
    most = max(float(at.crush[i, 0]), float(dynamics.modes.max_crush[i]))
    if _length(dynamics, i, most) > 0.0:
        return _set(dynamics, i, LINE, most)
    free = _set(dynamics, i, FREE, most)
    _, a_gy, w = free.rates(0.0, y)[3:6]
    leaving = a_gy + w * at.x[i, 0] - y[5] ** 2 * at.y[i, 0]
    return free if leaving >= 0.0 else _set(dynamics, i, HELD, most)


def _settle(before: Dynamics, dynamics: Dynamics, y: Array, point: int) -> Dynamics:
    """Sliding of every touching point: of those without velocity what their friction decides."""
    if not dynamics.mu or not dynamics.pressed.points.size:
        return dynamics
    v_x = _all_points(dynamics, y).v_x[:, 0]
    rests = np.abs(v_x) <= _STILL
    rests[before.pressed.points[before.pressed.stuck]] = True
    if point >= 0:
        rests[point] |= dynamics.modes.crush[point] == before.modes.crush[point]  # its sliding has ended
    return _decide(_sliding(dynamics, np.where(rests, 0.0, np.sign(v_x))), y)


def _decide(dynamics: Dynamics, y: Array) -> Dynamics:
    """Stick or slip of the touching points whose sliding is 0 so far."""
    p = dynamics.pressed
    if not p.stuck.size:
        return dynamics
    at, normal, tangential = _now(dynamics, y)
    limit = dynamics.mu * normal[p.stuck, 0]
    tangential[p.stuck] = 0.0
    u, _, w = dynamics.accelerations(at, Forces(normal, tangential))[:, 0].tolist()
    candidates = Candidates(at.y[p.stuck, 0], y[5] ** 2 * at.x[p.stuck, 0], limit)
    sliding = dynamics.modes.sliding.copy()
    sliding[p.points[p.stuck]] = sliding_of(Body(dynamics.mass, dynamics.inertia, u, w), candidates)
    return _sliding(dynamics, sliding)


def _slip(dynamics: Dynamics, y: Array) -> Dynamics:
    p = dynamics.pressed
    at, normal, tangential = _now(dynamics, y)
    sliding = dynamics.modes.sliding.copy()
    limit = dynamics.mu * normal[p.stuck, 0]
    sliding[p.points[p.stuck]] = released(at.y[p.stuck, 0], limit, tangential[p.stuck, 0])
    return _sliding(dynamics, sliding)


def _now(dynamics: Dynamics, y: Array) -> tuple[Kinematics, Array, Array]:
    """Of the touching points at one state: kinematics, normal and tangential forces, shape (touching points, 1)."""
    at = dynamics.kinematics(y[:, None])
    return at, *dynamics.forces(y[:, None], at)
