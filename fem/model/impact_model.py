"""Model of a plate in unilateral contact with a wall."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fem.explicit.impact_loop import ImpactLoopParameters
from fem.laws import unilateral
from fem.laws.tyres import Axles
from fem.laws.wall_contact import BoundaryContact
from fem.model import plate_model
from fem.model.plate_model import PlateModel
from fem.model.wall_model import with_wall
from fem.plate import spectrum
from fem.plate.discretisation import Discretisation, patch_weights
from fem.plate.properties import (
    AxleProperties,
    ContactProperties,
    PlateProperties,
    StepProperties,
    UnitProperties,
    WallProperties,
)

Patch = tuple[np.ndarray, np.ndarray]
"""Nodes of a contact point and their weights."""

AXLE_POINTS = 32
"""Points of an axle's line at which the displacement of the plate is taken."""


def build_impact_model(
    units: Sequence[UnitProperties], step: StepProperties, wall: WallProperties | None = None
) -> PlateModel:
    """Assemble the model of a vehicle or a train.

    Each unit has a plate. The plates do not touch one another.

    Parameters
    ----------
    units : sequence of UnitProperties
        From the first; one for a single vehicle.
    step : StepProperties
        Time step and damping; elastic velocities of a train cannot be damped.
    wall : WallProperties or None
        A deformable wall; None for a rigid one.

    Returns
    -------
    PlateModel
        Its `parameters` are an `ImpactLoopParameters`, of a train with hinges.

    Raises
    ------
    ModelError
        Where a mesh cannot carry the inertia, or has too few nodes for the patch of a corner; where a hinge cannot be
        distributed as requested; where the wall has no foundation or too many elements.
    """
    first, hinges = units[0], None
    if len(units) > 1:
        from fem.model.train_model import train_plate

        unit, parts, hinges = train_plate(units)
    else:
        unit = plate_model.unit_plate(first.mesh, first.plate)
        parts = [(unit.discretisation, np.arange(unit.masses.size))]
    touching = [(*part, properties.contact) for part, properties in zip(parts, units, strict=True)]
    contact = wall_contact(touching, unit.masses, first.plate)
    densest = replace(first.plate, density=max(properties.plate.density for properties in units))
    axles = _axles([(*part, properties.axles) for part, properties in zip(parts, units, strict=True)])
    model = plate_model.unfinished_model(
        unit, densest, ImpactLoopParameters, contact=contact, wall=None, hinges=hinges, axles=axles
    )
    # Neither contact nor hinges bound the step, see fem.laws.unilateral and fem.laws.hinges.
    model = plate_model.with_time_step(model, spectrum.FREE, densest, step)
    return model if wall is None else with_wall(model, wall, step)


def wall_contact(
    parts: Sequence[tuple[Discretisation, np.ndarray, ContactProperties]],
    masses: np.ndarray,
    plate: PlateProperties,
) -> BoundaryContact:
    """Return the contact points of all plates with their law.

    parts: of each plate its discretisation, its nodes in the model, and its contact; masses: of all nodes [kg]. A
    corner that crushes and has a layer is present twice. Raises ModelError where the patch of a corner does not lie
    on its side.
    """
    points, laws, contact = list[Patch](), list[np.ndarray](), parts[0][2]
    for discretisation, numbers, properties in parts:
        boundary, lengths = boundary_of(discretisation)
        patches: list[Patch] = [(np.array([node]), np.ones(1)) for node in boundary]
        if properties.law == "crush":
            patches, crush = _crushing(discretisation.positions, boundary, lengths, properties)
            laws.append(crush)
        points += [(numbers[nodes], weights) for nodes, weights in patches]
    count = len(points)
    if contact.law == "exact":
        law: unilateral.ExactContact | unilateral.PenaltyContact | unilateral.Crush = unilateral.ExactContact(
            count
        )
    elif contact.law == "penalty":
        stiffness = unilateral.penalty_stiffness(plate.youngs_modulus, plate.thickness, contact.penalty_scale)
        law = unilateral.PenaltyContact(np.full(count, stiffness))
    elif contact.law == "crush":
        law = _crush(np.concatenate(laws, axis=1))
    else:
        raise ValueError(f"there is no contact law {contact.law!r}")
    nodes, weights = (np.concatenate(column) for column in zip(*points, strict=True))
    first = np.cumsum([0, *(len(point[0]) for point in points)])
    mobility = np.add.reduceat(weights**2 / masses[nodes], first[:-1])
    return BoundaryContact(first, nodes.astype(np.int64), weights, mobility, law, contact.friction)


def _crush(laws: np.ndarray) -> unilateral.Crush:
    """Return the crush of all points.

    laws: rows of the fields of `PointCrush`; a part that no point has is None.
    """
    stiffness, initial, returned, plateau, unloading = map(np.ascontiguousarray, laws)
    return unilateral.Crush(
        stiffness,
        initial,
        float(returned[0]) if (returned == returned[0]).all() else returned,
        plateau if np.isfinite(plateau).any() else None,
        unloading if (unloading > 0.0).any() else None,
    )


def _axles(parts: Sequence[tuple[Discretisation, np.ndarray, tuple[AxleProperties, ...]]]) -> Axles | None:
    """Return the axles of all plates, or None.

    parts: discretisation, nodes in the model and axles of each.
    """
    lines = [
        (every, *_axle_line(discretisation, axle.position), axle)
        for discretisation, every, axles in parts
        for axle in axles
    ]
    if not lines:
        return None
    first = np.cumsum([0, *(len(nodes) for _, nodes, *_ in lines)])
    nodes = np.concatenate([every[nodes] for every, nodes, *_ in lines]).astype(np.int64)
    weights, slopes = (np.concatenate([line[k] for line in lines]) for k in (2, 3))
    load, friction, cornering = np.array([line[4][1:] for line in lines]).T.copy()
    return Axles(first, nodes, weights, slopes, load, friction, cornering)


def _axle_line(discretisation: Discretisation, position: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return nodes, weights and slopes of a line across the plate.

    position: behind the front [m]; weights, slopes: see `Axles`.
    """
    (x, y), scalar = discretisation.positions, discretisation.scalar
    inside = 1e-9 * np.ptp(x)
    place = np.clip(x.max() - position, x.min() + inside, x.max() - inside)
    across = np.ptp(y) * ((np.arange(AXLE_POINTS) + 0.5) / AXLE_POINTS - 0.5)
    points = np.array([np.full(AXLE_POINTS, place), 0.5 * (y.min() + y.max()) + across])
    values = scalar.probes(points).toarray()
    weights, slopes = values.mean(axis=0), across @ values / (across @ across)
    nodes = np.flatnonzero((weights != 0.0) | (slopes != 0.0))
    return nodes, weights[nodes], slopes[nodes]


def boundary_of(discretisation: Discretisation) -> tuple[np.ndarray, np.ndarray]:
    """Return the boundary nodes and their lengths.

    A length [m] is that of the sides that the node represents. Both have the shape (boundary nodes,).
    """
    import skfem

    scalar = discretisation.scalar
    sides = skfem.FacetBasis(scalar.mesh, scalar.elem)
    lengths = skfem.LinearForm(lambda v, w: v).assemble(sides)
    nodes = np.unique(scalar.get_dofs().flatten())
    return nodes.astype(np.int64), lengths[nodes]


def _crushing(
    positions: np.ndarray, boundary: np.ndarray, lengths: np.ndarray, contact: ContactProperties
) -> tuple[list[Patch], np.ndarray]:
    """Return contact points of a plate that crushes, and their laws.

    Points are the corners, each a node or a patch of its side, and with a layer all nodes of the boundary. Corners are
    front and rear on the side of the wall, then on the far side. Rows of the laws are the fields of `PointCrush`,
    columns the points.
    """
    (rear, low), (front, high) = positions.min(axis=1), positions.max(axis=1)
    places = ((front, low), (rear, low), (front, high), (rear, high))
    nodes = [int(np.linalg.norm(positions.T - place, axis=1).argmin()) for place in places]
    points = [_corner(boundary, positions, node, contact.patch_length) for node in nodes]
    laws = np.array(2 * [contact.front, contact.rear or contact.front]).T
    if contact.side_stiffness > 0.0:
        points += [(np.array([node]), np.ones(1)) for node in boundary]
        layer = np.outer(contact.side, np.ones(len(boundary)))
        layer[[0, 1, 3, 4]] *= lengths
        laws = np.concatenate([laws, layer], axis=1)
    return points, laws


def _corner(boundary: np.ndarray, positions: np.ndarray, node: int, length: float) -> Patch:
    """Return nodes and weights of a corner.

    length [m]: of the long side that ends at this corner.
    """
    if length == 0.0:
        return np.array([node]), np.ones(1)
    x, y = positions
    side = boundary[np.abs(y[boundary] - y[node]) < 1e-9 * np.ptp(y)]
    side = side[np.argsort(np.abs(x[side] - x[node]))]
    return patch_weights(side, np.abs(x[side] - x[node]), length)
