"""Discretisation error from three refined meshes or steps.

Observed order, extrapolated value and grid convergence index after Roache, P. J. (1994), J. Fluids Eng. 116, 405, and
ASME V&V 20-2009, section 2-4. With values f_1 on the finest grid, f_2, f_3, and the refinement ratio r, the order p is
log((f_3 - f_2)/(f_2 - f_1)) / log r, the extrapolated value is f_1 + (f_1 - f_2)/(r^p - 1), and the grid convergence
index is F_s |f_1 - f_2| / (|f_1| (r^p - 1)), with F_s = 1.25 for three grids.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from postprocess.comparison import quantities
from postprocess.comparison.quantities import KEYS

SAFETY_FACTOR = 1.25
"""F_s for three grids and an observed order."""

CAUTIOUS_FACTOR = 3.0
"""F_s for two grids, or for three whose observed order is not credible."""

RATIO = 2.0
"""Refinement ratio of meshes and time steps."""

MIN_ORDER = 0.5
"""Smallest observed order of values that converge."""

ROUNDING = 1e-14
"""Relative change below which values on two grids are equal."""

Record = Mapping[str, Any]
"""Record of a run: its "values" by name, and its number of "steps"."""

MAX_ORDER = 2.0
"""Order of linear elements, of discontinuous loads and of central differences. A higher observed order is accidental.
"""

MIN_KNOWN = 1e-12
"""Relative rounding error of a run, which bounds the uncertainty of every limit from below."""


@dataclass(frozen=True)
class GridConvergence:
    """Convergence of a value on three grids.

    values: fine, medium, coarse; ratios: of their sizes; behaviour: of their sequence; order: the observed one, NaN
    without any; extrapolated: to grid size zero; gci_fine, gci_coarse: relative, of the fine and the medium grid;
    asymptotic: gci_coarse / (r^p gci_fine), 1 in the asymptotic range.
    """

    values: tuple[float, float, float]
    ratios: tuple[float, float]
    behaviour: str
    order: float
    extrapolated: float
    gci_fine: float
    gci_coarse: float
    asymptotic: float


def grid_convergence(fine: float, medium: float, coarse: float) -> GridConvergence:
    """Estimate discretisation errors from values on three grids.

    Values that oscillate, diverge or hardly converge are not extrapolated; their indices are the relative changes times
    the cautious factor.
    """
    inputs = (fine, medium, coarse), (RATIO, RATIO)
    behaviour, order = _behaviour(medium - fine, coarse - medium, abs(fine))
    if behaviour == "settled":
        return GridConvergence(*inputs, behaviour, math.nan, fine, 0.0, 0.0, 1.0)
    fine_change, coarse_change = abs((fine - medium) / fine), abs((medium - coarse) / medium)
    if behaviour != "converging":
        cautious = (CAUTIOUS_FACTOR * fine_change, CAUTIOUS_FACTOR * coarse_change)
        return GridConvergence(*inputs, behaviour, order, fine, *cautious, math.nan)
    growth = RATIO**order - 1.0
    gci_fine, gci_coarse = SAFETY_FACTOR * fine_change / growth, SAFETY_FACTOR * coarse_change / growth
    asymptotic = gci_coarse / (RATIO**order * gci_fine)
    extrapolated = fine + (fine - medium) / growth
    return GridConvergence(*inputs, behaviour, order, extrapolated, gci_fine, gci_coarse, asymptotic)


def _behaviour(first: float, second: float, size: float) -> tuple[str, float]:
    """Return the behaviour in one word, and the observed order."""
    if abs(first) <= ROUNDING * size:
        return "settled", math.nan
    if first * second <= 0.0:
        return "oscillating", math.nan
    order = math.log(second / first) / math.log(RATIO)
    if not order >= MIN_ORDER:
        return ("slow" if order > 0.0 else "diverging"), order
    return "converging", order


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
    by_name = {name: (fine[name], medium[name], coarse[name]) for name in names}
    return {name: grid_convergence(*values) for name, values in by_name.items()}


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
            change, safety = change / (RATIO ** min(grid.order, MAX_ORDER) - 1.0), SAFETY_FACTOR
            values[name] = fine + change
        uncertainties.append(safety * abs(change / fine))
    return Limit(values, max(uncertainties) if grids else math.nan)


def convergence_index(fine: float, medium: float, coarse: float) -> float:
    """Return the grid convergence index of the fine mesh.

    An observed order above that of the elements is accidental and is replaced by theirs.
    """
    grid = grid_convergence(fine, medium, coarse)
    if grid.behaviour != "converging" or grid.order <= MAX_ORDER:
        return grid.gci_fine
    return SAFETY_FACTOR * abs((fine - medium) / fine) / (RATIO**MAX_ORDER - 1.0)
