"""Element tables for the compiled loop, from scikit-fem's mesh, element and quadrature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import meshio

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


@dataclass(frozen=True)
class Discretisation:
    """The plate's discretisation: scikit-fem's bases beside the tables drawn from them."""

    scalar: Any  # skfem.CellBasis of one unknown a node
    positions: np.ndarray  # reference positions of the nodes [m], shape (2, nodes)
    corner: int  # node at corner P
    table: ElementTable


def discretise(mesh: meshio.Mesh, thickness: float) -> Discretisation:
    """Bilinear quadrilaterals with 2 x 2 points on the mesh's quads; corner P from its group `corner_p`."""
    import skfem
    from skfem.io.meshio import from_meshio

    scalar = skfem.CellBasis(from_meshio(mesh), skfem.ElementQuad1(), intorder=2)
    positions = np.ascontiguousarray(scalar.doflocs)
    return Discretisation(scalar, positions, _corner(mesh, positions), _table(scalar, thickness))


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
