"""Limits of refined meshes or time steps, each twice as fine as the one before: Richardson's extrapolation, grid
convergence index."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from postprocess.comparison import grid_convergence, quantities
from postprocess.comparison.quantities import KEYS
from tailslap.scene.schema import Scene

Record = dict[str, Any]

# Order of linear elements, of loads that jump and of central differences; a higher observed order is luck.
MAX_ORDER = 2.0

# Elements along and across that the coarsest mesh keeps at least; otherwise the scene's own is the coarsest.
MIN_HALVED = (4, 2)

# Relative rounding of a run: no limit is known better.
MIN_KNOWN = 1e-12


def three_meshes(scene: Scene) -> tuple[tuple[int, int], ...]:
    """The scene's mesh halved, itself, doubled; or where it cannot be halved, itself, doubled, and doubled again.

    scene: one whose elements are decided.
    """
    along, across = scene.needed_plate.counts
    patch, length = scene.corner.patch_length, scene.vehicle.length
    halves = along % 2 == 0 and across % 2 == 0 and along // 2 >= MIN_HALVED[0]
    halves = halves and across // 2 >= MIN_HALVED[1] and (patch is None or patch * (along // 2) >= length)
    coarse = (along // 2, across // 2) if halves else (along, across)
    return tuple((n * coarse[0], n * coarse[1]) for n in (1, 2, 4))


class Limit(NamedTuple):
    """Quantities in a limit of refined meshes or time steps, and how well they are known: the largest grid convergence
    index."""

    values: dict[str, float]
    known: float

    def error_of(self, values: Mapping[str, float]) -> float:
        """Largest relative distance from the limit, no less than that is known to; NaN where one value is none."""
        error = quantities.largest(quantities.relative_difference(values, self.values, tuple(self.values)))
        return max(error, self.known) if math.isfinite(error) else math.nan


NO_LIMIT = Limit({}, math.nan)


def finite(records: Iterable[Record]) -> list[Record]:
    return [r for r in records if "values" in r and all(map(math.isfinite, r["values"].values()))]


def halved(records: list[Record]) -> bool:
    """True if of the last three each has twice the steps of the one before; on soft plates the least number of steps
    may stand against it."""
    steps = [record.get("steps", 0) for record in records[-3:]]
    return all(earlier and abs(later / earlier - 2.0) < 0.02 for earlier, later in pairwise(steps))


def grids_of(
    records: Iterable[Record], names: Sequence[str] = KEYS
) -> dict[str, grid_convergence.GridConvergence]:
    """Grid convergence of each quantity over the three finest, each half the one before; empty for fewer."""
    values = [record["values"] for record in finite(records)][-3:]
    if len(values) < 3:
        return {}
    coarse, medium, fine = values
    three = {name: (fine[name], medium[name], coarse[name]) for name in names}
    return {name: grid_convergence.grid_convergence(values, (2.0, 2.0)) for name, values in three.items()}


def limit_of(records: Iterable[Record], names: Sequence[str] = KEYS) -> Limit:
    """Richardson's limit of the last three records; without an order the last and three times its change."""
    values, known = dict.fromkeys(names, math.nan), [MIN_KNOWN]
    grids = grids_of(records, names)
    for name, grid in grids.items():
        fine, change, safety = (
            grid.values[0],
            grid.values[0] - grid.values[1],
            grid_convergence.CAUTIOUS_FACTOR,
        )
        values[name] = fine
        if grid.behaviour == "converging":
            change, safety = (
                change / (2.0 ** min(grid.order, MAX_ORDER) - 1.0),
                grid_convergence.SAFETY_FACTOR,
            )
            values[name] = fine + change
        known.append(safety * abs(change / fine))
    return Limit(values, max(known) if grids else math.nan)


def convergence_index(fine: float, medium: float, coarse: float) -> float:
    """Grid convergence index of the fine mesh; an observed order above that of the elements is luck, and not used."""
    found = grid_convergence.grid_convergence((fine, medium, coarse), (2.0, 2.0))
    if found.behaviour != "converging" or found.order <= MAX_ORDER:
        return found.gci_fine
    return grid_convergence.SAFETY_FACTOR * abs((fine - medium) / fine) / (2.0**MAX_ORDER - 1.0)
