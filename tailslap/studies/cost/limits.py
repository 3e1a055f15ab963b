"""What the soft plate's errors are measured from: limits of refined meshes and of refined time steps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from postprocess.comparison.comparison import KEYS, largest, relative_difference
from postprocess.comparison.grid_convergence import CAUTIOUS_FACTOR, SAFETY_FACTOR, grid_convergence

MAX_ORDER = 2.0
"""Order of linear elements, of loads that jump and of central differences; a higher observed order is luck."""

MIN_KNOWN = 1e-12
"""Relative rounding of a run: no limit is known better."""


@dataclass(frozen=True)
class Limit:
    """The quantities in a limit, and how well they are known: the largest grid convergence index."""

    values: dict[str, float]
    known: float

    def error_of(self, values: Mapping[str, float]) -> float:
        """Largest relative distance from the limit, no less than that is known to; NaN where one value is none."""
        error = largest(relative_difference(values, self.values, tuple(self.values)))
        return max(error, self.known) if math.isfinite(error) else math.nan


def limit_of(records: Sequence[Mapping[str, Any]], names: Sequence[str] = KEYS) -> Limit:
    """The limit of the last three records, each twice as fine as the one before; NaN where there are none."""
    good = [r["values"] for r in records if "values" in r and all(map(math.isfinite, r["values"].values()))]
    if len(good) < 3:
        return Limit(dict.fromkeys(names, math.nan), math.nan)
    coarse, medium, fine = good[-3:]
    found = {name: extrapolated(fine[name], medium[name], coarse[name]) for name in names}
    known = max(MIN_KNOWN, *(error for _, error in found.values()))
    return Limit({name: value for name, (value, _) in found.items()}, known)


def extrapolated(fine: float, medium: float, coarse: float) -> tuple[float, float]:
    """Richardson's value and its relative uncertainty; the fine value and three times the change without an order."""
    found = grid_convergence((fine, medium, coarse), (2.0, 2.0))
    if found.behaviour != "converging":
        return fine, CAUTIOUS_FACTOR * abs((fine - medium) / fine)
    step = (fine - medium) / (2.0 ** min(found.order, MAX_ORDER) - 1.0)
    return fine + step, SAFETY_FACTOR * abs(step / fine)


def observed_order(refinements: list[float], errors: list[float], known: float) -> float:
    """Exponent of the errors in the refinement, from those well above what the limit is known to; NaN for fewer
    than two."""
    pairs = [
        (math.log(r), math.log(e))
        for r, e in zip(refinements, errors, strict=True)
        if e > 3.0 * known and r > 0.0
    ]
    if len(pairs) < 2:
        return math.nan
    x, y = np.transpose(pairs)
    return -float(np.polyfit(x, y, 1)[0]) if np.ptp(x) else math.nan
