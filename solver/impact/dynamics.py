"""The plane motion between two events, in fixed modes: y' = f(y).

y = (x_g, y_g, theta, v_gx, v_gy, omega; impulse along X, along Y, about X = Y = 0; work of friction on the vehicle;
work of the normal forces on the crush). A point at (x, y) from the centre of mass has the velocity v_g + omega (-y, x).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from solver.elementary import Array
from solver.impact.contact import ContactPoints
from solver.impact.modes import Modes, Pressed, pressed_points

SIZE = 11


class Kinematics(NamedTuple):
    """Of points on the body: arrays of shape (points, n).

    Attributes
    ----------
    x, y : ndarray
        From the centre of mass, along X and Y [m].
    crush : ndarray
        Depth behind the wall [m]; negative in front of it.
    v_x : ndarray
        Velocity along the wall [m/s].
    rate : ndarray
        Of the crush [m/s].
    """

    x: Any
    y: Any
    crush: Any
    v_x: Any
    rate: Any


class Forces(NamedTuple):
    """On the vehicle, along Y and X, at each touching point: arrays of shape (touching points, n) [N]."""

    normal: Any
    tangential: Any


def kinematics(along: Array, across: Array, y: Array) -> Kinematics:
    """Of points at places on the body (points,), for states y of shape (at least 6, n)."""
    _, y_g, theta, v_gx, v_gy, omega = y[:6]
    c, s = np.cos(theta), np.sin(theta)
    along, across = along[:, None], across[:, None]
    r_x, r_y = along * c + across * s, across * c - along * s
    return Kinematics(r_x, r_y, -(y_g + r_y), v_gx - omega * r_y, -(v_gy + omega * r_x))


@dataclass(frozen=True)
class Dynamics:
    """The equations of motion in fixed modes.

    Attributes
    ----------
    mass, inertia : float
        Of the vehicle [kg], [kg m^2].
    mu : float
        Friction coefficient [-].
    points : ContactPoints
        All of them.
    modes : Modes
        What each does.
    """

    mass: float
    inertia: float
    mu: float
    points: ContactPoints
    modes: Modes

    @cached_property
    def pressed(self) -> Pressed:
        """The touching points."""
        return pressed_points(self.points, self.modes, self.mu)

    def kinematics(self, y: Array) -> Kinematics:
        """Of the touching points."""
        return kinematics(self.pressed.along, self.pressed.across, y)

    def forces(self, y: Array, at: Kinematics) -> Forces:
        """Of the touching points, at states y of shape (at least 6, n): arrays (touching points, n)."""
        p = self.pressed
        normal = p.offset[:, None] + p.slope[:, None] * at.crush
        forces = Forces(normal, p.friction[:, None] * normal)
        return self._with_constraints(y[5], at, forces) if p.stuck.size or p.held.size else forces

    def accelerations(self, at: Kinematics, forces: Forces) -> Array:
        """Of the centre of mass along X and Y, and about it, shape (3, n)."""
        normal, tangential = forces
        torque = (at.x * normal - at.y * tangential).sum(axis=0)
        return np.stack([tangential.sum(axis=0), normal.sum(axis=0), torque]) / self._inertias[:, None]

    def rates(self, t: float, y: Array) -> Array:
        """y', for SciPy."""
        out = np.zeros(SIZE)
        out[:3] = y[3], y[4], -y[5]
        if self.pressed.points.size:
            state = y[:, None]
            at = self.kinematics(state)
            normal, tangential = forces = self.forces(state, at)
            out[3:6] = self.accelerations(at, forces)[:, 0]
            out[6:8] = out[3] * self.mass, out[4] * self.mass
            out[8] = self.inertia * out[5] + y[0] * out[7] - y[1] * out[6]
            out[9:] = (tangential * at.v_x).sum(), (normal * at.rate).sum()
        return out

    @cached_property
    def _inertias(self) -> Array:
        return np.array([self.mass, self.mass, self.inertia])

    def _with_constraints(self, omega: Array, at: Kinematics, forces: Forces) -> Forces:
        """The forces that keep stuck and held points at rest: the least ones, where they are more than needed."""
        p, unknown = self.pressed, self.pressed.stuck.size
        rows = _rows(at, p)
        centripetal = omega**2 * np.concatenate([at.x[p.stuck], at.y[p.held]])
        present = np.einsum("nkc,cn->nk", rows, self.accelerations(at, forces))
        found = _least(rows, _columns(rows, at, p), self._inertias, centripetal.T - present).T
        normal, tangential = forces.normal.copy(), forces.tangential.copy()
        normal[p.held] += found[unknown:]
        tangential[p.held] += p.friction[p.held, None] * found[unknown:]
        tangential[p.stuck] += found[:unknown]
        return Forces(normal, tangential)


def _rows(at: Kinematics, p: Pressed) -> Array:
    """Accelerations of stuck points along X, of held ones along Y, over (a_gx, a_gy, omega'): shape (n, k, 3)."""
    y, x = at.y[p.stuck].T, at.x[p.held].T
    stuck = np.stack([np.ones_like(y), np.zeros_like(y), -y], axis=-1)
    held = np.stack([np.zeros_like(x), np.ones_like(x), x], axis=-1)
    return np.concatenate([stuck, held], axis=1)


def _columns(rows: Array, at: Kinematics, p: Pressed) -> Array:
    """Generalised forces of the unknown ones: a held point that slides brings its friction along."""
    friction = np.zeros(rows.shape)
    ratio = p.friction[p.held]
    friction[:, p.stuck.size :, 0] = ratio
    friction[:, p.stuck.size :, 2] = -ratio * at.y[p.held].T
    return rows + friction


def _least(rows: Array, columns: Array, inertias: Array, demanded: Array) -> Array:
    """z with rows M^-1 columns^T z = demanded; for many stuck points by their three accelerations alone."""
    if np.array_equal(rows, columns):
        inverse = np.linalg.pinv(rows / np.sqrt(inertias), rcond=1e-12)
        return np.asarray(np.einsum("nck,ncj,nj->nk", inverse, inverse, demanded))
    inverse = np.linalg.pinv((rows / inertias) @ np.swapaxes(columns, 1, 2), rcond=1e-12)
    return np.asarray(np.einsum("nkj,nj->nk", inverse, demanded))
