"""A loop with internal forces, a penalty spring and drift, and no code for anything else; compiled.

It is what the program's loop of a scene without further parts must cost: no friction, damping, dashpot, hourglass
control, patch, works or impulses are in its source. Element tables and slots are the program's own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fem.compiled import compiled, inlined
from fem.constitutive.stress import stress
from fem.contact.constraints import Penalty
from fem.discretisation.elements import ElementTable
from fem.explicit.internal_force import Scratch, scratch_for
from fem.explicit.point_force import at_slot, point_of
from fem.explicit.simd_blocks import (
    BLOCK_SIZE,
    balance,
    clear_idle,
    gather,
    scatter,
    slot_count,
    subtract_first,
)
from fem.explicit.time_loop import LoopParameters, drift


class BareParameters(NamedTuple):
    """Elements, material, nodal masses [kg]; the node that the spring holds, its stiffness [N/m]; step [s]."""

    table: ElementTable
    material: Any
    mass: np.ndarray
    node: int
    stiffness: float
    time_step: float


def bare_parameters(loop: LoopParameters) -> BareParameters:
    """The same model without the parts that a bare loop has no code for; ValueError if it has one of them."""
    parts = (loop.friction, loop.viscosity, loop.hourglass, loop.elastic_damping)
    if any(part is not None for part in parts) or loop.corner.nodes.size > 1:
        raise ValueError("the bare loop has no code for a part of this model")
    if not isinstance(loop.corner.constraint, Penalty):
        raise ValueError("the bare loop has a penalty spring and no other constraint")
    node, stiffness = int(loop.corner.nodes[0]), float(loop.corner.stiffness)
    return BareParameters(_stored(loop.table), loop.material, loop.mass, node, stiffness, loop.time_step)


def bare_scratch(loop: LoopParameters) -> Scratch:
    """Its workspace."""
    return scratch_for(_stored(loop.table))


def _stored(table: ElementTable) -> ElementTable:
    """The table with its gradients as they are stored: mapping elements from their nodes is a part of its own."""
    return table._replace(mapping=None)


@compiled
def advance_bare(positions: Any, velocities: Any, steps: Any, model: Any, force: Any, scratch: Any) -> Any:
    """Advance positions and velocities half a step back, shape (2, nodes), in place by this many steps."""
    for _ in range(steps):
        force[:] = 0.0
        _subtract_forces(positions, force, model.table, model.material, scratch)
        force[1, model.node] -= model.stiffness * positions[1, model.node]
        drift(positions, velocities, force, model.mass, model.time_step, 0.0, 0, model.mass.size)


@compiled
def _subtract_forces(positions: Any, force: Any, table: Any, material: Any, scratch: Any) -> Any:
    others, nodes, rows = table.per_element[1:], len(table.per_element), scratch.rows
    connectivity, lattice = table.connectivity, scratch.lattice
    slots = slot_count(connectivity, lattice)
    for first in range(0, slots, BLOCK_SIZE):
        count = min(BLOCK_SIZE, slots - first)
        gather(positions, connectivity, lattice, first, count, rows)
        subtract_first(others, rows)
        rows[2 * nodes * BLOCK_SIZE : 4 * nodes * BLOCK_SIZE] = 0.0
        for point in range(table.weights.shape[0]):
            gradients = point_of(scratch.gradients, first // BLOCK_SIZE, point, 2 * len(others))
            weights = point_of(scratch.weights, first // BLOCK_SIZE, point, 1)
            _add_point(others, material, rows, gradients, weights)
        forces = rows[2 * nodes * BLOCK_SIZE : 4 * nodes * BLOCK_SIZE]
        balance(others, forces)
        clear_idle(lattice, first // BLOCK_SIZE, 2 * nodes, forces)
        scatter(force, connectivity, lattice, first, count, forces)


@compiled
def _add_point(others: Any, material: Any, rows: Any, gradients: Any, weights: Any) -> Any:
    nodes = len(others) + 1
    for slot in range(BLOCK_SIZE):
        weight = at_slot(weights, 0, slot)
        f_11, f_12, f_21, f_22 = _gradient(others, rows, gradients, slot)
        e_11 = 0.5 * (f_11 * f_11 + f_21 * f_21 - 1.0)
        e_22 = 0.5 * (f_12 * f_12 + f_22 * f_22 - 1.0)
        s_11, s_22, s_12 = stress(material, e_11, e_22, f_11 * f_12 + f_21 * f_22)
        s_11 *= weight
        s_22 *= weight
        s_12 *= weight
        p_11 = f_11 * s_11 + f_12 * s_12
        p_12 = f_11 * s_12 + f_12 * s_22
        p_21 = f_21 * s_11 + f_22 * s_12
        p_22 = f_21 * s_12 + f_22 * s_22
        for a in range(len(others)):
            g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
            rows[(2 * nodes + 2 * a + 2) * BLOCK_SIZE + slot] += p_11 * g_1 + p_12 * g_2
            rows[(2 * nodes + 2 * a + 3) * BLOCK_SIZE + slot] += p_21 * g_1 + p_22 * g_2


@inlined
def _gradient(others: Any, rows: Any, gradients: Any, slot: Any) -> Any:
    f_11 = f_12 = f_21 = f_22 = 0.0
    for a in range(len(others)):
        g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
        x = rows[(2 * a + 2) * BLOCK_SIZE + slot]
        y = rows[(2 * a + 3) * BLOCK_SIZE + slot]
        f_11 += x * g_1
        f_12 += x * g_2
        f_21 += y * g_1
        f_22 += y * g_2
    return f_11, f_12, f_21, f_22
