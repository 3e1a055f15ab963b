"""Tables of the discretised plate for the compiled loop.

They come from scikit-fem's mesh, element and quadrature. The module also has hourglass control, the linear stiffness
of the unstrained plate, the spin of its nodes for pictures, and the weights of nodes in a force over a patch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fem.laws.materials import StVenantKirchhoff
from fem.plate.kinds import ELEMENT_KINDS
from fem.plate.properties import ModelError

if TYPE_CHECKING:
    import meshio
    from scipy.sparse import csr_matrix
    from skfem import CellBasis

MIDDLE = (np.array([[0.5], [0.5]]), np.array([1.0]))
"""Quadrature of the reference square by its middle: points, shape (2, 1), and weights."""

PATTERN = np.array([1.0, -1.0, 1.0, -1.0])
"""Value of xi eta at the corners of a quadrilateral."""

GAUSS = tuple((x, y) for x in (-(3.0**-0.5), 3.0**-0.5) for y in (-(3.0**-0.5), 3.0**-0.5))
"""Quadrature points of a square, each of weight 1."""

UNIFORM_TOLERANCE = 1e-12
"""Relative spread of the gradients below which all elements count as congruent."""


class Mapping(NamedTuple):
    """Mapping of elements from the reference element by their nodes.

    gradients: of the shape functions on the reference element, of all nodes but the first, (a, direction) in a row,
    one tuple per point; of bilinear elements the coordinates of the point, which determine them. weights: quadrature
    weight times thickness [m], a tuple with one per point. reference: reference positions of the nodes [m], shape (2,
    nodes).
    """

    gradients: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    reference: np.ndarray


class ElementTable(NamedTuple):
    """Constants of the internal forces, as contiguous arrays.

    connectivity: node of each element corner, shape (nodes per element, elements).
    gradients: shape-function gradients in the reference configuration [1/m], shape
        (points x nodes per element x 2, elements), or one column if all elements are congruent.
    weights: quadrature weight times thickness [m^3], shape (points, elements) or (points, 1).
    per_element: a tuple as long as an element has nodes: its length is a constant to the compiler.
    mapping: of elements with several points that are not congruent; the time loop uses it for the gradients.
    """

    connectivity: np.ndarray
    gradients: np.ndarray
    weights: np.ndarray
    per_element: tuple[int, ...]
    mapping: Mapping | None = None


class Hourglass(NamedTuple):
    """Stabilisation of the motions without strain at the one quadrature point.

    With q = sum gamma_a x_a and p = F^T q, F at the middle, an element's energy is (k_11 p_1^2 + k_22 p_2^2 + 2 k_12
    p_1 p_2)/2.

    vectors: gamma, orthogonal to linear fields, shape (nodes per element, elements or 1); stiffness: k_11, k_22, k_12
    [N/m], shape (3, elements or 1).
    """

    vectors: np.ndarray
    stiffness: np.ndarray


@dataclass(frozen=True)
class Discretisation:
    """Basis of scikit-fem with the tables that follow from it.

    scalar: a `skfem.CellBasis` with one unknown per node. positions: reference positions of the nodes [m], shape (2,
    nodes). corner: node at corner P. side: nodes of side PE.
    """

    scalar: CellBasis
    positions: np.ndarray
    corner: int
    side: np.ndarray
    table: ElementTable

    @property
    def cells(self) -> np.ndarray:
        """Corner nodes of the elements, counter-clockwise, shape (elements, 3 or 4).

        Corner nodes come first in the numbering.
        """
        return np.asarray(self.scalar.mesh.t.T)


def discretise(mesh: meshio.Mesh, thickness: float, kind: str = "quad4") -> Discretisation:
    """Discretise a mesh by elements of this kind.

    Corner P and side PE are groups of the mesh. thickness: [m].
    """
    import skfem

    element_kind = ELEMENT_KINDS[kind]
    rule: dict[str, object] = (
        {"intorder": element_kind.order} if element_kind.order else {"quadrature": MIDDLE}
    )
    mesh_class = {"quad": skfem.MeshQuad, "triangle": skfem.MeshTri}[element_kind.cells]
    # Without the groups of the mesh scikit-fem needs no edges of linear elements. Sorted nodes would be clockwise.
    elements = mesh_class(
        np.ascontiguousarray(mesh.points[:, :2].T),
        np.ascontiguousarray(mesh.cells_dict[element_kind.cells].T),
        sort_t=False,
    )
    scalar = skfem.CellBasis(elements, getattr(skfem, element_kind.element)(), **rule)
    positions = np.ascontiguousarray(scalar.doflocs)
    corner, side = _corner(mesh, positions), _side(mesh, positions)
    return Discretisation(scalar, positions, corner, side, element_table(scalar, thickness))


def hourglass_control(
    discretisation: Discretisation, thickness: float, moduli: StVenantKirchhoff
) -> Hourglass:
    """Return the stabilisation by an assumed strain (Belytschko and Bindeman 1991, "ASQBI").

    It has no constant to choose. moduli: plane-stress constants, c_11 and c_12 [Pa]. The strain of h = xi eta is that
    of pure bending: e_11 = h,1 p_1 - nu h,2 p_2, e_22 = h,2 p_2 - nu h,1 p_1 and no shear; so that k_11 = E t int
    h,1^2, k_22 = E t int h,2^2 and k_12 = -nu E t int h,1 h,2. A rectangle bends as the beam does, without shear
    locking.
    """
    table = discretisation.table
    columns = table.weights.shape[1]
    nodes = discretisation.positions[:, table.connectivity[:, :columns]]
    gradients = table.gradients.reshape(4, 2, -1)
    slope = np.einsum("a,iae->ie", PATTERN, nodes)
    vectors = 0.25 * (PATTERN[:, None] - np.einsum("ie,aie->ae", slope, gradients))
    ratio = moduli.c_12 / moduli.c_11
    modulus = moduli.c_11 * (1.0 - ratio**2)
    h_11, h_22, h_12 = _twist(nodes)
    stiffness = modulus * thickness * np.array([h_11, h_22, -ratio * h_12])
    return Hourglass(np.ascontiguousarray(vectors), np.ascontiguousarray(stiffness))


def _twist(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Integrate h,1^2, h,2^2 and h,1 h,2 over quadrilaterals, h = xi eta.

    nodes: shape (2, 4, elements).
    """
    xi, eta = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
    sums = np.zeros((3, nodes.shape[2]))
    for x, y in GAUSS:
        by_xi, by_eta = 0.25 * xi * (1.0 + y * eta), 0.25 * eta * (1.0 + x * xi)
        (x_xi, y_xi), (x_eta, y_eta) = (np.einsum("a,iae->ie", d, nodes) for d in (by_xi, by_eta))
        area = x_xi * y_eta - x_eta * y_xi
        h_1, h_2 = (y * y_eta - x * y_xi) / area, (x * x_xi - y * x_eta) / area
        sums += np.abs(area) * np.array([h_1 * h_1, h_2 * h_2, h_1 * h_2])
    return sums[0], sums[1], sums[2]


def _corner(mesh: meshio.Mesh, positions: np.ndarray) -> int:
    """Return the node nearest to corner P of the mesh."""
    ((cell,),) = mesh.cells_dict["vertex"][mesh.cell_sets_dict["corner_p"]["vertex"]][None]
    distance = np.linalg.norm(positions.T - mesh.points[cell, :2], axis=-1)
    return int(distance.argmin())


def _side(mesh: meshio.Mesh, positions: np.ndarray) -> np.ndarray:
    """Return the nodes of the straight side PE of the mesh."""
    lines = mesh.cells_dict["line"][mesh.cell_sets_dict["side_pe"]["line"]]
    points = mesh.points[np.unique(lines), :2]
    first, last = points[points[:, 0].argmin()], points[points[:, 0].argmax()]
    length, from_first = np.linalg.norm(last - first), positions - first[:, None]
    direction, tolerance = (last - first) / length, 1e-9 * length
    along = direction @ from_first
    across = direction[0] * from_first[1] - direction[1] * from_first[0]
    is_beside = (along > -tolerance) & (along < length + tolerance)
    return np.flatnonzero(is_beside & (np.abs(across) < tolerance))


def element_table(scalar: CellBasis, thickness: float) -> ElementTable:
    """Return the element table, of one column where elements are congruent."""
    gradients = np.array([field[0].grad for field in scalar.basis])  # node, direction, element, point
    gradients = gradients.transpose(3, 0, 1, 2)
    points, nodes, _, elements = gradients.shape
    gradients = gradients.reshape(points * nodes * 2, elements)
    weights = scalar.dx.T * thickness
    mapping = None
    if _congruent(gradients) and _congruent(weights):
        gradients, weights = gradients[:, :1], weights[:, :1]
    elif points > 1:
        mapping = _mapping(scalar, thickness)
    return ElementTable(
        np.ascontiguousarray(scalar.element_dofs, dtype=np.int32),
        np.ascontiguousarray(gradients),
        np.ascontiguousarray(weights),
        (0,) * nodes,
        mapping,
    )


def _mapping(scalar: CellBasis, thickness: float) -> Mapping:
    """Return the mapping of elements that are not congruent."""
    from skfem import ElementQuad1

    natural = np.array([scalar.elem.lbasis(scalar.X, a)[1] for a in range(1, scalar.Nbfun)])
    if isinstance(scalar.elem, ElementQuad1):
        natural = scalar.X[None]
    gradients = natural.transpose(2, 0, 1).reshape(len(scalar.W), -1)
    reference = np.ascontiguousarray(scalar.doflocs)
    return Mapping(tuple(map(tuple, gradients.tolist())), tuple((scalar.W * thickness).tolist()), reference)


def _congruent(rows: np.ndarray) -> bool:
    """Return True if all columns are equal within the tolerance."""
    return bool(np.ptp(rows, axis=1).max() <= UNIFORM_TOLERANCE * np.abs(rows).max())


def stiffness_matrix(table: ElementTable, moduli: Any) -> csr_matrix:
    """Assemble the plane-stress stiffness [N/m] in the body frame.

    Its shape is (2 nodes, 2 nodes), all x unknowns, then all y. moduli: c_11, c_12, c_33, of a `StVenantKirchhoff`
    [Pa], or of a `Viscosity` [Pa s] for a damping matrix.
    """
    from scipy import sparse

    (points, columns), (nodes, elements) = table.weights.shape, table.connectivity.shape
    gradients = table.gradients.reshape(points, nodes, 2, columns)
    shape = (nodes, nodes, elements)
    place = [np.broadcast_to(c, shape).ravel() for c in (table.connectivity[:, None], table.connectivity)]

    def assemble(first: float, second: float, i: int, j: int) -> csr_matrix:
        """Assemble first v,i u,j + second v,1-i u,1-j."""
        terms = zip((first, second), (i, 1 - i), (j, 1 - j), strict=True)
        weights = table.weights[:, None]
        values = sum(
            np.einsum("pae,pbe->abe", c * weights * gradients[:, :, k], gradients[:, :, m])
            for c, k, m in terms
        )
        matrix = sparse.csr_matrix((np.broadcast_to(values, shape).ravel(), place))
        matrix.eliminate_zeros()
        return matrix

    xx, yy = assemble(moduli.c_11, moduli.c_33, 0, 0), assemble(moduli.c_11, moduli.c_33, 1, 1)
    xy = assemble(moduli.c_12, moduli.c_33, 0, 1)
    return sparse.bmat([[xx, xy], [xy.T, yy]], format="csr")


def hourglass_matrix(table: ElementTable, hourglass: Hourglass, nodes: int) -> csr_matrix:
    """Assemble the stiffness [N/m] of the hourglass control at rest.

    Its shape is (2 nodes, 2 nodes).
    """
    from scipy import sparse

    elements = table.connectivity.shape[1]
    vectors = np.broadcast_to(hourglass.vectors, (hourglass.vectors.shape[0], elements))
    columns = np.broadcast_to(np.arange(elements), vectors.shape)
    gather = sparse.csr_matrix(
        (vectors.ravel(), (table.connectivity.ravel(), columns.ravel())), shape=(nodes, elements)
    )
    k_11, k_22, k_12 = (
        gather @ sparse.diags(np.broadcast_to(row, elements)) @ gather.T for row in hourglass.stiffness
    )
    return sparse.csr_matrix(sparse.bmat([[k_11, k_12], [k_12, k_22]]))


def nodal_spin(scalar: CellBasis, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return the angular velocity [rad/s] at the corner nodes.

    Its shape is (corner nodes,). It is half the curl of the velocity. positions [m], velocities [m/s]: shape (2,
    nodes). It is evaluated at the quadrature points of the deformed plate, L = F' F^-1, and transferred to the corner
    nodes by the lumped projection on linear functions, because the integral of the quadratic ones of a triangle's
    corners is zero.
    """
    import skfem

    def gradient(values: np.ndarray) -> np.ndarray:
        return np.array([scalar.interpolate(component).grad for component in values])

    deformation, rate = gradient(positions), gradient(velocities)
    inverse = np.linalg.inv(np.moveaxis(deformation, (0, 1), (-2, -1)))
    velocity_gradient = np.moveaxis(rate, (0, 1), (-2, -1)) @ inverse
    spin = 0.5 * (velocity_gradient[..., 1, 0] - velocity_gradient[..., 0, 1])
    linear = skfem.ElementQuad1() if scalar.mesh.refdom is skfem.refdom.RefQuad else skfem.ElementTriP1()
    corners = scalar.with_element(linear)
    weighted = skfem.LinearForm(lambda v, w: w.spin * v).assemble(corners, spin=spin)
    return np.asarray(weighted / skfem.LinearForm(lambda v, w: v).assemble(corners))


def corner_weights(discretisation: Discretisation, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of the support of corner P.

    length [m]: of side PE, 0 for the node alone. The weights are the nodes' parts of w(s) = (4 - 6 s / a) / a over 0
    <= s <= a. Its integral is 1 and its first moment about P is 0, so that for every rigid motion the weighted mean
    is P itself. Raises ModelError if the length is not between two nodes and the side.
    """
    if length == 0.0:
        return np.array([discretisation.corner]), np.array([1.0])
    side = discretisation.side[np.argsort(-discretisation.positions[0, discretisation.side])]
    return patch_weights(side, -discretisation.positions[0, side], length)


def patch_weights(
    side: np.ndarray, s: np.ndarray, length: float, place: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of a patch of this length [m].

    side: nodes of a side from its corner on. s: their distances from the corner [m], place: that of the patch, see
    `hat_integrals`. Raises ModelError if the length is not between the element at the place and the side.
    """
    beyond = int(np.clip(np.searchsorted(s, place, side="right"), 1, s.size - 1))
    element = s[beyond] - s[beyond - 1]
    if not element * (1.0 - 1e-9) <= length <= s[-1] * (1.0 + 1e-9):
        raise ModelError(
            "patch_length",
            f"a patch of {length:g} m does not lie between {element:g} m, an element, and {s[-1]:g} m",
        )
    weights = hat_integrals(s, place, length)
    used = np.abs(weights) > 0.0
    return side[used].astype(np.int64), weights[used]


def hat_integrals(s: np.ndarray, place: float, length: float) -> np.ndarray:
    """Return the nodes' parts in a load on a line.

    s: of the nodes [m]. The load extends over a length [m] about the place, as far as the line extends. Its density
    is the linear w with an integral of 1 and its first moment at the place. A part is the integral of w times the
    node's hat function, for which two Gauss points are exact.
    """
    begin = max(s[0], min(place - 0.5 * length, s[-1] - length))
    s, offset = s - begin, (place - begin) / length
    parts = np.zeros_like(s)
    for i in range(s.size - 1):
        start, end = max(s[i], 0.0), min(s[i + 1], length)
        if end <= start:
            continue
        half = 0.5 * (end - start)
        for point in (-1.0, 1.0):
            position = 0.5 * (start + end) + point * half / np.sqrt(3.0)
            load = half * (4.0 - 6.0 * offset - (6.0 - 12.0 * offset) * position / length) / length
            hat = (position - s[i]) / (s[i + 1] - s[i])
            parts[i] += load * (1.0 - hat)
            parts[i + 1] += load * hat
    return parts
