"""Lower bound of the collapse load of a plate, with its certificate.

Moments are linear in triangles with normal moments continuous over edges, as in the element of Hellan, Herrmann and
Johnson. Integrated by parts over quadratic deflections, equilibrium is finite: on each edge the effective shears
V = n.div m + dm_ns/ds of its triangles carry the line load, and at each node the corner forces m_ns the point load.
It is therefore exact. A pressure p adds the smooth field p x x^T / 6. The criterion is convex: it holds everywhere
if it holds at the Bernstein control points, of a linear field the nodes. A beam has a continuous, piecewise quadratic
moment.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from fem.limit import conic
from fem.limit.plate import HELD, LOCAL_EDGES, Floats, Indices, PlasticPlate, geometry, lengths, voigt

if TYPE_CHECKING:
    from skfem import MeshTri

__all__ = ["LowerBound", "lower_bound"]

RESIDUAL = 1e-12
"""Largest residual of equilibrium of a bound, in strengths of the plate [-]."""

REGULARISATION, PROJECTIONS = 1e-9, 30
"""Part of the unit matrix in the equations of the projection, and the most repetitions."""

ROUNDING = 1e-14
"""Part by which moments remain below the criterion, as it is evaluated with rounding [-]."""

CONTROL_POINTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Nodes that the control points of a quadratic field lie between; the first three are those of a linear field."""

TRIPLE = sparse.csc_matrix([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 2.0]])
"""Cone of the positive semidefinite matrices xx, yy, xy as a triple (s, u, v) with s >= sqrt(u^2 + v^2)."""

HALVED = np.array([[1.0], [1.0], [0.5]])
"""Factors of the weights xx, yy, xy of a product of two places."""


class LowerBound(NamedTuple):
    """Proven lower bound.

    Attributes
    ----------
    value : float
        Load factor [N], 0 without a certificate.
    moments : ndarray, shape (t, 3, 3)
        Moments xx, yy, xy at the nodes of the triangles at that load [N m/m].
    use : ndarray, shape (t, 3)
        Moment over strength at the nodes, at most 1 [-].
    residual : float
        Largest residual of equilibrium, over the largest strength [-].
    excess : float
        Largest moment over strength at all control points and along the beam, minus 1 [-].
    """

    value: float
    moments: Floats
    use: Floats
    residual: float
    excess: float


def lower_bound(plate: PlasticPlate, mesh: MeshTri) -> LowerBound:
    """Compute the largest load that linear moments carry.

    Parameters
    ----------
    plate : PlasticPlate
        With its strengths and its load.
    mesh : MeshTri
        Its triangles, with lines at the levels of the strengths and at the load.

    Returns
    -------
    LowerBound
        Whatever the cone program ends with is projected onto equilibrium and divided by the largest moment over
        strength; both are then evaluated again.
    """
    equations, beam = _equilibrium(plate, mesh)
    size = equations.shape[1]
    cones, strengths = _control_points(plate, mesh, size)
    bent = sparse.eye(size, format="csr")[beam]
    triples = sparse.kron(sparse.eye(len(strengths)), TRIPLE) @ cones
    limits = np.stack([strengths[:, [0, 2]], strengths[:, [1, 3]]])
    limits = np.stack([limits.sum(axis=2), limits[..., 0] - limits[..., 1], 0.0 * limits[..., 0]], axis=2)
    x = conic.minimum(
        -np.eye(1, size, size - 1)[0],
        (equations, np.zeros(equations.shape[0])),
        (sparse.vstack([bent, -bent]), np.full(2 * beam.size, plate.beam / plate.scale)),
        (sparse.vstack([triples, -triples]), limits.ravel()),
    )
    x = _projected(equations, x)

    def use(values: Floats) -> tuple[Floats, float]:
        at_points = moment_over_strength((cones @ values).reshape(-1, 3), strengths)
        return at_points, max(
            at_points.max(), np.abs(values[beam]).max(initial=0.0) / (plate.beam or 1.0) * plate.scale
        )

    largest = use(x)[1]
    x = x * (1.0 - ROUNDING) / largest if largest > 0.0 else np.full(size, np.nan)
    at_points, largest = use(x)
    residual, count = float(np.abs(equations @ x).max()), mesh.t.shape[1]
    proven = residual <= RESIDUAL and largest <= 1.0 and x[-1] > 0.0
    moments = plate.scale * (cones @ x)[: 9 * count].reshape(3, count, 3).transpose(1, 0, 2)
    value = plate.scale * float(x[-1]) if proven else 0.0
    return LowerBound(value, moments, at_points[: 3 * count].reshape(3, count).T, residual, largest - 1.0)


def moment_over_strength(moments: Floats, strengths: Floats) -> Floats:
    """Return the largest ratio of moments to Johansen's criterion.

    moments: xx, yy, xy, shape (n, 3); strengths: xx+, xx-, yy+, yy-, shape (n, 4). The criterion is met up to a factor
    whose inverse is the largest eigenvalue of M^-1/2 m M^-1/2.
    """
    ratios = []
    for sign, (of_x, of_y) in ((1.0, (0, 2)), (-1.0, (1, 3))):
        xx, yy = sign * moments[:, 0] / strengths[:, of_x], sign * moments[:, 1] / strengths[:, of_y]
        xy = moments[:, 2] / np.sqrt(strengths[:, of_x] * strengths[:, of_y])
        ratios.append(0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy))
    return np.maximum(*ratios)


def _equilibrium(plate: PlasticPlate, mesh: MeshTri) -> tuple[sparse.csr_matrix, Indices]:
    """Return the equations of equilibrium, and the columns of the beam.

    Columns: nine moments of each triangle, those of the beam, load factor. Rows: forces of edges and of nodes, jumps of
    the normal moment at both ends of edges, ends of the beam.
    """
    rows, values, pressure = _of_triangles(mesh)
    count, edges, nodes = mesh.t.shape[1], mesh.facets.shape[1], mesh.p.shape[1]
    columns = np.arange(9 * count).reshape(count, 9).T
    places = [place.ravel() for place in np.broadcast_arrays(rows[:, None], columns)]
    height = 3 * edges + nodes
    of_plate = sparse.csr_matrix((values.ravel(), places), shape=(height, 9 * count))
    load = np.bincount(rows.ravel(), plate.pressure * pressure.ravel(), minlength=height).astype(float)
    load[:edges] = load[:edges] - plate.line_forces(mesh) * lengths(mesh)
    if plate.point:
        load[edges + plate.loaded_node(mesh)] -= 1.0
    kinds = plate.kinds(mesh)
    held = np.isin(kinds, HELD)
    moving = np.ones(nodes, dtype=bool)
    moving[mesh.facets[:, held]] = False
    required = np.concatenate([~held, moving, np.repeat(~np.isin(kinds, ("clamped", "symmetric")), 2)])
    of_beam, ends = _of_beam(plate, mesh)
    matrix = sparse.hstack([of_plate, of_beam, load[:, None]], format="csr")[required]
    further = sparse.csr_matrix(
        (np.ones(len(ends)), (range(len(ends)), ends)), shape=(len(ends), of_beam.shape[1])
    )
    before, after = (sparse.csr_matrix((len(ends), width)) for width in (9 * count, 1))
    matrix = sparse.vstack([matrix, sparse.hstack([before, further, after])], format="csr")
    return matrix, 9 * count + np.arange(of_beam.shape[1])


def _of_triangles(mesh: MeshTri) -> tuple[Indices, Floats, Floats]:
    """Return the forces and normal moments of the triangles.

    Rows (15, t) of `_equilibrium`, their values of nine moments (15, 9, t), and those of a unit pressure (15, t).
    """
    of, count, edges = geometry(mesh), mesh.t.shape[1], mesh.facets.shape[1]
    rows, values, pressure = [], [], []
    for k, (a, b) in enumerate(LOCAL_EDGES):
        edge, normal, tangent = mesh.t2f[k], of.normals[k], of.tangents[k]
        length = lengths(mesh)[edge]
        sign = np.where(mesh.f2t[0, edge] == np.arange(count), 1.0, -1.0)
        shear = length * np.concatenate([voigt(normal, gradient) for gradient in of.gradients])
        twist, bend = np.zeros((3, 9, count)), np.zeros((3, 9, count))
        for node in (a, b):
            twist[node, 3 * node : 3 * node + 3] = voigt(normal, tangent)
            bend[node, 3 * node : 3 * node + 3] = sign * voigt(normal, normal)
        values += [twist[a] - twist[b] - shear, -twist[a], twist[b], bend[a], bend[b]]
        jump = edges + mesh.p.shape[1] + 2 * edge
        rows += [edge, edges + mesh.t[a], edges + mesh.t[b], jump, jump + 1]
        across, start, end = (
            (direction * mesh.p[:, mesh.t[node]]).sum(axis=0) / 6.0
            for direction, node in ((normal, a), (6.0 * tangent, a), (6.0 * tangent, b))
        )
        normal_moment = 6.0 * sign * across**2
        pressure += [-4.0 * length * across, -start * across, end * across, normal_moment, normal_moment]
    return np.stack(rows), np.stack(values), np.stack(pressure)


def _of_beam(plate: PlasticPlate, mesh: MeshTri) -> tuple[sparse.csr_matrix, list[int]]:
    """Return the forces of the beam and its free ends.

    Rows are those of `_equilibrium`.

    Columns: moments at its nodes, and the middle Bernstein coefficients of its edges, from left to right.
    """
    edges = plate.top_edges(mesh) if plate.beam else np.empty(0, dtype=int)
    total, count = 3 * mesh.facets.shape[1] + mesh.p.shape[1], edges.size
    if not count:
        return sparse.csr_matrix((total, 0)), []
    ends = np.take_along_axis(
        mesh.facets[:, edges], np.argsort(mesh.p[0, mesh.facets[:, edges]], axis=0), axis=0
    )
    length, of_node = lengths(mesh)[edges], mesh.facets.shape[1]
    first, middle, last = np.arange(count), count + 1 + np.arange(count), np.arange(1, count + 1)
    rows = np.stack([edges] * 3 + [of_node + ends[0]] * 2 + [of_node + ends[1]] * 2)
    columns = np.stack([first, middle, last, middle, first, last, middle])
    values = np.array([1.0, -2.0, 1.0, 1.0, -1.0, -1.0, 1.0])[:, None] * 2.0 / length
    matrix = sparse.csr_matrix(
        (values.ravel(), (rows.ravel(), columns.ravel())), shape=(total, 2 * count + 1)
    )
    free = [plate.sides[side] not in ("clamped", "symmetric") for side in ("left", "right")]
    return matrix, [place for place, is_free in zip((0, count), free, strict=True) if is_free]


def _control_points(plate: PlasticPlate, mesh: MeshTri, size: int) -> tuple[sparse.csr_matrix, Floats]:
    """Return moments and strengths at the control points.

    Moments as a matrix with three rows each, over the columns of `_equilibrium`; strengths of shape (n, 4).
    """
    count, points = mesh.t.shape[1], CONTROL_POINTS[: 6 if plate.pressure else 3]
    x = mesh.p[:, mesh.t]
    strengths = plate.strengths_at(x[1])
    triangles, rows, columns, values = np.arange(count), [], [], []
    for number, (a, b) in enumerate(points):
        of_load = plate.pressure / 6.0 * voigt(x[:, a], x[:, b]) * HALVED
        for part in range(3):
            row = 3 * (number * count + triangles) + part
            rows += [row] * 3
            columns += [9 * triangles + 3 * a + part, 9 * triangles + 3 * b + part, np.full(count, size - 1)]
            values += [np.full(count, 0.5)] * 2 + [of_load[part]]
    places = (np.concatenate(rows), np.concatenate(columns))
    matrix = sparse.csr_matrix((np.concatenate(values), places), shape=(3 * count * len(points), size))
    at_points = [0.5 * (strengths[:, a] + strengths[:, b]) for a, b in points]
    return matrix, np.concatenate(at_points, axis=1).T


def _projected(equations: sparse.csr_matrix, x: Floats) -> Floats:
    """Return the nearest moments in equilibrium with the load factor.

    Equations may depend on each other: the regularised ones are solved repeatedly, down to rounding.
    """
    moments = equations[:, :-1]
    normal = (moments @ moments.T).tocsc()
    solver = linalg.splu(normal + REGULARISATION * sparse.eye(normal.shape[0], format="csc"))
    for _ in range(PROJECTIONS):
        residual = equations @ x
        if not np.abs(residual).max() > 0.01 * RESIDUAL:
            break
        x = x - np.append(moments.T @ solver.solve(residual), 0.0)
    return x
