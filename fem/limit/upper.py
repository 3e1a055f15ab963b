"""Upper bound of the collapse load of a plate, from a mechanism.

Deflections are cubic in triangles and continuous; they bend within triangles and rotate at edges, which are hinges.
The largest power of moments within Johansen's criterion at a curvature k is tr(S k S)+ - M-.k with S = (M+ + M-)^1/2
and the positive part of the matrix; at a hinge it is M_n+ or M_n- times the rotation. Both are convex, so that their
values at the control points of curvature and rotation integrate to at least the dissipation, and every mechanism
has a load above that of collapse. The value is computed again on parts of the triangles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import sparse

from fem.limit import conic
from fem.limit.plate import HELD, LOCAL_EDGES, Floats, Indices, PlasticPlate, geometry, lengths, voigt

if TYPE_CHECKING:
    from skfem import Basis, MeshTri

__all__ = ["UpperBound", "gaps", "upper_bound"]

PARTS = 4
"""Parts of each edge of a triangle where the dissipation is computed again."""

HINGED = ("inner", "clamped", "symmetric", "cut")
"""Kinds of edges where a rotation dissipates."""

QUADRATIC = np.array([[3.0, 1.0], [2.0, 2.0], [1.0, 3.0]]) / 12.0
"""Integrals over an edge of its Bernstein polynomials of degree 2 by linear functions that are 1 at one end."""

TO_CONTROL = np.array([[1.0, 0.0, 0.0], [-0.5, 2.0, -0.5], [0.0, 0.0, 1.0]])
"""From values at both ends and the middle of an edge to Bernstein coefficients."""

TO_SLOPE = np.array([[-5.5, 9.0, -4.5, 1.0], [3.5, -13.5, 13.5, -3.5], [-1.0, 4.5, -9.0, 5.5]])
"""From cubic values at ends and thirds of an edge of unit length to Bernstein coefficients of the slope."""

TRIPLE = sparse.csc_matrix([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
"""Cone of positive semidefinite curvatures xx, yy, 2 xy, see `fem.limit.lower`."""


class UpperBound(NamedTuple):
    """Proven upper bound.

    Attributes
    ----------
    value : float
        Load factor [N], infinite without a mechanism.
    deflections : ndarray, shape (10, t)
        Degrees of freedom of the cubic deflection of each triangle, whose load has unit power [-].
    rotations : ndarray, shape (e, 3)
        Bernstein coefficients of the rotation of each edge [1/m].
    curvatures : ndarray, shape (t, 3, 3)
        Curvatures xx, yy, 2 xy at the nodes of the triangles [1/m^2].
    in_triangles, at_edges : ndarray, shape (t,), (e,)
        Dissipation without that of a beam [N].
    """

    value: float
    deflections: Floats
    rotations: Floats
    curvatures: Floats
    in_triangles: Floats
    at_edges: Floats


def upper_bound(plate: PlasticPlate, mesh: MeshTri) -> UpperBound:
    """Compute the least load of cubic mechanisms.

    Parameters
    ----------
    plate : PlasticPlate
        With its strengths and its load.
    mesh : MeshTri
        Its triangles, with lines at the levels of the strengths and at the load.

    Returns
    -------
    UpperBound
        With the dissipation computed again from the mechanism.
    """
    from skfem import Basis, ElementTriP3

    basis = Basis(mesh, ElementTriP3(), intorder=4)
    load = _load(plate, mesh, basis)
    held = np.flatnonzero(np.isin(plate.kinds(mesh), (*HELD, "cut")))
    free = np.setdiff1d(np.arange(basis.N), basis.get_dofs(facets=held).all() if held.size else [])
    curvature, rotation = _curvatures(mesh, basis), _rotations(plate, mesh, basis)
    (slope, of_beam), of_edges = _beam(plate, mesh, basis), _edge_weights(plate, mesh)
    hinges = sparse.vstack([rotation, slope], format="csr")
    of_hinges = np.concatenate([of_edges.reshape(2, -1), of_beam], axis=1)
    strengths = plate.strengths_at(mesh.p[1, mesh.t]).transpose(2, 1, 0)
    area = geometry(mesh).areas[:, None, None]
    w = np.zeros(basis.N)
    w[free] = _mechanism(
        load[free], curvature[:, free], hinges[:, free], _at_nodes(strengths, area), of_hinges
    )
    power = load @ w
    w = w / power if power > 0.0 else 0.0 * w
    bent, turned = (curvature @ w).reshape(-1, 3, 3), hinges @ w
    in_triangles = plate.scale * _dissipation(bent, strengths, area)
    at_hinges = plate.scale * (of_hinges * np.maximum([turned, -turned], 0.0)).sum(axis=0)
    value = float(in_triangles.sum() + at_hinges.sum()) if power > 0.0 else np.inf
    turned, at_edges = (values[: rotation.shape[0]].reshape(-1, 3) for values in (turned, at_hinges))
    return UpperBound(value, w[basis.element_dofs], turned, bent, in_triangles, at_edges.sum(axis=1))


def gaps(mesh: MeshTri, mechanism: UpperBound, moments: Floats) -> Floats:
    """Return dissipation minus power of moments, shape (t,) [N].

    They are not negative. moments: of a lower bound on the same mesh [N m/m], shape (t, 3, 3).
    """
    area = geometry(mesh).areas[:, None, None]
    differences = mechanism.in_triangles - (_at_nodes(moments, area) * mechanism.curvatures).sum(axis=(1, 2))
    at_edges = mechanism.at_edges - (_normal_moments(mesh, moments) * mechanism.rotations).sum(axis=1)
    at_edges[mesh.f2t[1] >= 0] *= 0.5
    for side, exists in zip(mesh.f2t, mesh.f2t >= 0, strict=True):
        np.add.at(differences, side[exists], at_edges[exists])
    return differences


def _mechanism(
    load: Floats, curvature: sparse.csr_matrix, hinges: sparse.csr_matrix, at_nodes: Floats, of_hinges: Floats
) -> Floats:
    """Return the deflections of unit power with the least dissipation.

    Curvatures and rotations are differences of a positive and a negative part, whose strengths differ; all are
    measured by the power of the sum of both strengths. at_nodes: of
    `_at_nodes`, shape (t, 3, 4); of_hinges: positive and negative strengths, shape (2, n).
    """
    sums = at_nodes[..., [0, 2]] + at_nodes[..., [1, 3]]
    size = np.concatenate([sums, np.sqrt(sums.prod(axis=-1, keepdims=True))], axis=-1).ravel()
    back = np.pad(at_nodes[..., [1, 3]], ((0, 0), (0, 0), (0, 1))).ravel() / size
    curvature, total = sparse.diags_array(size) @ curvature, of_hinges.sum(axis=0)
    hinges = sparse.diags_array(total) @ hinges
    unit = np.tile([1.0, 1.0, 0.0], size.size // 3)
    cost = np.concatenate(
        [-curvature.T @ back - hinges.T @ (of_hinges[1] / total), unit, np.ones(total.size)]
    )
    triples = sparse.kron(sparse.eye(size.size // 3), TRIPLE, format="csr")
    parts, count = sparse.eye(hinges.shape[0]), 2 * hinges.shape[0]
    rows = sparse.bmat(
        [
            [None, None, -parts],
            [hinges, None, -parts],
            [None, -triples, None],
            [triples @ curvature, -triples, None],
        ],
        format="csr",
    )
    power = sparse.csr_matrix(np.pad(load, (0, cost.size - load.size))[None])
    x = conic.minimum(
        cost,
        (power, np.ones(1)),
        (rows[:count], np.zeros(count)),
        (rows[count:], np.zeros(rows.shape[0] - count)),
    )
    return x[: load.size]


def _at_nodes(values: Floats, area: Floats) -> Floats:
    """Return the integrals of a linear field by node.

    The integrands are its products with functions that are 1 at one node. values: at the nodes, shape (t, 3, n);
    area: shape (t, 1, 1) [m^2].
    """
    return area / 12.0 * (values + values.sum(axis=1, keepdims=True))


def _dissipation(curvatures: Floats, strengths: Floats, area: Floats) -> Floats:
    """Return an upper bound of the dissipation in triangles, shape (t,).

    curvatures: xx, yy, 2 xy at the nodes, shape (t, 3, 3); strengths: shape (t, 3, 4); area: shape (t, 1, 1).
    """
    total = np.zeros(len(curvatures))
    for corners in _parts():
        bent, strong = corners @ curvatures, _at_nodes(corners @ strengths, area / PARTS**2)
        negative = strong[..., [1, 3]]
        size = np.sqrt(strong[..., [0, 2]] + negative)
        xx, yy = bent[..., 0] * size[..., 0] ** 2, bent[..., 1] * size[..., 1] ** 2
        mean, radius = (
            0.5 * (xx + yy),
            np.hypot(0.5 * (xx - yy), 0.5 * bent[..., 2] * size[..., 0] * size[..., 1]),
        )
        power = np.maximum(mean + radius, 0.0) + np.maximum(mean - radius, 0.0)
        total += (power - (negative * bent[..., :2]).sum(axis=-1)).sum(axis=1)
    return total


def _parts() -> list[Floats]:
    """Return the barycentric corners of parts, each (3, 3)."""
    lattice = [(i, j) for i in range(PARTS) for j in range(PARTS - i)]
    upward = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in lattice]
    downward = [[(i + 1, j), (i + 1, j + 1), (i, j + 1)] for i, j in lattice if i + j < PARTS - 1]
    return [np.array([[PARTS - i - j, i, j] for i, j in part]) / PARTS for part in upward + downward]


def _curvatures(mesh: MeshTri, basis: Basis) -> sparse.csr_matrix:
    """Return the curvatures xx, yy, 2 xy at the nodes."""
    from skfem import ElementTriP2

    points = np.array([[0.0, 1.0, 0.0, 0.5, 0.5, 0.0], [0.0, 0.0, 1.0, 0.0, 0.5, 0.5]])
    gradients = _gradients(basis, points)
    again = np.stack([ElementTriP2().lbasis(points[:, :3], k)[1] for k in range(6)])
    second = np.einsum("dap,pbn->dnab", gradients, again)
    inverse = geometry(mesh).gradients[1:]
    bent = np.einsum("dnab,axt,byt->tnxyd", second, inverse, inverse)
    values = np.stack([bent[:, :, 0, 0], bent[:, :, 1, 1], 2.0 * bent[:, :, 0, 1]], axis=2)
    rows = np.arange(values[..., 0].size).reshape(*values.shape[:3], 1)
    return _matrix(values, rows, basis.element_dofs.T[:, None, None], (rows.size, basis.N))


def _gradients(basis: Basis, points: Floats) -> Floats:
    """Return the gradients of the cubic functions, shape (10, 2, points)."""
    return np.stack([basis.elem.lbasis(points, k)[1] for k in range(10)])


def _rotations(plate: PlasticPlate, mesh: MeshTri, basis: Basis) -> sparse.csr_matrix:
    """Return the Bernstein coefficients of the rotations of edges, three each.

    A rotation is the jump of the slope; edges that do not dissipate have none.
    """
    of, values, rows = geometry(mesh), [], []
    corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for k, (a, b) in enumerate(LOCAL_EDGES):
        points = np.stack([corners[:, a], 0.5 * (corners[:, a] + corners[:, b]), corners[:, b]], axis=1)
        gradients = _gradients(basis, points) @ TO_CONTROL.T
        slopes = np.einsum("dac,axt,xt->tcd", gradients, of.gradients[1:], -of.normals[k])
        hinged = np.isin(plate.kinds(mesh), HINGED)[mesh.t2f[k]]
        values.append(slopes * hinged[:, None, None])
        rows.append((3 * mesh.t2f[k][:, None] + np.arange(3))[..., None])
    shape = (3 * mesh.facets.shape[1], basis.N)
    return _matrix(np.stack(values), np.stack(rows), basis.element_dofs.T[:, None], shape)


def _beam(plate: PlasticPlate, mesh: MeshTri, basis: Basis) -> tuple[sparse.csr_matrix, Floats]:
    """Return rotations of the beam and their strengths.

    Curvatures at both ends of its edges times half the length, and kinks at nodes: of an end that may turn there is
    none.
    """
    edges = plate.top_edges(mesh) if plate.beam else np.empty(0, dtype=int)
    if not edges.size:
        return sparse.csr_matrix((0, basis.N)), np.zeros((2, 0))
    at_left = (mesh.p[0, mesh.facets[0, edges]] > mesh.p[0, mesh.facets[1, edges]]).astype(int)
    dofs = np.concatenate([basis.nodal_dofs[0, mesh.facets[:, edges]], basis.facet_dofs[:, edges]])
    dofs = np.take_along_axis(dofs, np.stack([at_left, 2 + at_left, 3 - at_left, 1 - at_left]), axis=0)
    slopes = TO_SLOPE / lengths(mesh)[edges][:, None, None]
    rows = np.arange(3 * edges.size).reshape(-1, 3, 1)
    at = _matrix(slopes, rows, dofs.T[:, None], (3 * edges.size, basis.N))
    start, middle, end = at[0::3], at[1::3], at[2::3]
    kinks = [start[1:] - end[:-1]]
    kinks += [start[:1]] if plate.sides["left"] in HINGED else []
    kinks += [-end[-1:]] if plate.sides["right"] in HINGED else []
    matrix = sparse.vstack([middle - start, end - middle, *kinks], format="csr")
    return matrix, np.full((2, matrix.shape[0]), plate.beam / plate.scale)


def _edge_weights(plate: PlasticPlate, mesh: MeshTri) -> Floats:
    """Return the positive and negative strengths of rotations, shape (2, e, 3)."""
    x, y = _normals(mesh)
    strengths = plate.strengths_at(mesh.p[1, mesh.facets])
    across = (strengths[:2] * x**2 + strengths[2:] * y**2) * lengths(mesh)
    return np.einsum("cn,sne->sec", QUADRATIC, across)


def _normal_moments(mesh: MeshTri, moments: Floats) -> Floats:
    """Return the integrals of normal moments, shape (e, 3)."""
    triangles, normals = mesh.f2t[0], _normals(mesh)
    weights = lengths(mesh) * voigt(normals, normals)
    place = (mesh.t[:, triangles][:, None] == mesh.facets).argmax(axis=0)
    across = np.stack([(moments[triangles, node] * weights.T).sum(axis=1) for node in place])
    return (QUADRATIC @ across).T


def _normals(mesh: MeshTri) -> Floats:
    """Return a unit normal of each edge, shape (2, e)."""
    ends = mesh.p[:, mesh.facets]
    x, y = ends[:, 1] - ends[:, 0]
    return np.stack([y, -x]) / lengths(mesh)


def _load(plate: PlasticPlate, mesh: MeshTri, basis: Basis) -> Floats:
    """Return the power of the load by degrees of freedom."""
    from skfem import FacetBasis, LinearForm

    forces = plate.line_forces(mesh)
    loaded = np.flatnonzero(forces)
    load = plate.pressure * LinearForm(lambda v, _: v).assemble(basis)
    if loaded.size:
        line = FacetBasis(mesh, basis.elem, facets=loaded, intorder=4)
        load += LinearForm(lambda v, _: forces[loaded][:, None] * v).assemble(line)
    if plate.point:
        load[basis.nodal_dofs[0, plate.loaded_node(mesh)]] += 1.0
    return np.asarray(load)


def _matrix(values: Floats, rows: Indices, columns: Indices, shape: tuple[int, int]) -> sparse.csr_matrix:
    """Return a sparse matrix with broadcast rows and columns."""
    places = [np.broadcast_to(place, values.shape).ravel() for place in (rows, columns)]
    return sparse.csr_matrix((values.ravel(), places), shape=shape)
