"""Compiled side forces of tyres on plates.

Each axle is a material line across the plate. Its middle has the velocity of the axle, and its slope defines the
direction of the force. Forces are taken at the velocities of the instant by the plate's own forces, and act at the
nodes that the velocity is read at.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fem.laws.contact_forces import side_force
from fem.laws.wall_contact import acceleration
from machine_code.compiled import compact

SUMS = ("tyre_work", "tyre_impulse_tangential", "tyre_impulse_normal", "tyre_impulse_angular")
"""Work of the tyres on the plates [J], their impulses along and across the wall [N s], and that of their moment about
the wall's frame [N m s], since the start."""


class Axles(NamedTuple):
    """Axles of all plates.

    first, shape (axles + 1,): where the nodes of each begin in `nodes`, `weights` and `slopes`; weights [-]: of the
    middle of the line; slopes [1/m]: of its derivative across the plate; load [N], friction and cornering [-], shape
    (axles,).
    """

    first: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    slopes: np.ndarray
    load: np.ndarray
    friction: np.ndarray
    cornering: np.ndarray


class AxleState(NamedTuple):
    """State of the axles.

    sums, shape (4,): as of `SUMS`. Workspace: force [N] of the last step along and across the wall, shape (2, axles).
    """

    sums: np.ndarray
    force: np.ndarray


def at_rest(axles: Any) -> AxleState | None:
    """Return axles without motion, None without axles."""
    return None if axles is None else AxleState(np.zeros(4), np.zeros((2, axles.load.size)))


@compact
def _mean(values, axles, a, weights):
    """Return the weighted sum of values at an axle's nodes."""
    total = 0.0
    for k in range(axles.first[a], axles.first[a + 1]):
        total += weights[k] * values[axles.nodes[k]]
    return total


@compact
def steer(axles, axle_state, positions, velocities, mass, time_step, force):
    """Add the side forces to `force`, and store them in the state.

    `force` must hold the forces of the plates themselves.
    """
    if axles is None:
        return
    half = 0.5 * time_step
    for a in range(axles.load.size):
        left_x = _mean(positions[0], axles, a, axles.slopes)
        left_y = _mean(positions[1], axles, a, axles.slopes)
        length = math.hypot(left_x, left_y)
        left_x, left_y = left_x / length, left_y / length
        u = _mean(velocities[0], axles, a, axles.weights) + half * acceleration(force[0], mass, axles, a)
        v = _mean(velocities[1], axles, a, axles.weights) + half * acceleration(force[1], mass, axles, a)
        ahead, across = u * left_y - v * left_x, u * left_x + v * left_y
        side = side_force(axles.load[a], axles.friction[a], axles.cornering[a], ahead, across)
        axle_state.force[0, a], axle_state.force[1, a] = side * left_x, side * left_y
    for a in range(axles.load.size):
        for k in range(axles.first[a], axles.first[a + 1]):
            force[0, axles.nodes[k]] += axles.weights[k] * axle_state.force[0, a]
            force[1, axles.nodes[k]] += axles.weights[k] * axle_state.force[1, a]


@compact
def add_tyre_work(axles, axle_state, state, mass, time_step, force, span, sums):
    """Add impulses and works of the side forces to `sums`.

    span: their duration [s]; sums, shape (4,). `force` is complete.
    """
    if axles is None:
        return
    half, positions, velocities = 0.5 * time_step, state.positions, state.velocities
    for a in range(axles.load.size):
        along, across = axle_state.force[0, a], axle_state.force[1, a]
        u = _mean(velocities[0], axles, a, axles.weights) + half * acceleration(force[0], mass, axles, a)
        v = _mean(velocities[1], axles, a, axles.weights) + half * acceleration(force[1], mass, axles, a)
        x = _mean(positions[0], axles, a, axles.weights) + state.origin[0]
        y = _mean(positions[1], axles, a, axles.weights)
        sums[0] += span * (along * u + across * v)
        sums[1] += span * along
        sums[2] += span * across
        sums[3] += span * (x * across - y * along)


@compact
def end_tyre_step(axles, axle_state, state, mass, time_step, force):
    """Add impulses and works of a step to the state."""
    if axles is None:
        return
    add_tyre_work(axles, axle_state, state, mass, time_step, force, time_step, axle_state.sums)


@compact
def record_tyres(axles, axle_state, state, mass, time_step, force, row):
    """Fill the row of an instant with the columns `SUMS`."""
    if axles is None:
        return
    for k in range(row.size):
        row[k] = axle_state.sums[k]
    add_tyre_work(axles, axle_state, state, mass, time_step, force, 0.5 * time_step, row)
