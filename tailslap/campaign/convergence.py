"""Richardson extrapolation and grid convergence indices of refined runs.

Each mesh, or time step, is twice as fine as the one before.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from postprocess.comparison import quantities
from postprocess.comparison.grid_convergence import (
    CAUTIOUS_FACTOR,
    SAFETY_FACTOR,
    GridConvergence,
    grid_convergence,
)
from postprocess.comparison.quantities import KEYS
from tailslap.campaign.records import Record
from tailslap.scene.schema import Scene

MAX_ORDER = 2.0
"""Order of linear elements, of discontinuous loads and of central differences. A higher observed order is accidental.
"""

MIN_HALVED = (4, 2)
"""Fewest elements along and across a halved mesh. Otherwise the scene's own mesh is the coarsest."""

MIN_KNOWN = 1e-12
"""Relative rounding error of a run, which bounds the uncertainty of every limit from below."""


def three_meshes(scene: Scene) -> tuple[tuple[int, int], ...]:
    """Return three meshes of a scene, each twice as fine.

    The second is the scene's own mesh, or the first where it cannot be halved. The numbers of elements must be decided.
    """
    along, across = scene.needed_plate.counts
    patch, length = scene.corner.patch_length, scene.vehicle.length
    halves = along % 2 == 0 and across % 2 == 0 and along // 2 >= MIN_HALVED[0]
    halves = halves and across // 2 >= MIN_HALVED[1] and (patch is None or patch * (along // 2) >= length)
    coarse = (along // 2, across // 2) if halves else (along, across)
    return tuple((n * coarse[0], n * coarse[1]) for n in (1, 2, 4))


class Limit(NamedTuple):
    """Limits of quantities and their relative uncertainty.

    The uncertainty is the largest grid convergence index.
    """

    values: dict[str, float]
    uncertainty: float

    def error_of(self, values: Mapping[str, float]) -> float:
        """Return the largest relative distance from the limit.

        It is at least the uncertainty of the limit, and NaN where a value is not finite.
        """
        error = quantities.largest(quantities.relative_difference(values, self.values, tuple(self.values)))
        return max(error, self.uncertainty) if math.isfinite(error) else math.nan


def finite(records: Iterable[Record]) -> list[Record]:
    """Return the records whose values are all finite."""
    return [r for r in records if "values" in r and all(map(math.isfinite, r["values"].values()))]


def halved(records: list[Record]) -> bool:
    """Return True if the last time steps are halves.

    On soft plates the minimum number of steps may prevent it.
    """
    steps = [record.get("steps", 0) for record in records[-3:]]
    return all(earlier and abs(later / earlier - 2.0) < 0.02 for earlier, later in pairwise(steps))


def grids_of(records: Iterable[Record], names: Sequence[str] = KEYS) -> dict[str, GridConvergence]:
    """Return the grid convergence of each quantity.

    It is that of the last three finite records, and empty for fewer.
    """
    values = [record["values"] for record in finite(records)][-3:]
    if len(values) < 3:
        return {}
    coarse, medium, fine = values
    three = {name: (fine[name], medium[name], coarse[name]) for name in names}
    return {name: grid_convergence(values, (2.0, 2.0)) for name, values in three.items()}


def limit_of(records: Iterable[Record], names: Sequence[str] = KEYS) -> Limit:
    """Return the Richardson extrapolation of the last three records.

    Without an observed order, the limit is the last value, and its uncertainty is three times the last change.
    """
    values, uncertainties = dict.fromkeys(names, math.nan), [MIN_KNOWN]
    grids = grids_of(records, names)
    for name, grid in grids.items():
        fine, change, safety = grid.values[0], grid.values[0] - grid.values[1], CAUTIOUS_FACTOR
        values[name] = fine
        if grid.behaviour == "converging":
            change, safety = change / (2.0 ** min(grid.order, MAX_ORDER) - 1.0), SAFETY_FACTOR
            values[name] = fine + change
        uncertainties.append(safety * abs(change / fine))
    return Limit(values, max(uncertainties) if grids else math.nan)


def convergence_index(fine: float, medium: float, coarse: float) -> float:
    """Return the grid convergence index of the fine mesh.

    An observed order above that of the elements is accidental and is replaced by theirs.
    """
    grid = grid_convergence((fine, medium, coarse), (2.0, 2.0))
    if grid.behaviour != "converging" or grid.order <= MAX_ORDER:
        return grid.gci_fine
    return SAFETY_FACTOR * abs((fine - medium) / fine) / (2.0**MAX_ORDER - 1.0)
