"""Equilibrium of the plate on its deformed shape by Newton's method.

The forces are those of the time loop itself. The tangent stiffness is that of the St. Venant-Kirchhoff material, with
which all materials agree at small strain.
"""

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from fem.explicit import internal_force
from fem.laws.materials import StVenantKirchhoff
from fem.model.plate_model import PlateModel
from fem.plate.discretisation import hourglass_matrix
from fem.plate.elastic import Solve, elastic_solver

MAX_STEPS, TOLERANCE, STAGNATION = 15, 1e-10, 1e-3
"""Newton steps, final residual over the largest load, and residual at which stagnation is accepted.

From the last one on the steps end where rounding prevents a further decrease.
"""

REUSED = 0.1
"""Decrease of the residual up to which a step has the tangent stiffness of an earlier one."""


def equilibrium(
    model: PlateModel,
    place: np.ndarray,
    load_at: Callable[[np.ndarray], np.ndarray],
    solve: Solve | None = None,
) -> tuple[np.ndarray, Solve | None]:
    """Return positions [m] in equilibrium with the load, shape (2, nodes).

    Besides, the last solver by the tangent stiffness. place: positions near to them. load_at: load [N] for positions,
    in equilibrium there, shape (2, nodes). solve: solver of a similar state, if any. The rigid part of each step is
    removed. Raises ValueError if the steps do not converge.
    """
    before, is_own = np.inf, False
    for _ in range(MAX_STEPS):
        load = load_at(place)
        residual = load - internal_forces(model, place)
        size = float(np.abs(residual).max() / np.abs(load).max())
        if size <= TOLERANCE or (is_own and before < STAGNATION and size > 0.5 * before):
            return place, solve
        if not np.isfinite(size):
            break
        if is_own := solve is None or size > REUSED * before:
            solve = elastic_solver(tangent_matrix(model, place), model.parameters.mass, place)
        place, before = place + solve(residual.ravel()).reshape(2, -1), size
    raise ValueError(
        "the plate is too soft for a start by inertia relief: no equilibrium exists under the reaction"
    )


def internal_forces(model: PlateModel, place: np.ndarray) -> np.ndarray:
    """Return the nodal forces [N] of the deformed plate, shape (2, nodes)."""
    parameters, force, place = model.parameters, np.zeros(place.shape), np.ascontiguousarray(place)
    table, hourglass = parameters.table, parameters.hourglass
    scratch = internal_force.scratch_for(table, hourglass)
    internal_force.subtract_internal_forces(
        place, np.zeros(place.shape), None, hourglass, force, table, parameters.material, scratch
    )
    return -force


def tangent_matrix(model: PlateModel, place: np.ndarray) -> sp.csr_matrix:
    """Assemble the symmetric stiffness [N/m] about these positions.

    Its shape is (2 nodes, 2 nodes), numbered as `stiffness_matrix`.
    """
    import skfem

    d = model.discretisation
    gradient = np.array([d.scalar.interpolate(component).grad for component in place])
    moduli = model.tangent_moduli
    stress = _stress(gradient, moduli)

    def block(i: int, j: int) -> sp.csr_matrix:
        tensor = _tangent(gradient[i], gradient[j], moduli) + (stress if i == j else 0.0)
        form = skfem.BilinearForm(lambda u, v, w: np.einsum("kl...,k...,l...->...", tensor, v.grad, u.grad))
        return form.assemble(d.scalar)

    coupling = block(0, 1)
    matrix = sp.csr_matrix(model.thickness * sp.bmat([[block(0, 0), coupling], [coupling.T, block(1, 1)]]))
    if model.parameters.hourglass is not None:
        matrix = matrix + hourglass_matrix(d.table, model.parameters.hourglass, model.parameters.mass.size)
    return matrix


def _stress(gradient: np.ndarray, moduli: StVenantKirchhoff) -> np.ndarray:
    """Return the second Piola-Kirchhoff stress, shape (2, 2, ...).

    gradient: deformation gradients of that shape.
    """
    strain = 0.5 * (np.einsum("ik...,il...->kl...", gradient, gradient))
    strain[0, 0] -= 0.5
    strain[1, 1] -= 0.5
    stress = np.empty_like(strain)
    stress[0, 0] = moduli.c_11 * strain[0, 0] + moduli.c_12 * strain[1, 1]
    stress[1, 1] = moduli.c_12 * strain[0, 0] + moduli.c_11 * strain[1, 1]
    stress[0, 1] = stress[1, 0] = 2.0 * moduli.c_33 * strain[0, 1]
    return stress


def _tangent(f_i: np.ndarray, f_j: np.ndarray, moduli: StVenantKirchhoff) -> np.ndarray:
    """Return C_KMLN F_iM F_jN, shape (2, 2, ...).

    f_i, f_j: rows i and j of the deformation gradient.
    """
    first, second = f_i[0] * f_j[0], f_i[1] * f_j[1]
    mixed, crossed = f_i[0] * f_j[1], f_i[1] * f_j[0]
    return np.array(
        [
            [moduli.c_11 * first + moduli.c_33 * second, moduli.c_12 * mixed + moduli.c_33 * crossed],
            [moduli.c_12 * crossed + moduli.c_33 * mixed, moduli.c_11 * second + moduli.c_33 * first],
        ]
    )
