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

    Its shape is (2 nodes, 2 nodes), numbered as `stiffness_matrix`. Unknown m is the displacement of node a along i,
    and E,m the change of the Green strain by it. The stiffness is the sum of w E,m C E,n over the quadrature points of
    weight w, with w S_kl N_a,k N_b,l for unknowns along one direction, S being the stress.
    """
    table, nodes = model.parameters.table, model.parameters.mass.size
    c_11, c_12, c_33 = model.tangent_moduli
    moduli = np.array([[c_11, c_12, 0.0], [c_12, c_11, 0.0], [0.0, 0.0, c_33]])
    points, columns = table.weights.shape
    gradients = table.gradients.reshape(points, -1, 2, columns).transpose(2, 1, 0, 3)
    f_1, f_2 = np.einsum("iae,kape->kipe", place[:, table.connectivity], gradients)  # columns of the gradient
    strain = 0.5 * ((f_1**2).sum(axis=0) - 1.0), 0.5 * ((f_2**2).sum(axis=0) - 1.0), (f_1 * f_2).sum(axis=0)
    s_11, s_22, s_12 = table.weights * np.tensordot(moduli, strain, 1)
    n_1, n_2 = gradients
    by_stress = _products([n_1, n_2], [s_11 * n_1 + s_12 * n_2, s_12 * n_1 + s_22 * n_2])
    f_1, f_2 = f_1[:, None], f_2[:, None]
    changes = np.array([f_1 * n_1, f_2 * n_2, f_1 * n_2 + f_2 * n_1]).reshape(3, 2 * len(n_1), points, -1)
    elements = _products(changes, table.weights * np.tensordot(moduli, changes, 1))
    elements += np.kron(np.eye(2), by_stress)
    unknowns = np.concatenate([table.connectivity, table.connectivity + nodes]).T
    pairs = np.broadcast_arrays(unknowns[:, :, None], unknowns[:, None, :])
    matrix = sp.csr_matrix((elements.ravel(), [pair.ravel() for pair in pairs]), (2 * nodes, 2 * nodes))
    if model.parameters.hourglass is not None:
        matrix = matrix + hourglass_matrix(table, model.parameters.hourglass, nodes)
    return matrix


def _products(first: Any, second: Any) -> np.ndarray:
    """Return sums over components and points, shape (elements, m, n).

    first, second: shapes (components, m, points, elements or 1) and (components, n, points, elements).
    """
    by_element = [np.moveaxis(np.asarray(values), (3, 1), (0, 1)) for values in (first, second)]
    rows, columns = (values.reshape(*values.shape[:2], -1) for values in by_element)
    return rows @ columns.transpose(0, 2, 1)
