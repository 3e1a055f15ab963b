"""Fields of a run, from its snapshots: what goes into the result folder and to other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.fields.series import FILE, FieldSeries, write_fields

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.run.observers import Snapshots

CELL_TYPES = {
    "ElementQuad1": "quad",
    "ElementQuadS2": "quad8",
    "ElementQuad2": "quad9",
    "ElementTriP1": "triangle",
    "ElementTriP2": "triangle6",
}
"""Cells of other programs by scikit-fem's elements, whose nodes come in the same order."""


def field_series(model: PlateModel, snapshots: Snapshots) -> FieldSeries:
    """Displacement, velocity, stress and energy density at the kept instants."""
    cell_type, cells = _cells(model)
    nodes = int(cells.max()) + 1
    place = _rigid_place(model, snapshots.positions[0])
    rigid = np.array([_rigid_place(model, positions) for positions in snapshots.positions])
    nodal = {
        "displacement": snapshots.positions - place,
        "elastic_displacement": snapshots.positions - rigid,
        "velocity": snapshots.velocities,
    }
    return FieldSeries(
        cell_type,
        place.T[:nodes].copy(),
        cells,
        snapshots.t,
        {name: np.ascontiguousarray(field.transpose(0, 2, 1)[:, :nodes]) for name, field in nodal.items()},
        _elemental(model, snapshots.positions),
    )


def series_of_ends(outcome: Any) -> FieldSeries:
    """Fields at the start and at the tail-slap of a run that reached it."""
    from fem.run.observers import Snapshots
    from fem.start.start_kinds import start_fields

    plan, strike = outcome.fe_plan, outcome.run.strike
    start = start_fields(plan.model, plan.start, plan.plate.start)
    states = zip(start, (strike.positions, strike.velocities), strict=True)
    return field_series(plan.model, Snapshots(np.array([0.0, strike.values["t"]]), *map(np.array, states)))


def keep_fields(outcome: Any, folder: Path) -> None:
    """Write the fields of a run into the folder, where some were kept."""
    if outcome.run.snapshots is not None:
        write_fields(folder / FILE, field_series(outcome.fe_plan.model, outcome.run.snapshots))


def _cells(model: PlateModel) -> tuple[str, np.ndarray]:
    """Type and nodes of the elements; the corners alone of one that other programs do not know."""
    scalar = model.discretisation.scalar
    known = CELL_TYPES.get(type(scalar.elem).__name__)
    if known:
        return known, np.ascontiguousarray(model.loop.table.connectivity.T)
    cells = model.discretisation.cells
    return ("quad" if cells.shape[1] == 4 else "triangle"), np.ascontiguousarray(cells)


def _rigid_place(model: Any, positions: np.ndarray) -> np.ndarray:
    """The unstrained plate where it fits these positions best, by mass, shape (2, nodes) [m]."""
    share = model.loop.mass / model.loop.mass.sum()
    body = model.discretisation.positions
    body = body - (body @ share)[:, None]
    centre = (positions @ share)[:, None]
    (a, b), (c, d) = (share * (positions - centre)) @ body.T
    angle = np.arctan2(c - b, a + d)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray(centre + np.array([[cosine, -sine], [sine, cosine]]) @ body)


def _elemental(model: PlateModel, positions: np.ndarray) -> dict[str, np.ndarray]:
    from fem.stability.deformed import element_stress

    found = np.array([element_stress(model, each) for each in positions])
    s_xx, s_yy, s_xy, density = found.transpose(1, 0, 2)
    middle, radius = 0.5 * (s_xx + s_yy), np.hypot(0.5 * (s_xx - s_yy), s_xy)
    return {
        "stress_von_mises": np.sqrt(middle**2 + 3.0 * radius**2),
        "stress_principal_1": middle + radius,
        "stress_principal_2": middle - radius,
        "strain_energy_density": density,
    }
