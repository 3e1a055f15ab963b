"""The record of a rigid impact, and how a piece of the motion is evaluated for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.elementary import Array
from solver.impact.crush_law import energy_taken, stored_energy
from solver.impact.dynamics import Dynamics, kinematics
from solver.impact.integrate import Piece
from solver.impact.modes import FREE, LOADING
from solver.impact.vehicle import ImpactVehicle


@dataclass(frozen=True)
class ImpactRecord:
    """The impact at given instants; arrays of the shape of the instants, forces and energies summed over the points.

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


class PointRecord(NamedTuple):
    """The points at given instants, arrays of shape (points, ...).

    Attributes
    ----------
    crush, max_crush : ndarray
        And the greatest so far [m], shape (points, ...); below 0 in front of the wall.
    normal, tangential : ndarray
        Forces on the vehicle along +Y and +X [N], shape (points, ...).
    """

    crush: Array
    max_crush: Array
    normal: Array
    tangential: Array


def record_of(vehicle: ImpactVehicle, t: Array, values: Array) -> ImpactRecord:
    """From values, shape (15, ...), as `sums` gives them."""
    x_g, y_g, theta, v_gx, v_gy, omega, j_x, j_y, h, friction, crush, *rest = values
    normal, tangential, stored, lost = rest
    kinetic = 0.5 * (vehicle.mass * (v_gx**2 + v_gy**2) + vehicle.inertia * omega**2)
    motion = t, x_g, y_g, theta, omega, v_gx, v_gy
    return ImpactRecord(*motion, normal, tangential, j_y, j_x, h, kinetic, stored, lost, crush, friction)


LAW = ("stiffness", "initial_force", "restitution")
"""What the energies of a point depend on beside its crush."""


def sums(piece: Piece, t: Array) -> Array:
    """State, sums of forces and energies, shape (15, n), over the points that have touched."""
    dynamics, y = piece.dynamics, piece.dense(t)
    touched = np.flatnonzero((dynamics.modes.crush != FREE) | (dynamics.modes.max_crush > 0.0))
    law = dynamics.points._replace(**{name: getattr(dynamics.points, name)[touched, None] for name in LAW})
    crush, most = _crush(dynamics, touched, y)
    forces = dynamics.recorded_forces(y, dynamics.kinematics(y))
    stored = stored_energy(law, crush, most).sum(axis=0)
    lost = ((1.0 - law.restitution**2) * energy_taken(law, most)).sum(axis=0)
    return np.vstack([y, forces.normal.sum(axis=0), forces.tangential.sum(axis=0), stored, lost])


def by_point(piece: Piece, t: Array) -> Array:
    """Crush, greatest crush and forces of every point, shape (4, points, n)."""
    dynamics, y = piece.dynamics, piece.dense(t)
    crush, most = _crush(dynamics, np.arange(dynamics.points.along.size), y)
    out = np.stack([crush, most, np.zeros_like(crush), np.zeros_like(crush)])
    out[2:, dynamics.pressed.points] = dynamics.recorded_forces(y, dynamics.kinematics(y))
    return out


def _crush(dynamics: Dynamics, index: NDArray[np.int64], y: Array) -> tuple[Array, Array]:
    """Of the points with these numbers, and the greatest so far, shape (points, n)."""
    points, modes = dynamics.points, dynamics.modes
    crush = kinematics(points.along[index], points.across[index], y).crush
    loading = (modes.crush[index] == LOADING)[:, None]
    return crush, np.where(loading, crush, modes.max_crush[index, None])
