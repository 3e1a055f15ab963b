"""Discretisation error from three refined meshes or steps.

Observed order, extrapolated value and grid convergence index after Roache, P. J. (1994), J. Fluids Eng. 116, 405, and
ASME V&V 20-2009, section 2-4. With values f_1 on the finest grid, f_2, f_3, and refinement ratios r_21, r_32, the
order p solves (f_3 - f_2)/(f_2 - f_1) = (r_32^p - 1) r_21^p / (r_21^p - 1) (for one ratio r it is log of that over
log r), the extrapolated value is f_1 + (f_1 - f_2)/(r_21^p - 1), and the grid convergence index is F_s |f_1 - f_2| /
(|f_1| (r_21^p - 1)), with F_s = 1.25 for three grids.
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

    values: fine, medium, coarse; ratios: r_21, r_32; behaviour: of their sequence; order: the observed one, NaN
    without any; extrapolated: to grid size zero; gci_fine, gci_coarse: relative, of the fine and the medium grid;
    asymptotic: gci_coarse / (r_21^p gci_fine), 1 in the asymptotic range.
    """

    values: tuple[float, float, float]
    ratios: tuple[float, float]
    behaviour: str
    order: float
    extrapolated: float
    gci_fine: float
    gci_coarse: float
    asymptotic: float


def grid_convergence(values: tuple[float, float, float], ratios: tuple[float, float]) -> GridConvergence:
    """Estimate discretisation errors from values on three grids.

    values: fine, medium, coarse; ratios: r_21 = h_2/h_1 and r_32 = h_3/h_2, above 1, otherwise ValueError. Values
    that oscillate, diverge or hardly converge are not extrapolated; their indices are the relative changes times the
    cautious factor.
    """
    if not (ratios[0] > 1.0 and ratios[1] > 1.0):
        raise ValueError(f"refinement ratios must be above 1, not {ratios}")
    fine, medium, coarse = values
    behaviour, order = _behaviour(medium - fine, coarse - medium, abs(fine), ratios)
    if behaviour == "settled":
        return GridConvergence(values, ratios, behaviour, math.nan, fine, 0.0, 0.0, 1.0)
    if behaviour != "converging":
        fine_change, coarse_change = abs((fine - medium) / fine), abs((medium - coarse) / medium)
        cautious = (CAUTIOUS_FACTOR * fine_change, CAUTIOUS_FACTOR * coarse_change)
        return GridConvergence(values, ratios, behaviour, order, fine, *cautious, math.nan)
    growth, growth_coarse = ratios[0] ** order - 1.0, ratios[1] ** order - 1.0
    extrapolated = fine + (fine - medium) / growth
    gci_fine = SAFETY_FACTOR * abs((fine - medium) / fine) / growth
    gci_coarse = SAFETY_FACTOR * abs((medium - coarse) / medium) / growth_coarse
    asymptotic = gci_coarse / (ratios[0] ** order * gci_fine)
    return GridConvergence(values, ratios, behaviour, order, extrapolated, gci_fine, gci_coarse, asymptotic)


def _behaviour(first: float, second: float, size: float, ratios: tuple[float, float]) -> tuple[str, float]:
    """Return the behaviour in one word, and the observed order."""
    if abs(first) <= ROUNDING * size:
        return "settled", math.nan
    if first * second <= 0.0:
        return "oscillating", math.nan
    order = observed_order(second / first, ratios)
    if not order >= MIN_ORDER:
        return ("slow" if order > 0.0 else "diverging"), order
    return "converging", order


def observed_order(quotient: float, ratios: tuple[float, float]) -> float:
    """Return the order p from (f_3 - f_2)/(f_2 - f_1) > 0.

    By the fixed point of V&V 20; -inf without a solution.
    """
    r_21, r_32 = ratios
    if r_21 == r_32:
        return math.log(quotient) / math.log(r_21)
    from scipy.optimize import brentq

    def excess(p: float) -> float:
        return float((r_32**p - 1.0) / (r_21**p - 1.0) * r_21**p - quotient)

    low, high = 1e-6, 40.0
    return float(brentq(excess, low, high)) if excess(low) < 0.0 < excess(high) else -math.inf


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
    return {name: grid_convergence(values, (2.0, 2.0)) for name, values in by_name.items()}


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
