"""The plate's description: properties of plate, corner, contact, wall and time step, and choices by name.

Kinds of elements and of mass lumping are one object each; adding one is adding it here, or in any file that registers
it. scikit-fem supplies shape functions and quadrature; all elements go through the same compiled kernel. Nodal masses
are row sums, moved by the least relative change to the exact rigid-body inertia.

Element tables for the compiled loop, from scikit-fem's mesh, element and quadrature; the linear stiffness of the
unstrained plate, and fields over it for pictures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fem.registry import Registry

if TYPE_CHECKING:
    import meshio
    from scipy.sparse import csr_matrix


class ModelError(ValueError):
    """No model can be made of these properties.

    Parameters
    ----------
    wrong : str
        The property at fault, "elements", "patch_length" or "inertia", or one of the wall's: "wall.length",
        "wall.elements" or "wall.foundation_stiffness"; also an attribute.
    why : str
        The message.
    """

    def __init__(self, wrong: str, why: str) -> None:
        self.wrong = wrong
        super().__init__(why)


@dataclass(frozen=True)
class Inertia:
    """Inertia of a vehicle that is no uniform rectangle.

    Attributes
    ----------
    centre : float
        Of mass, behind the front on the middle line [m].
    yaw_inertia : float
        About that centre [kg m^2].
    """

    centre: float
    yaw_inertia: float


@dataclass(frozen=True)
class PlateProperties:
    """Size and material of the plate, and choices by name.

    Attributes
    ----------
    thickness : float
        [m].
    density : float
        [kg/m^3].
    youngs_modulus : float
        [Pa].
    poissons_ratio : float
        [-].
    lumping : str
        A name of `LUMPINGS`.
    element : str
        A name of `ELEMENT_KINDS`.
    material : str
        A name of `MATERIALS`.
    inertia : Inertia or None
        That the nodal masses carry; None for the plate's own.
    """

    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    lumping: str = "exact"
    element: str = "quad4"
    material: str = "st-venant-kirchhoff"
    inertia: Inertia | None = None


@dataclass(frozen=True)
class CornerProperties:
    """How the corner is held on the wall.

    Attributes
    ----------
    friction : NamedTuple or None
        Constants of a law of `FRICTION_LAWS`.
    constraint : str
        A name of `CONSTRAINTS`.
    penalty_scale : float
        Multiple of the constraint's usual stiffness [-].
    patch_length : float
        Of the support patch [m]; 0 for the corner node alone.
    damping_ratio : float
        Of the constraint's dashpot, to critical [-].
    angles : tuple of float
        Angles of the plate during the run [rad], at which the time step is looked at.
    """

    friction: Any = None
    constraint: str = "penalty"
    penalty_scale: float = 1.0
    patch_length: float = 0.0
    damping_ratio: float = 0.0
    angles: tuple[float, ...] = (0.26, 0.13, 0.0)


@dataclass(frozen=True)
class ContactProperties:
    """How the boundary touches a wall that only pushes.

    Attributes
    ----------
    friction : NamedTuple or None
        Constants of a law of `FRICTION_LAWS`.
    law : str
        "crush" for a vehicle that crushes; "penalty" or "exact" for one that does not.
    stiffness, initial_force : float
        Of the crush at each corner, k [N/m] and F0 [N].
    restitution : float
        Its square is the fraction of the energy that unloading returns [-].
    side_stiffness : float
        Of a crush layer along the sides [N/m per m]; 0 for none, then the corners alone touch.
    penalty_scale : float
        Of a penalty, multiple of Young's modulus times thickness [-].
    patch_length : float
        Of the long side, over which a corner that crushes is spread [m]; 0 for its node alone.
    """

    friction: Any = None
    law: str = "crush"
    stiffness: float = 0.0
    initial_force: float = 0.0
    restitution: float = 1.0
    side_stiffness: float = 0.0
    penalty_scale: float = 1.0
    patch_length: float = 0.0


@dataclass(frozen=True)
class WallProperties:
    """A deformable wall, on a foundation all along it; its ends are free.

    Attributes
    ----------
    mesh : meshio.Mesh
        Of quadrilaterals, with the group "wall_face": the wall in Y <= 0, its face Y = 0, X counted from the place of
        the first touch. Its elements have nine nodes.
    thickness : float
        Its height above the deck [m].
    density : float
        [kg/m^3].
    youngs_modulus : float
        [Pa].
    poissons_ratio : float
        [-].
    foundation_stiffness : float
        Force across the wall on a length of it, over its displacement [N/m per m]; the same along the wall, so that
        friction does not carry it off. Spread over the depth in proportion to the mass.
    """

    mesh: Any
    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    foundation_stiffness: float


@dataclass(frozen=True)
class StepProperties:
    """The time step, and damping of the plate.

    Attributes
    ----------
    safety_factor : float
        Fraction of the stable time step that is taken [-].
    longest : float
        Upper bound on the time step [s].
    damping_ratio : float
        Stiffness-proportional, to critical at the highest frequency [-].
    bulk_viscosity : float
        Linear: coefficient of density x wave speed x element size [-].
    elastic_rate : float
        Rate at which elastic velocities are damped [1/s].
    """

    safety_factor: float = 0.9
    longest: float = math.inf
    damping_ratio: float = 0.0
    bulk_viscosity: float = 0.0
    elastic_rate: float = 0.0


@dataclass(frozen=True)
class ElementKind:
    """A kind of element.

    Attributes
    ----------
    name : str
        In a scene.
    element : str
        scikit-fem's.
    order : int
        That the quadrature integrates; 0 stands for the one point in the middle, which scikit-fem does not choose by
        itself.
    cells : str
        That it sits on.
    hourglass : bool
        True if it needs hourglass control.
    higher_order : str
        Kind of twice the order on the same mesh, "" where this one is of second order.
    row_sums : bool
        True if row sums of its mass matrix are positive.
    """

    name: str
    element: str
    order: int
    cells: str
    hourglass: bool = False
    higher_order: str = ""
    row_sums: bool = True


ELEMENT_KINDS: Registry[ElementKind] = Registry("element")
"""Kinds of elements by their names in a scene."""

for _kind in (
    ElementKind("quad4", "ElementQuad1", 2, "quad", higher_order="quad9"),
    ElementKind("quad4-reduced", "ElementQuad1", 0, "quad", hourglass=True, higher_order="quad9"),
    ElementKind("quad9", "ElementQuad2", 4, "quad"),
    ElementKind("tri3", "ElementTriP1", 1, "triangle", higher_order="tri6"),
    ElementKind("tri6", "ElementTriP2", 2, "triangle", row_sums=False),
):
    ELEMENT_KINDS.register(_kind)


def row_sum_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Row sums of the consistent mass matrix [kg], shape (nodes,)."""
    import skfem

    return density * thickness * skfem.LinearForm(lambda v, w: v).assemble(scalar)


def scaled_diagonal_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Diagonal of the consistent mass matrix, scaled to the plate's mass (Hinton, Rock and Zienkiewicz) [kg]."""
    import skfem

    diagonal = skfem.BilinearForm(lambda u, v, w: u * v).assemble(scalar).diagonal()
    return np.asarray(diagonal * (density * thickness * scalar.dx.sum() / diagonal.sum()))


def exact_inertia_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Masses [kg] with the exact mass, centre and second moments of the meshed body, shape (nodes,).

    Row sums overstate the rotary inertia by the order of the squared element size. Of all corrections that
    make the six moments exact, this has the least sum of squared relative changes: m = m_0 + m_0^2 A^T z.
    Elements with row sums that are not positive (tri6) start from the scaled diagonal instead.
    Raises ModelError if a mass would not stay positive (a mesh too coarse to carry the moments).
    """
    masses = row_sum_masses(scalar, density, thickness)
    if masses.min() < 1e-3 * masses.mean():
        masses = scaled_diagonal_masses(scalar, density, thickness)
    middle, size = _frame(scalar)
    moments = np.array(_moments(*((scalar.doflocs - middle[:, None]) / size[:, None])))
    exact = _exact_moments(scalar) * density * thickness
    weighted = moments * masses**2
    multipliers = np.linalg.lstsq(weighted @ moments.T, exact - moments @ masses, rcond=None)[0]
    masses = masses + masses**2 * (multipliers @ moments)
    if not (masses > 0.0).all():
        coarse = "the mesh is too coarse to carry the exact inertia with positive nodal masses"
        raise ModelError("elements", coarse)
    if not np.allclose(moments @ masses, exact, rtol=1e-12, atol=1e-12 * exact[0]):
        raise ModelError("elements", "the mesh has too few nodes to carry the exact inertia")
    return masses


def given_inertia_masses(positions: np.ndarray, masses: np.ndarray, inertia: Inertia) -> np.ndarray:
    """Masses [kg] with their own sum, and this centre and yaw inertia, shape (nodes,); corner P is the origin.

    Of all such masses those of the greatest entropy beside the given ones, m exp(z . moments): they are positive, and
    there are some wherever any positive masses have that inertia. Raises ModelError where there are none.
    """
    total, size = masses.sum(), np.ptp(positions, axis=1)
    x = (positions[0] + inertia.centre) / size[0]
    y = (positions[1] - 0.5 * size[1]) / size[0]
    moments = np.array([np.ones_like(x), x, y, x * x + y * y])
    wanted = np.array([1.0, 0.0, 0.0, inertia.yaw_inertia / (total * size[0] ** 2)])
    multipliers = np.zeros(4)
    for _ in range(NEWTON_STEPS):
        tilted = masses / total * np.exp(multipliers @ moments)
        excess = moments @ tilted - wanted
        if np.abs(excess).max() < 1e-15 * len(masses):
            break
        step = np.linalg.lstsq((moments * tilted) @ moments.T, excess, rcond=None)[0]
        multipliers -= step / max(1.0, np.abs(step).max() / 2.0)
    tilted = total * tilted
    if not np.allclose(moments @ tilted, total * wanted, rtol=0.0, atol=1e-11 * total) or tilted.min() <= 0.0:
        raise ModelError("inertia", "no positive nodal masses have this centre of mass and yaw inertia")
    return tilted


NEWTON_STEPS = 200
"""For the masses of a given inertia; ten are enough but near the limit of what any masses can have."""


def _frame(scalar: Any) -> tuple[np.ndarray, np.ndarray]:
    """Middle and size of the mesh: moments in these coordinates are of order one."""
    low, high = scalar.doflocs.min(axis=1), scalar.doflocs.max(axis=1)
    return (low + high) / 2.0, high - low


def _moments(x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
    """Mass, first and second moments, as functions of position."""
    return [np.ones_like(x), x, y, x * x, x * y, y * y]


def _exact_moments(scalar: Any) -> np.ndarray:
    from skfem.quadrature import get_quadrature

    middle, size = _frame(scalar)
    points, weights = get_quadrature(scalar.elem, 4)
    volumes = np.abs(scalar.mapping.detDF(points)) * weights
    x = (np.asarray(scalar.mapping.F(points)) - middle[:, None, None]) / size[:, None, None]
    return np.array([np.sum(moment * volumes) for moment in _moments(*x)])


@dataclass(frozen=True)
class Lumping:
    """A kind of mass lumping.

    Attributes
    ----------
    name : str
        In a scene.
    masses : callable
        Takes scikit-fem's scalar basis, density [kg/m^3] and thickness [m]; returns nodal masses [kg], shape (nodes,).
    fault : str
        For reports: what it does to the rotary inertia, "" where that is exact.
    row_sums : bool
        Whether it needs elements whose mass matrix has positive row sums.
    """

    name: str
    masses: Callable[[Any, float, float], np.ndarray]
    fault: str = ""
    row_sums: bool = False


LUMPINGS: Registry[Lumping] = Registry("mass lumping")
"""Kinds of mass lumping by their names in a scene."""

for _lumping in (
    Lumping("exact", exact_inertia_masses),
    Lumping("row-sum", row_sum_masses, fault="the rotary inertia is overstated", row_sums=True),
):
    LUMPINGS.register(_lumping)


MIDDLE = (np.array([[0.5], [0.5]]), np.array([1.0]))
"""Quadrature of the reference square by its middle: points, shape (2, 1), and weights."""

PATTERN = np.array([1.0, -1.0, 1.0, -1.0])
"""xi eta at the corners of a quadrilateral."""

GAUSS = tuple((x, y) for x in (-(3.0**-0.5), 3.0**-0.5) for y in (-(3.0**-0.5), 3.0**-0.5))
"""Points of a square's quadrature, each of weight 1."""

UNIFORM_TOLERANCE = 1e-12
"""Relative spread of the gradients below which all elements count as congruent."""


class Mapping(NamedTuple):
    """How elements are mapped from the reference element: by their nodes.

    gradients: of the shape functions on the reference element, of all nodes but the first, (a, direction) in a row, a
    tuple a point; of bilinear elements the coordinates of the point, which give them. weights: quadrature weight times
    thickness [m], a tuple with one a point. reference: reference positions of the nodes [m], shape (2, nodes).
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
    """Stabilisation of the motions that one point does not see.

    With q = sum gamma_a x_a and p = F^T q, F at the middle, an element's energy is
    (k_11 p_1^2 + k_22 p_2^2 + 2 k_12 p_1 p_2)/2.

    vectors: gamma, orthogonal to linear fields, shape (nodes per element, elements or 1); stiffness: k_11, k_22, k_12
    [N/m], shape (3, elements or 1).
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


def hourglass_control(discretisation: Discretisation, thickness: float, moduli: Any) -> Hourglass:
    """Stabilisation by an assumed strain, without a constant to choose (Belytschko and Bindeman 1991, "ASQBI").

    moduli: plane stress constants, c_11 and c_12 [Pa]. The strain that goes with h = xi eta is that of pure bending:
    e_11 = h,1 p_1 - nu h,2 p_2, e_22 = h,2 p_2 - nu h,1 p_1 and no shear; so that k_11 = E t int h,1^2,
    k_22 = E t int h,2^2 and k_12 = -nu E t int h,1 h,2. A rectangle bends as the beam does, and no shear locks it.
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
    """Integrals of h,1^2, h,2^2 and h,1 h,2 over quadrilaterals, h = xi eta; nodes: shape (2, 4, elements)."""
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
    ((cell,),) = mesh.cells_dict["vertex"][mesh.cell_sets_dict["corner_p"]["vertex"]][None]
    distance = np.linalg.norm(positions.T - mesh.points[cell, :2], axis=-1)
    return int(distance.argmin())


def _table(scalar: Any, thickness: float) -> ElementTable:
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


def _mapping(scalar: Any, thickness: float) -> Mapping:
    from skfem import ElementQuad1

    natural = np.array([scalar.elem.lbasis(scalar.X, a)[1] for a in range(1, scalar.Nbfun)])
    if isinstance(scalar.elem, ElementQuad1):
        natural = scalar.X[None]
    gradients = natural.transpose(2, 0, 1).reshape(len(scalar.W), -1)
    reference = np.ascontiguousarray(scalar.doflocs)
    return Mapping(tuple(map(tuple, gradients.tolist())), tuple((scalar.W * thickness).tolist()), reference)


def _congruent(rows: np.ndarray) -> bool:
    return bool(np.ptp(rows, axis=1).max() <= UNIFORM_TOLERANCE * np.abs(rows).max())


def stiffness_matrix(scalar: Any, thickness: float, moduli: Any) -> csr_matrix:
    """Plane-stress stiffness [N/m] in the body frame, shape (2 nodes, 2 nodes): all x unknowns, then all y.

    moduli: anything with c_11, c_12, c_33: a `StVenantKirchhoff` [Pa], or a `Viscosity` [Pa s] for a damping matrix.
    """
    import skfem
    from scipy import sparse
    from skfem.helpers import grad

    def assemble(k: int, m: int) -> csr_matrix:
        return skfem.BilinearForm(lambda u, v, w: grad(v)[k] * grad(u)[m]).assemble(scalar)

    xx, yy, xy = assemble(0, 0), assemble(1, 1), assemble(0, 1)
    coupling = moduli.c_12 * xy + moduli.c_33 * xy.T
    normal = moduli.c_11 * xx + moduli.c_33 * yy, moduli.c_11 * yy + moduli.c_33 * xx
    blocks = [[normal[0], coupling], [coupling.T, normal[1]]]
    return sparse.csr_matrix(thickness * sparse.bmat(blocks))


def hourglass_matrix(table: ElementTable, hourglass: Hourglass, nodes: int) -> csr_matrix:
    """Stiffness [N/m] of the hourglass control at rest, shape (2 nodes, 2 nodes)."""
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


def nodal_spin(scalar: Any, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Local angular velocity [rad/s] at the corner nodes, half the curl of the velocity, shape (corner nodes,).

    positions [m], velocities [m/s]: shape (2, nodes). Evaluated at the quadrature points of the deformed plate,
    L = F' F^-1, and carried to the corner nodes by the lumped projection on linear functions: the quadratic ones of
    a triangle's corners have no integral to divide by.
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
