"""Discretisation error from three refined meshes or steps.

Observed order, extrapolated value and grid convergence index after Roache, P. J. (1994), J. Fluids Eng. 116, 405, and
ASME V&V 20-2009, section 2-4. With values f_1 on the finest grid, f_2, f_3, and refinement ratios r_21, r_32, the
order p solves (f_3 - f_2)/(f_2 - f_1) = (r_32^p - 1) r_21^p / (r_21^p - 1) (for one ratio r it is log of that over
log r), the extrapolated value is f_1 + (f_1 - f_2)/(r_21^p - 1), and the grid convergence index is F_s |f_1 - f_2| /
(|f_1| (r_21^p - 1)), with F_s = 1.25 for three grids.
"""

import math
from dataclasses import dataclass

SAFETY_FACTOR = 1.25
"""F_s for three grids and an observed order."""

CAUTIOUS_FACTOR = 3.0
"""F_s for two grids, or for three whose observed order is not credible."""

MIN_ORDER = 0.5
"""Smallest observed order of values that converge."""

ROUNDING = 1e-14
"""Relative change below which values on two grids are equal."""


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

    @property
    def error(self) -> float:
        """Estimated relative error of the value on the fine grid."""
        fine = self.values[0]
        return abs(fine - self.extrapolated) / abs(fine) if fine else math.nan


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
