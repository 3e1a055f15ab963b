"""The elastic state of inertia relief where displacements are no longer small: equilibrium in the deformed plate.

Newton's method on the forces of the time loop itself, from the linear state, with the tangent stiffness of the St.
Venant-Kirchhoff material, which all materials have at small strain.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.explicit import internal_force
from fem.model.plate_model import PlateModel
from fem.plate import elastic, elements

MAX_STEPS, TOLERANCE, GOOD = 15, 1e-10, 1e-3
"""Newton steps; the residual over the largest load at which they end; and the one from which on they end where rounding
no longer lets it fall."""


def equilibrium(
    model: PlateModel, place: np.ndarray, load_at: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Positions [m], shape (2, nodes), at which the internal forces balance the load, from positions near to them.

    load_at: load [N] for positions, in equilibrium there, shape (2, nodes). What is rigid in each step is left out.
    Raises ValueError if the steps do not converge.
    """
    before = np.inf
    for _ in range(MAX_STEPS):
        load = load_at(place)
        residual = load - internal_forces(model, place)
        size = float(np.abs(residual).max() / np.abs(load).max())
        if size <= TOLERANCE or (before < GOOD and size > 0.5 * before):
            return place
        if not np.isfinite(size):
            break
        solve = elastic.elastic_solver(tangent_matrix(model, place), model.loop.mass, place)
        place, before = place + solve(residual.ravel()).reshape(2, -1), size
    raise ValueError(
        "the plate is too soft for a start by inertia relief: it finds no equilibrium under its reaction"
    )


def internal_forces(model: PlateModel, place: np.ndarray) -> np.ndarray:
    """Nodal forces [N] that hold the plate at these positions, shape (2, nodes)."""
    loop, force, place = model.loop, np.zeros(place.shape), np.ascontiguousarray(place)
    scratch = internal_force.scratch_for(loop.table, loop.hourglass)
    internal_force.subtract_internal_forces(
        place, np.zeros(place.shape), None, loop.hourglass, force, loop.table, loop.material, scratch
    )
    return -force


def tangent_matrix(model: PlateModel, place: np.ndarray) -> sp.csr_matrix:
    """Stiffness [N/m] about these positions, numbered as `stiffness_matrix`; symmetric, shape (2 nodes, 2 nodes)."""
    import skfem

    d = model.discretisation
    gradient = np.array([d.scalar.interpolate(component).grad for component in place])
    moduli = model.tangent_moduli
    stress = _stress(gradient, moduli)

    def block(i: int, j: int) -> sp.csr_matrix:
        tensor = _tangent(gradient[i], gradient[j], moduli) + (stress if i == j else 0.0)

        def form(u: Any, v: Any, w: Any) -> Any:
            return np.einsum("kl...,k...,l...->...", tensor, v.grad, u.grad)

        return skfem.BilinearForm(form).assemble(d.scalar)

    coupling = block(0, 1)
    matrix = sp.csr_matrix(model.thickness * sp.bmat([[block(0, 0), coupling], [coupling.T, block(1, 1)]]))
    if model.loop.hourglass is not None:
        matrix = matrix + elements.hourglass_matrix(d.table, model.loop.hourglass, model.loop.mass.size)
    return matrix


def _stress(gradient: np.ndarray, moduli: Any) -> np.ndarray:
    """Second Piola-Kirchhoff stress, shape (2, 2, ...), of deformation gradients of that shape."""
    strain = 0.5 * (np.einsum("ik...,il...->kl...", gradient, gradient))
    strain[0, 0] -= 0.5
    strain[1, 1] -= 0.5
    stress = np.empty_like(strain)
    stress[0, 0] = moduli.c_11 * strain[0, 0] + moduli.c_12 * strain[1, 1]
    stress[1, 1] = moduli.c_12 * strain[0, 0] + moduli.c_11 * strain[1, 1]
    stress[0, 1] = stress[1, 0] = 2.0 * moduli.c_33 * strain[0, 1]
    return stress


def _tangent(f_i: np.ndarray, f_j: np.ndarray, moduli: Any) -> np.ndarray:
    """C_KMLN F_iM F_jN, shape (2, 2, ...), of the rows i and j of the deformation gradient."""
    first, second = f_i[0] * f_j[0], f_i[1] * f_j[1]
    mixed, crossed = f_i[0] * f_j[1], f_i[1] * f_j[0]
    return np.array(
        [
            [moduli.c_11 * first + moduli.c_33 * second, moduli.c_12 * mixed + moduli.c_33 * crossed],
            [moduli.c_12 * crossed + moduli.c_33 * mixed, moduli.c_11 * second + moduli.c_33 * first],
        ]
    )
