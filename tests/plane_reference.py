"""Integrate rigid vehicles in the plane, independently of the solver.

Exact: the equations of a rigid rectangle with sliding friction, crush laws that return energy, and tyres, by an
adaptive integrator of order 8.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import astuple
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from solver.impact import CrushLaw, ImpactState, ImpactVehicle, Strip, TyreAxle


class PlaneMotion(NamedTuple):
    """Motion of a vehicle.

    Attributes
    ----------
    end : array
        Place, angle and velocities at the end.
    impulses : array
        Of the strips at the end [N s].
    contacts : callable
        Depths and forces of the strips at instants, shape (2, strips, instants) [m], [N].
    """

    end: np.ndarray
    impulses: np.ndarray
    contacts: Callable[[np.ndarray], np.ndarray]


def loading(law: CrushLaw, depth: float) -> tuple[float, float]:
    """Force and absorbed energy on loading."""
    k, initial, most = float(law.stiffness), float(law.initial_force), float(law.plateau_force)
    onset = (most - initial) / k
    if depth <= onset:
        return initial + k * depth, (initial + 0.5 * k * depth) * depth
    after = depth - onset
    rise = float(law.hardening) * after
    return most + rise, 0.5 * (initial + most) * onset + (most + 0.5 * rise) * after


def force(law: CrushLaw, depth: float, deepest: float) -> float:
    """Force at a depth after the deepest one."""
    if depth <= 0.0:
        return 0.0
    if depth >= deepest:
        return loading(law, depth)[0]
    peak, energy = loading(law, deepest)
    slope = float(law.unloading_stiffness)
    if not slope:
        returned = float(law.restitution) ** 2 * energy
        if returned == 0.0:
            return 0.0
        slope = peak**2 / (2.0 * returned)
    return max(0.0, peak - max(slope, peak / deepest) * (deepest - depth))


def tyre_forces(
    vehicle: ImpactVehicle, axles: Sequence[TyreAxle], loads: Sequence[float], motion: np.ndarray
) -> np.ndarray:
    """Forces along and across the wall, and moment, of the tyres.

    motion: angle, velocities and spin.
    """
    theta, u, v, w = motion
    c, s, total = math.cos(theta), math.sin(theta), np.zeros(3)
    for axle, load in zip(axles, loads, strict=True):
        arm = vehicle.front_distance - axle.position
        slip = math.atan2(u * s + v * c + w * arm, max(abs(u * c - v * s), 1.0))
        side = -axle.friction * load * math.tanh(axle.cornering * slip / axle.friction)
        total += side * np.array([s, c, arm])
    return total


def integrated(
    vehicle: ImpactVehicle,
    start: ImpactState,
    end: float,
    strips: Sequence[Strip] = (),
    friction: float = 0.0,
    axles: Sequence[TyreAxle] = (),
    loads: Sequence[float] = (),
) -> PlaneMotion:
    """Integrate the motion of a vehicle whose strips slide along the wall."""
    front, side = vehicle.front_distance, 0.5 * vehicle.width
    along = np.array([front - strip.at[0] for strip in strips])
    across = np.array([strip.inset - side for strip in strips])
    count, laws = len(strips), [strip.law for strip in strips]

    def pushes(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        depth = -(state[1] + across * math.cos(state[2]) - along * math.sin(state[2]))
        deepest = state[6 : 6 + count]
        return depth, np.array([force(*row) for row in zip(laws, depth, deepest, strict=True)])

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        theta, u, v, w = state[2:6]
        depth, push = pushes(state)
        arm_x = along * math.cos(theta) + across * math.sin(theta)
        arm_y = across * math.cos(theta) - along * math.sin(theta)
        sinking = -(v + w * arm_x)
        deeper = np.where((depth >= state[6 : 6 + count]) & (depth > 0.0), np.maximum(sinking, 0.0), 0.0)
        forces = tyre_forces(vehicle, axles, loads, state[2:6])
        forces += (-friction * push.sum(), push.sum(), (arm_x * push + friction * arm_y * push).sum())
        inertia = vehicle.mass, vehicle.mass, vehicle.inertia
        return np.concatenate([(u, v, -w), forces / inertia, deeper, push])

    initial = np.concatenate([astuple(start), np.zeros(2 * count)])
    options: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-10}
    options["max_step"] = 2e-4 if strips else math.inf
    solution = solve_ivp(rates, (0.0, end), initial, dense_output=True, **options)

    def contacts(t: np.ndarray) -> np.ndarray:
        return np.array([pushes(column) for column in solution.sol(t).T]).transpose(1, 2, 0)

    return PlaneMotion(solution.y[:6, -1], solution.y[6 + count :, -1], contacts)
