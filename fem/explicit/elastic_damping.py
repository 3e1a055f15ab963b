"""Damping of the elastic velocities alone: rigid-body motion, and with it momentum and spin, stays as it is; compiled.

    rigid motion    r = V + w x (x - x_G), the one that fits the nodal velocities best in the mass-weighted sense: the
                    mean axes of the flexible body (Canavin and Likins, J. Spacecraft Rockets 14, 1977)
    force           f = -c m (v - r), at the velocities half a step back

Turned back by half a step, a rigid velocity field is w x (x - x_G) + w^2 dt/2 (x - x_G) on the positions x that are at
hand; without the second part the damping would press on every turning plate. The forces have no resultant and no
moment. A mode that grows at less than c/2 by itself decays, whatever its frequency. Without damping the parameters are
None, and the code is compiled out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from fem.machine_code.compiled import compiled, implements

SUMS = 6
"""Mass times x, y, v_x, v_y; moment of momentum and second moment about the origin."""


class ElasticDamping(NamedTuple):
    """Rate c [1/s] at which elastic velocities are taken out; mass of the plate [kg]."""

    rate: float
    mass: float


def damped_time_step(frequency: float, rate: float) -> float:
    """Largest stable step [s] of a mode of this highest frequency [rad/s], its damping force half a step late."""
    half = 0.5 * rate
    return 2.0 / (half + math.sqrt(half**2 + frequency**2))


def add_up(damping: Any, positions: Any, velocities: Any, mass: Any, begin: int, end: int, sums: Any) -> None:
    """Fill `sums`, shape (SUMS,), over the nodes from `begin` to before `end`; compiled code only."""
    raise NotImplementedError(type(damping))


def resist(
    damping: Any,
    sums: Any,
    positions: Any,
    velocities: Any,
    mass: Any,
    time_step: float,
    begin: int,
    end: int,
    force: Any,
) -> float:
    """Add the damping forces on these nodes, `sums` being those of all nodes; their power [W] at these velocities.

    Compiled code only.
    """
    raise NotImplementedError(type(damping))


def gained(damping: Any, sums: Any, state: Any, time_step: float, begin: int, end: int, force: Any) -> float:
    """Change of their power [W] on the mean of the velocities half a step before and after, `force` being
    complete: with that the energy balance closes to rounding. Compiled code only."""
    raise NotImplementedError(type(damping))


@implements(add_up, type(None))
def _no_sums(damping, positions, velocities, mass, begin, end, sums):
    return


@implements(resist, type(None))
def _no_resistance(damping, sums, positions, velocities, mass, time_step, begin, end, force):
    return 0.0


@implements(gained, type(None))
def _nothing_gained(damping, sums, state, time_step, begin, end, force):
    return 0.0


@implements(add_up, ElasticDamping)
def _add_up(damping, positions, velocities, mass, begin, end, sums):
    x, y, m = positions[0, begin:end], positions[1, begin:end], mass[begin:end]
    v_x, v_y = velocities[0, begin:end], velocities[1, begin:end]
    m_x = m_y = p_x = p_y = spin = second = 0.0
    for node in range(m.size):
        m_x += m[node] * x[node]
        m_y += m[node] * y[node]
        p_x += m[node] * v_x[node]
        p_y += m[node] * v_y[node]
        spin += m[node] * (x[node] * v_y[node] - y[node] * v_x[node])
        second += m[node] * (x[node] * x[node] + y[node] * y[node])
    sums[0], sums[1], sums[2], sums[3], sums[4], sums[5] = m_x, m_y, p_x, p_y, spin, second


@compiled
def rigid_motion(damping, sums, time_step):
    """Numbers a, b, w, k of r = (a - w y + k x, b + w x + k y), shape (4,)."""
    c_x, c_y = sums[0] / damping.mass, sums[1] / damping.mass
    v_x, v_y = sums[2] / damping.mass, sums[3] / damping.mass
    inertia = sums[5] - damping.mass * (c_x * c_x + c_y * c_y)
    spin = (sums[4] - damping.mass * (c_x * v_y - c_y * v_x)) / inertia
    lag = 0.5 * time_step * spin * spin
    return v_x + spin * c_y - lag * c_x, v_y - spin * c_x - lag * c_y, spin, lag


@implements(resist, ElasticDamping)
def _resist(damping, sums, positions, velocities, mass, time_step, begin, end, force):
    a, b, spin, lag = rigid_motion(damping, sums, time_step)
    x, y, m = positions[0, begin:end], positions[1, begin:end], mass[begin:end]
    v_x, v_y = velocities[0, begin:end], velocities[1, begin:end]
    f_x, f_y, rate, power = force[0, begin:end], force[1, begin:end], damping.rate, 0.0
    for node in range(m.size):
        e_x = v_x[node] - (a - spin * y[node] + lag * x[node])
        e_y = v_y[node] - (b + spin * x[node] + lag * y[node])
        f_x[node] -= rate * m[node] * e_x
        f_y[node] -= rate * m[node] * e_y
        # Power on v: what is rigid in v is orthogonal to e and is left out, the lag is not.
        power += m[node] * (e_x * (e_x + lag * x[node]) + e_y * (e_y + lag * y[node]))
    return -rate * power


@implements(gained, ElasticDamping)
def _gained(damping, sums, state, time_step, begin, end, force):
    a, b, spin, lag = rigid_motion(damping, sums, time_step)
    x, y = state.positions[0, begin:end], state.positions[1, begin:end]
    v_x, v_y = state.velocities[0, begin:end], state.velocities[1, begin:end]
    f_x, f_y, power = force[0, begin:end], force[1, begin:end], 0.0
    for node in range(x.size):
        e_x = v_x[node] - (a - spin * y[node] + lag * x[node])
        e_y = v_y[node] - (b + spin * x[node] + lag * y[node])
        power += e_x * f_x[node] + e_y * f_y[node]
    return -0.5 * time_step * damping.rate * power


@compiled
def damp(damping, positions, velocities, mass, time_step, sums, force):
    """Add the damping forces on all nodes; returns their power [W] at these velocities. `sums` is filled."""
    add_up(damping, positions, velocities, mass, 0, mass.size, sums)
    return resist(damping, sums, positions, velocities, mass, time_step, 0, mass.size, force)


def elastic_damping(rate: float, mass: np.ndarray) -> ElasticDamping | None:
    """The law for this rate [1/s]; None for zero: then there is no damping code."""
    return ElasticDamping(rate, float(mass.sum())) if rate > 0.0 else None
