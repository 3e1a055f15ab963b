"""Equilibrium of the deformed plate by Newton's method with Anderson acceleration.

The forces are those of the time loop itself. The tangent stiffness is that of the St. Venant-Kirchhoff material, with
which all materials agree at small strain. It does not contain the change of the load with the position, so that steps
alone converge slowly: each is combined with the last ones such that their combined length is least (Anderson, J. ACM
12, 1965). A tangent stiffness then serves many steps.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.laws.materials import StVenantKirchhoff
from fem.model.plate_model import PlateModel
from fem.plate.discretisation import hourglass_matrix
from fem.plate.elastic import Solve, elastic_solver

MAX_STEPS, TOLERANCE, COMBINED = 40, 1e-10, 6
"""Most steps, final residual over the largest load, and number of steps that are combined."""

SLOW = 0.5
"""Decrease of the residual above which a step is too short, and the tangent stiffness is computed again."""

STAGNATION = {True: 1e-3, False: 1e-8}
"""Residual below which such a step is attributed to rounding, and accepted.

By whether the step has the tangent stiffness of its own state; any other one may converge slowly.
"""


def equilibrium(
    model: PlateModel,
    place: np.ndarray,
    load_at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    solve: Solve,
) -> tuple[np.ndarray, Solve]:
    """Return positions [m] in equilibrium with the load, shape (2, nodes).

    Besides, the last solver. place: positions near to them. load_at: returns the positions without rigid rotation, and
    the load [N] in equilibrium there, shape (2, nodes) each. solve: solver of a similar state, replaced where it
    converges slowly. Raises ValueError if the steps do not converge.
    """
    before, is_own = 1.0, False
    places, steps, forces = list[np.ndarray](), list[np.ndarray](), elastic_forces(model.parameters)
    for _ in range(MAX_STEPS):
        place, load = load_at(place)
        residual = load - forces(place)
        size = float(np.abs(residual).max() / np.abs(load).max())
        is_slow = size > SLOW * before
        if size <= TOLERANCE or (is_slow and before < STAGNATION[is_own]):
            return place, solve
        if not np.isfinite(size):
            break
        if is_slow:
            solve = elastic_solver(tangent_matrix(model, place), model.parameters.mass, place)
            places, steps = [], []
        places, steps = [*places[1 - COMBINED :], place], [*steps[1 - COMBINED :], solve(residual.ravel())]
        place, before, is_own = _combined(places, steps), size, is_slow
    raise ValueError(
        "the plate is too soft for a start by inertia relief: no equilibrium exists under the reaction"
    )


def elastic_forces(parameters: Any) -> Callable[[np.ndarray], np.ndarray]:
    """Return the function of positions [m] that returns the internal forces [N].

    parameters: of a loop. Both arrays have the shape (2, nodes).
    """
    table, hourglass, place = parameters.table, parameters.hourglass, np.zeros((2, parameters.mass.size))
    force, scratch = np.zeros_like(place), scratch_for(table, hourglass)
    subtract = subtract_internal_forces.bound(
        place, np.zeros_like(place), None, hourglass, force, table, parameters.material, scratch
    )

    def forces(positions: np.ndarray) -> np.ndarray:
        place[:], force[:] = positions, 0.0
        subtract()
        return -force

    return forces


def _combined(places: list[np.ndarray], steps: list[np.ndarray]) -> np.ndarray:
    """Return the next place by Anderson acceleration.

    places: shape (2, nodes) each; steps: from each of them, shape (2 nodes,).
    """
    moved = [place.ravel() + step for place, step in zip(places, steps, strict=True)]
    place = moved[-1]
    if len(steps) > 1:
        weights = np.linalg.lstsq(np.diff(steps, axis=0).T, steps[-1], rcond=None)[0]
        place = place - weights @ np.diff(moved, axis=0)
    return np.asarray(place.reshape(2, -1))


def has_inverted_elements(model: PlateModel, place: np.ndarray) -> bool:
    """Return True if the determinant of a deformation gradient is not positive.

    The material has equilibria beyond that, which no plate can reach.
    """
    (f_11, f_12), (f_21, f_22) = (
        model.discretisation.scalar.interpolate(component).grad for component in place
    )
    return bool((f_11 * f_22 - f_12 * f_21).min() <= 0.0)


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
