"""The plane motion between two events, in fixed modes: y' = f(y).

y = (x_g, y_g, theta, v_gx, v_gy, omega; impulse along X, along Y, about X = Y = 0; work of friction on the vehicle;
work of the normal forces on the crush). A point at (x, y) from the centre of mass has the velocity v_g + omega (-y, x).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from solver.elementary import Array
from solver.impact.contact import ContactPoints
from solver.impact.friction import within_limits
from solver.impact.modes import Modes, Pressed, pressed_points, touch_crush

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

    def recorded_forces(self, y: Array, at: Kinematics) -> Forces:
        """The same, none that pulls or passes its limit of friction by rounding."""
        normal, tangential = self.forces(y, at)
        normal, stuck = np.maximum(normal, 0.0), self.pressed.stuck
        if stuck.size:
            limit = np.maximum(self.mu * normal[stuck], 1e-300)
            tangential[stuck] = within_limits(at.y[stuck], limit, tangential[stuck])
        return Forces(normal, tangential)

    def accelerations(self, at: Kinematics, forces: Forces) -> Array:
        """Of the centre of mass along X and Y, and about it, shape (3, n)."""
        normal, tangential = forces
        torque = (at.x * normal - at.y * tangential).sum(axis=0)
        return np.stack([tangential.sum(axis=0), normal.sum(axis=0), torque]) / self._inertias[:, None]

    def rates(self, t: float, y: Array) -> Array:
        """y', for SciPy."""
        out = np.zeros(SIZE)
        out[:3] = y[3], y[4], -y[5]
        p = self.pressed
        if p.points.size:
            at = self._kinematics_now(y)
            normal = p.offset + p.slope * at.crush
            tangential = p.friction * normal
            if p.stuck.size or p.held.size:
                normal, tangential = (force[:, 0] for force in self.forces(y[:, None], _columns_of(at)))
            force_x, force_y = float(tangential.sum()), float(normal.sum())
            torque = float(at.x @ normal - at.y @ tangential)
            out[3:6] = force_x / self.mass, force_y / self.mass, torque / self.inertia
            out[6:9] = force_x, force_y, torque + y[0] * force_y - y[1] * force_x
            out[9:] = tangential @ at.v_x, normal @ at.rate
        return out

    def _kinematics_now(self, y: Array) -> Kinematics:
        """Of the touching points at one state: arrays (touching points,)."""
        p, c, s = self.pressed, math.cos(y[2]), math.sin(y[2])
        r_x, r_y = p.along * c + p.across * s, p.across * c - p.along * s
        return Kinematics(r_x, r_y, -(r_y + y[1]), y[3] - y[5] * r_y, -(y[4] + y[5] * r_x))

    @cached_property
    def touch(self) -> Array:
        """Crush at which each point is pressed again, or leaves, shape (points,) [m]."""
        return touch_crush(self.points, self.modes.max_crush)

    @cached_property
    def corners(self) -> frozenset[int]:
        """The corners that are pressed on."""
        return frozenset(self.points.corner[self.pressed.points].tolist())

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


def _columns_of(at: Kinematics) -> Kinematics:
    return Kinematics(*(value[:, None] for value in at))


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
