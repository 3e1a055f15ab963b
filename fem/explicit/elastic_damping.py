"""Damping of the elastic velocities without effect on rigid motion, compiled.

    rigid motion    r = V + w x (x - x_G), which fits the nodal velocities best in the mass-weighted sense: the mean
                    axes of the flexible body (Canavin and Likins, J. Spacecraft Rockets 14, 1977)
    force           f = -c m (v - r), at the velocities half a step back

The forces have no resultant and no moment, so that momentum and spin are unchanged. A mode that would grow at less than
c/2 without damping decays, at any frequency. Without damping the parameters are None, and the code is compiled out.

Turned back by half a step, a rigid velocity field is w x (x - x_G) + w^2 dt/2 (x - x_G) on the present positions x.
Without the second term the damping would act on every rotating plate.
"""

import math
from typing import NamedTuple

import numpy as np

from machine_code.compiled import compiled, reordered

SUMS = 6
"""Number of sums over the nodes.

They are mass times x, y, v_x, v_y, then moment of momentum and second moment about the origin.
"""


class ElasticDamping(NamedTuple):
    """Damping rate c [1/s] of elastic velocities, and plate mass [kg]."""

    rate: float
    mass: float


def damped_time_step(frequency: float, rate: float) -> float:
    """Return the largest stable step [s] of the damped plate.

    The damping forces are half a step late. frequency: the highest of the plate [rad/s].
    """
    half = 0.5 * rate
    return 2.0 / (half + math.sqrt(half**2 + frequency**2))


@reordered
def sum_motion(damping, positions, velocities, mass, begin, end, sums):
    """Sum the motion of a range of nodes.

    sums: shape (SUMS,); the nodes are those from `begin` to `end` - 1.
    """
    if damping is None:
        return
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
    """Return the rigid velocity field as four numbers a, b, w, k.

    r = (a - w y + k x, b + w x + k y).
    """
    c_x, c_y = sums[0] / damping.mass, sums[1] / damping.mass
    v_x, v_y = sums[2] / damping.mass, sums[3] / damping.mass
    inertia = sums[5] - damping.mass * (c_x * c_x + c_y * c_y)
    spin = (sums[4] - damping.mass * (c_x * v_y - c_y * v_x)) / inertia
    lag = 0.5 * time_step * spin * spin
    return v_x + spin * c_y - lag * c_x, v_y - spin * c_x - lag * c_y, spin, lag


@reordered
def add_damping_force(damping, sums, positions, velocities, mass, time_step, begin, end, force):
    """Add the damping forces on a range of nodes.

    sums: those of all nodes. Returns the power [W] of the forces at these velocities.
    """
    if damping is None:
        return 0.0
    a, b, spin, lag = rigid_motion(damping, sums, time_step)
    x, y, m = positions[0, begin:end], positions[1, begin:end], mass[begin:end]
    v_x, v_y = velocities[0, begin:end], velocities[1, begin:end]
    f_x, f_y, rate, power = force[0, begin:end], force[1, begin:end], damping.rate, 0.0
    for node in range(m.size):
        e_x = v_x[node] - (a - spin * y[node] + lag * x[node])
        e_y = v_y[node] - (b + spin * x[node] + lag * y[node])
        f_x[node] -= rate * m[node] * e_x
        f_y[node] -= rate * m[node] * e_y
        # Power on v: the rigid part of v is orthogonal to e, but the lag is not.
        power += m[node] * (e_x * (e_x + lag * x[node]) + e_y * (e_y + lag * y[node]))
    return -rate * power


@reordered
def power_correction(damping, sums, state, time_step, begin, end, force):
    """Return the change of the damping power [W] by the velocities' mean.

    The power is to be that on the mean of the velocities half a step before and after. With this correction the
    energy balance closes to rounding. force: the sum of all forces.
    """
    if damping is None:
        return 0.0
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
    """Add the damping forces on all nodes and fill `sums`.

    Returns the power [W] of the forces at these velocities.
    """
    sum_motion(damping, positions, velocities, mass, 0, mass.size, sums)
    return add_damping_force(damping, sums, positions, velocities, mass, time_step, 0, mass.size, force)


def elastic_damping(rate: float, mass: np.ndarray) -> ElasticDamping | None:
    """Return the damping parameters for a rate [1/s], None for zero."""
    return ElasticDamping(rate, float(mass.sum())) if rate > 0.0 else None
