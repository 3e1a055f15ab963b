"""Model of a plate in unilateral contact with a wall."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fem.explicit.impact_loop import ImpactLoopParameters
from fem.laws.tyres import Axles
from fem.model import plate_model
from fem.model.contact_points import wall_contact
from fem.model.plate_model import PlateModel
from fem.model.wall_model import with_wall
from fem.plate import spectrum
from fem.plate.discretisation import Discretisation
from fem.plate.properties import (
    AxleProperties,
    StepProperties,
    UnitProperties,
    WallProperties,
)

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
        Where a mesh cannot carry the inertia, or has too few nodes for a patch of contact; where a hinge cannot be
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
    contact, groups = wall_contact(touching, unit.masses, first.plate)
    densest = replace(first.plate, density=max(properties.plate.density for properties in units))
    axles = _axles([(*part, properties.axles) for part, properties in zip(parts, units, strict=True)])
    model = plate_model.unfinished_model(
        unit, densest, ImpactLoopParameters, contact=contact, wall=None, hinges=hinges, axles=axles
    )
    # Neither contact nor hinges bound the step, see fem.laws.unilateral and fem.laws.hinges.
    model = plate_model.with_time_step(model, spectrum.FREE, densest, step)
    model = replace(model, contact_groups=groups)
    return model if wall is None else with_wall(model, wall, step)


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
