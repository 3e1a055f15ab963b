"""The record of a rigid impact, and how a piece of the motion is evaluated for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.elementary import Array
from solver.impact.crush_law import energy_taken, stored_energy
from solver.impact.dynamics import kinematics
from solver.impact.integrate import Piece
from solver.impact.modes import LOADING
from solver.impact.vehicle import ImpactVehicle


@dataclass(frozen=True)
class ImpactRecord:
    """The impact at given instants; arrays of the shape of the instants, those of points with the points first.

    Attributes
    ----------
    t : ndarray
        Time since the start [s], of any shape.
    x_g, y_g : ndarray
        Centre of mass [m], shape of t.
    theta : ndarray
        Between the wall side and the wall [rad], shape of t.
    omega : ndarray
        [rad/s], positive where it closes the angle, shape of t.
    v_gx, v_gy : ndarray
        [m/s], shape of t.
    force_normal, force_tangential : ndarray
        Of the wall on the vehicle along +Y and +X [N], shape of t.
    impulse_normal, impulse_tangential : ndarray
        Their integrals [N s], shape of t.
    impulse_angular : ndarray
        Integral of their moment about X = Y = 0 [N m s], shape of t.
    kinetic_energy : ndarray
        [J], shape of t.
    crush_energy_stored, crush_energy_lost : ndarray
        What unloading would give back, and what it would not, of the energy taken up by the crush [J], shape of t.
    crush_work : ndarray
        Integral of the power of the normal forces on the crush [J], shape of t: stored and lost together.
    friction_work : ndarray
        Done on the vehicle, 0 or less [J], shape of t.
    crush, max_crush : ndarray
        Of every point, and the greatest so far [m], shape (points, ...).
    point_normal, point_tangential : ndarray
        Forces of every point on the vehicle [N], shape (points, ...).
    """

    t: Array
    x_g: Array
    y_g: Array
    theta: Array
    omega: Array
    v_gx: Array
    v_gy: Array
    force_normal: Array
    force_tangential: Array
    impulse_normal: Array
    impulse_tangential: Array
    impulse_angular: Array
    kinetic_energy: Array
    crush_energy_stored: Array
    crush_energy_lost: Array
    crush_work: Array
    friction_work: Array
    crush: Array
    max_crush: Array
    point_normal: Array
    point_tangential: Array


def record_of(vehicle: ImpactVehicle, t: Array, values: Array, by_point: Array) -> ImpactRecord:
    """From values (15, ...) and those of points (4, points, ...), as `evaluated` gives them."""
    x_g, y_g, theta, v_gx, v_gy, omega, j_x, j_y, h, friction, crush, *rest = values
    normal, tangential, stored, lost = rest
    kinetic = 0.5 * (vehicle.mass * (v_gx**2 + v_gy**2) + vehicle.inertia * omega**2)
    motion = t, x_g, y_g, theta, omega, v_gx, v_gy
    return ImpactRecord(
        *motion, normal, tangential, j_y, j_x, h, kinetic, stored, lost, crush, friction, *by_point
    )


def evaluated(piece: Piece, t: Array) -> tuple[Array, Array]:
    """State, sums of forces and energies, shape (15, n); crush, greatest crush and forces, shape (4, points, n)."""
    dynamics, y = piece.dynamics, piece.dense(t)
    points, modes, pressed = dynamics.points, dynamics.modes, dynamics.pressed.points
    crush = kinematics(points.along, points.across, y).crush
    most = np.where((modes.crush == LOADING)[:, None], crush, modes.max_crush[:, None])
    by_point = np.stack([crush, most, np.zeros_like(crush), np.zeros_like(crush)])
    forces = dynamics.recorded_forces(y, dynamics.kinematics(y))
    by_point[2, pressed], by_point[3, pressed] = forces
    wide = points._replace(**{name: getattr(points, name)[:, None] for name in _LAW})
    stored = stored_energy(wide, crush, most).sum(axis=0)
    lost = ((1.0 - wide.restitution**2) * energy_taken(wide, most)).sum(axis=0)
    return np.vstack([y, by_point[2].sum(axis=0), by_point[3].sum(axis=0), stored, lost]), by_point


_LAW = ("stiffness", "initial_force", "restitution")
