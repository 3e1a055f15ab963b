"""Element tables for the compiled loop, from scikit-fem's mesh, element and quadrature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fem.discretisation.element_kinds import ELEMENT_KINDS

if TYPE_CHECKING:
    import meshio

MIDDLE = (np.array([[0.5], [0.5]]), np.array([1.0]))
"""Quadrature of the reference square by its middle: points, shape (2, 1), and weights."""

UNIFORM_TOLERANCE = 1e-12
"""Relative spread of the gradients below which all elements count as congruent."""


class ElementTable(NamedTuple):
    """What the internal forces need, as contiguous arrays.

    connectivity: node of each element corner, shape (nodes per element, elements).
    gradients: shape-function gradients in the reference configuration [1/m], shape
        (points x nodes per element x 2, elements), or one column if all elements are congruent.
    weights: quadrature weight times thickness [m^3], shape (points, elements) or (points, 1).
    per_element: a tuple as long as an element has nodes: its length is a constant to the compiler.
    """

    connectivity: np.ndarray
    gradients: np.ndarray
    weights: np.ndarray
    per_element: tuple[int, ...]


class Hourglass(NamedTuple):
    """Control of the motions that one point does not see: energy k |sum gamma_a x_a|^2 / 2 an element.

    vectors: gamma, orthogonal to linear fields, shape (nodes per element, elements or 1); stiffness: k [N/m],
    shape (elements or 1,).
    """

    vectors: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True)
class Discretisation:
    """The plate's discretisation: scikit-fem's basis beside the tables drawn from it."""

    scalar: Any  # skfem.CellBasis of one unknown a node
    positions: np.ndarray  # reference positions of the nodes [m], shape (2, nodes)
    corner: int  # node at corner P
    side: np.ndarray  # nodes of side PE
    table: ElementTable

    @property
    def cells(self) -> np.ndarray:
        """Corner nodes of the elements, shape (elements, 3 or 4); corner nodes come first in the numbering."""
        return np.asarray(self.scalar.mesh.t.T)


def discretise(mesh: meshio.Mesh, thickness: float, kind: str = "quad4") -> Discretisation:
    """Elements of this kind on the mesh's cells; corner P and side PE from its groups."""
    import skfem
    from skfem.io.meshio import from_meshio

    chosen = ELEMENT_KINDS[kind]
    rule: dict[str, Any] = {"intorder": chosen.order} if chosen.order else {"quadrature": MIDDLE}
    scalar = skfem.CellBasis(from_meshio(mesh), getattr(skfem, chosen.element)(), **rule)
    positions = np.ascontiguousarray(scalar.doflocs)
    side = scalar.get_dofs("side_pe").flatten()
    return Discretisation(scalar, positions, _corner(mesh, positions), side, _table(scalar, thickness))


def hourglass_control(
    discretisation: Discretisation, thickness: float, modulus: float, share: float
) -> Hourglass:
    """Stiffness control after Flanagan and Belytschko (1981): k = share c_11 V sum |b_a|^2 / 16.

    modulus: c_11 [Pa]; share: dimensionless; b_a the gradients at the middle.
    """
    table, nodes = discretisation.table, discretisation.positions[:, discretisation.table.connectivity]
    gradients = table.gradients.reshape(4, 2, -1)
    pattern = np.array([1.0, -1.0, 1.0, -1.0])
    slope = np.einsum("a,iae->ie", pattern, nodes)
    vectors = pattern[:, None] - np.einsum(
        "ie,aie->ae", slope, np.broadcast_to(gradients, (4, 2, nodes.shape[2]))
    )
    stiffness = share * modulus * table.weights[0] * (gradients**2).sum(axis=(0, 1)) / 16.0
    columns = table.weights.shape[1]
    return Hourglass(np.ascontiguousarray(vectors[:, :columns]), np.ascontiguousarray(stiffness[:columns]))


def _corner(mesh: meshio.Mesh, positions: np.ndarray) -> int:
    ((cell,),) = mesh.cells_dict["vertex"][mesh.cell_sets_dict["corner_p"]["vertex"]][None]
    distance = np.linalg.norm(positions.T - mesh.points[cell, :2], axis=-1)
    return int(distance.argmin())


def _table(scalar: Any, thickness: float) -> ElementTable:
    gradients = np.array([field[0].grad for field in scalar.basis])  # node, direction, element, point
    gradients = gradients.transpose(3, 0, 1, 2)
    points, nodes, _, elements = gradients.shape
    gradients = gradients.reshape(points * nodes * 2, elements)
    weights = scalar.dx.T * thickness
    if _congruent(gradients) and _congruent(weights):
        gradients, weights = gradients[:, :1], weights[:, :1]
    return ElementTable(
        np.ascontiguousarray(scalar.element_dofs, dtype=np.int32),
        np.ascontiguousarray(gradients),
        np.ascontiguousarray(weights),
        (0,) * nodes,
    )


def _congruent(rows: np.ndarray) -> bool:
    return bool(np.ptp(rows, axis=1).max() <= UNIFORM_TOLERANCE * np.abs(rows).max())
