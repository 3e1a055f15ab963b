"""Fields of a run at some instants, for files and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem.plate.kinds import ELEMENT_KINDS
from fem.start import start_kinds
from postprocess.fields import series

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.run.corner import StrikeState
    from fem.run.observers import Snapshots
    from tailslap.case.corner.corner_plan import CornerPlan

Array = NDArray[np.float64]


def field_series(model: PlateModel, snapshots: Snapshots) -> series.FieldSeries:
    """Return displacement, velocity, stress and energy density at some instants."""
    cell_type, cells = _cells(model)
    nodes = int(cells.max()) + 1
    place = _rigid_place(model, snapshots.positions[0])
    rigid = np.array([_rigid_place(model, positions) for positions in snapshots.positions])
    nodal = {
        "displacement": snapshots.positions - place,
        "elastic_displacement": snapshots.positions - rigid,
        "velocity": snapshots.velocities,
    }
    return series.FieldSeries(
        cell_type,
        place.T[:nodes].copy(),
        cells,
        snapshots.t,
        {name: np.ascontiguousarray(field.transpose(0, 2, 1)[:, :nodes]) for name, field in nodal.items()},
        element_fields(model, snapshots.positions),
    )


def series_of_ends(plan: CornerPlan, strike: StrikeState) -> series.FieldSeries:
    """Return the fields at the start and at the tail-slap."""
    from fem.run.observers import Snapshots

    start = start_kinds.start_fields(plan.model, plan.start, plan.plate.start)
    states = zip(start, (strike.positions, strike.velocities), strict=True)
    return field_series(plan.model, Snapshots(np.array([0.0, strike.values["t"]]), *map(np.array, states)))


def _cells(model: PlateModel) -> tuple[str, NDArray[np.int64]]:
    """Return type and nodes of the elements.

    An element that other programs do not have is reduced to its corners.
    """
    scalar = model.discretisation.scalar
    element = type(scalar.elem).__name__
    kind = next((kind for kind in ELEMENT_KINDS.values() if kind.element == element), None)
    if kind and kind.cell_type:
        return kind.cell_type, np.ascontiguousarray(model.parameters.table.connectivity.T)
    cells = model.discretisation.cells
    return ("quad" if cells.shape[1] == 4 else "triangle"), np.ascontiguousarray(cells)


def _rigid_place(model: PlateModel, positions: Array) -> Array:
    """Return the unstrained plate at its best fit, shape (2, nodes) [m]."""
    fraction = model.parameters.mass / model.parameters.mass.sum()
    body = model.discretisation.positions
    body = body - (body @ fraction)[:, None]
    centre = (positions @ fraction)[:, None]
    (a, b), (c, d) = (fraction * (positions - centre)) @ body.T
    angle = np.arctan2(c - b, a + d)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray(centre + np.array([[cosine, -sine], [sine, cosine]]) @ body)


def element_fields(model: PlateModel, positions: Array) -> dict[str, Array]:
    """Return the fields of the elements, shape (instants, elements).

    positions: of the nodes, shape (instants, 2, nodes) [m].
    """
    from fem.stability.deformed import element_stress

    stress = np.array([element_stress(model, deformed) for deformed in positions])
    s_xx, s_yy, s_xy, density = stress.transpose(1, 0, 2)
    middle, radius = 0.5 * (s_xx + s_yy), np.hypot(0.5 * (s_xx - s_yy), s_xy)
    return {
        "stress_von_mises": np.sqrt(middle**2 + 3.0 * radius**2),
        "stress_principal_1": middle + radius,
        "stress_principal_2": middle - radius,
        "strain_energy_density": density,
    }
