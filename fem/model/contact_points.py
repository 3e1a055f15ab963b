"""Contact points of plates, with their law and their groups."""

from collections.abc import Sequence

import numpy as np

from fem.laws import unilateral
from fem.laws.contact_forces import PointCrush
from fem.laws.wall_contact import BoundaryContact
from fem.plate.discretisation import Discretisation, patch_weights
from fem.plate.properties import ContactProperties, PlateProperties, StripProperties

Patch = tuple[np.ndarray, np.ndarray]
"""Nodes of a contact point and their weights."""

CORNERS = 2
"""Corners of a side."""

INSIDE = 1e-12
"""Distance of a place from the edge of the plate over its size, so that it is within an element."""

NEGLIGIBLE = 1e-9
"""Weights, and distances over the length of the side, below which they are rounding errors."""


def wall_contact(
    parts: Sequence[tuple[Discretisation, np.ndarray, ContactProperties]],
    masses: np.ndarray,
    plate: PlateProperties,
) -> tuple[BoundaryContact, np.ndarray]:
    """Return the contact points of all plates with law and groups.

    parts: of each plate its discretisation, its nodes in the model, and its contact; masses: of all nodes [kg]. Groups
    are numbered plate by plate, in each first the strips on the side of the wall, then those on the far side; without
    crush the strips are the corners, and a point belongs to the nearest. Raises ModelError where a patch does not lie
    on its side.
    """
    points, groups, laws = list[Patch](), list[int](), list[PointCrush]()
    contact, before = parts[0][2], 0
    for discretisation, numbers, properties in parts:
        if properties.law == "crush":
            patches, members, crush = _crushing(discretisation, properties)
            laws += crush
        else:
            patches, members = _boundary(discretisation)
        points += [(numbers[nodes], weights) for nodes, weights in patches]
        groups += [before + group for group in members]
        before += 2 * (len(properties.strips) or CORNERS)
    count = len(points)
    if contact.law == "exact":
        law: unilateral.ExactContact | unilateral.PenaltyContact | unilateral.Crush = unilateral.ExactContact(
            count
        )
    elif contact.law == "penalty":
        stiffness = unilateral.penalty_stiffness(plate.youngs_modulus, plate.thickness, contact.penalty_scale)
        law = unilateral.PenaltyContact(np.full(count, stiffness))
    else:
        law = _crush(np.array(laws).T)
    nodes, weights = (np.concatenate(column) for column in zip(*points, strict=True))
    first = np.cumsum([0, *(len(point[0]) for point in points)])
    mobility = np.add.reduceat(weights**2 / masses[nodes], first[:-1])
    boundary = BoundaryContact(first, nodes.astype(np.int64), weights, mobility, law, contact.friction)
    return boundary, np.array(groups)


def _crush(laws: np.ndarray) -> unilateral.Crush:
    """Return the crush of all points.

    laws: rows of the fields of `PointCrush`; a part that no point has is None.
    """
    stiffness, initial, returned, plateau, unloading, hardening = map(np.ascontiguousarray, laws)
    return unilateral.Crush(
        stiffness,
        initial,
        float(returned[0]) if (returned == returned[0]).all() else returned,
        plateau if np.isfinite(plateau).any() else None,
        unloading if (unloading > 0.0).any() else None,
        hardening if (hardening > 0.0).any() else None,
    )


def _boundary(discretisation: Discretisation) -> tuple[list[Patch], list[int]]:
    """Return the boundary nodes as contact points with their nearest corners.

    Corners are front and rear on the side of the wall, then on the far side.
    """
    nodes = np.unique(discretisation.scalar.get_dofs().flatten())
    x, y = discretisation.positions
    rear = x.max() - x[nodes] > 0.5 * np.ptp(x)
    far = y[nodes] - y.min() > 0.5 * np.ptp(y)
    return [(np.array([node]), np.ones(1)) for node in nodes], (rear + CORNERS * far).tolist()


def _crushing(
    discretisation: Discretisation, contact: ContactProperties
) -> tuple[list[Patch], list[int], list[PointCrush]]:
    """Return points, groups and laws of a plate that crushes."""
    points, groups, laws = list[Patch](), list[int](), list[PointCrush]()
    x, y = discretisation.positions
    for far, (edge, inwards) in enumerate(((y.min(), 1.0), (y.max(), -1.0))):
        side = np.flatnonzero(np.abs(y - edge) < 1e-9 * np.ptp(y))
        side = side[np.argsort(-x[side])]
        s, is_end = x.max() - x[side], side < discretisation.scalar.mesh.nvertices  # which are numbered first
        for number, strip in enumerate(contact.strips):
            places, weights, lengths = _loads(s, s[is_end], strip, contact.patch_length)
            if strip.inset == 0.0 and (nodes := _nodes_at(s, places)) is not None:
                points += [(side[nodes[row != 0.0]], row[row != 0.0]) for row in weights]
            else:
                points += _interpolated(discretisation, places, edge + inwards * strip.inset, weights)
            laws += [_of_length(strip.law, length) for length in lengths]
            groups += len(lengths) * [far * len(contact.strips) + number]
    return points, groups, laws


def _of_length(law: PointCrush, length: float) -> PointCrush:
    """Return the law of a length [m] of a line."""
    scaled = {name: length * getattr(law, name) for name in PointCrush._fields if name != "returned"}
    return law._replace(**scaled)


def _loads(
    s: np.ndarray, ends: np.ndarray, strip: StripProperties, patch_length: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the contact points of a strip as weighted places.

    s: of the side's nodes, ends: of those at the ends of elements [m]. Places behind the front [m], shape (k,), their
    weights in each point, shape (points, k), and the length of line of each point [m], 1 of a point alone. Points of a
    line are its ends, those of elements and the middles between them, with lengths by Simpson's rule, which integrates
    a shape function. Those of a patch are counted from the nearer end.
    """
    if strip.end > strip.begin:
        margin = NEGLIGIBLE * s[-1]
        within = ends[(ends > strip.begin + margin) & (ends < strip.end - margin)]
        ends = np.array([strip.begin, *within, strip.end])
        parts = np.diff(ends)
        places, lengths = np.empty((2, 2 * parts.size + 1))
        places[::2], places[1::2] = ends, ends[:-1] + 0.5 * parts
        lengths[::2], lengths[1::2] = np.append(parts, 0.0) + np.append(0.0, parts), 4.0 * parts
        return places, np.eye(places.size), lengths / 6.0
    if patch_length == 0.0:
        return np.array([strip.begin]), np.eye(1), np.ones(1)
    place, order = strip.begin, np.arange(s.size)
    if place > 0.5 * s[-1]:
        place, order = s[-1] - place, order[::-1]
    nodes, weights = patch_weights(order, np.abs(s[order] - s[order[0]]), patch_length, place)
    return s[nodes], weights[None], np.ones(1)


def _nodes_at(s: np.ndarray, places: np.ndarray) -> np.ndarray | None:
    """Return the nodes at these places, or None.

    s: of the nodes, places: behind the front [m]. Nodes are numbered from the front.
    """
    nearest = np.abs(s[:, None] - places).argmin(axis=0)
    return nearest if np.abs(s[nearest] - places).max() <= NEGLIGIBLE * s[-1] else None


def _interpolated(
    discretisation: Discretisation, places: np.ndarray, y: float, weights: np.ndarray
) -> list[Patch]:
    """Return contact points by the shape functions at places inside a plate.

    places: behind the front, y: of all [m]; weights: of the places in each point, shape (points, places).
    """
    from scipy import sparse

    positions = discretisation.positions
    low, high = positions.min(axis=1, keepdims=True), positions.max(axis=1, keepdims=True)
    margin = INSIDE * (high - low)
    at = np.clip([high[0] - places, np.full_like(places, y)], low + margin, high - margin)
    rows = sparse.csr_matrix(weights) @ discretisation.scalar.probes(at).tocsr()
    points = list[Patch]()
    for first, last in zip(rows.indptr, rows.indptr[1:], strict=False):
        nodes, values = rows.indices[first:last], rows.data[first:last]
        used = np.abs(values) > NEGLIGIBLE
        points.append((nodes[used], values[used] / values[used].sum()))
    return points
