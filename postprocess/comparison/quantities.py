"""FE against the exact rigid-body solution at the tail-slap, next to the paper's published values.

Quantities: t [s], v_gx [m/s], v_gy [m/s], omega [rad/s], slide [m]; v_gy is negative, towards the wall.

Metrics of two histories (Sprague and Geers), and grid convergence of values on three meshes.

Histories are compared by Sprague and Geers' metrics, and the residuals of an analysis of variance.

Inner products are taken over time by the trapezoidal rule, (f, g) = integral of f g dt, of a history f and its
reference g at common instants:

    magnitude      M = sqrt((f, f) / (g, g)) - 1, blind to phase
    phase          P = arccos((f, g) / sqrt((f, f) (g, g))) / pi, blind to magnitude
    combined       C = sqrt(M^2 + P^2)
    residuals      r = (f - g) / max |g|; their mean over time, and their standard deviation about it

Sources: Sprague and Geers, A spectral-element method for modelling cavitation in transient fluid-structure
interaction, Int. J. Numer. Meth. Engng 60 (2004); the integrals also in Schwer, Validation metrics for response
histories, Engineering with Computers 23 (2007). Residuals: Ray, Repeatability of full-scale crash tests and criteria
for validating simulation results, Transportation Research Record 1528 (1996), as the program RSVVP of NCHRP Web-Only
Document 179 has them. Limits: Ray, Mongiardini, Plaxico and Anghileri, NCHRP Web-Only Document 179 (2010): 40 % for
Sprague and Geers' metrics, 5 % and 35 % for the mean and the standard deviation of the residuals over the reference's
peak.

Discretisation error is that of three systematically refined meshes or steps: observed order, extrapolation, GCI.

Roache, P. J. (1994), J. Fluids Eng. 116, 405, and ASME V&V 20-2009, section 2-4: with values f_1 on the finest grid,
f_2, f_3, and refinement ratios r_21, r_32, the order p solves (f_3 - f_2)/(f_2 - f_1) = (r_32^p - 1) r_21^p /
(r_21^p - 1) (for one ratio r it is log of that over log r), the extrapolated value is f_1 + (f_1 - f_2)/(r_21^p - 1),
and the grid convergence index is F_s |f_1 - f_2| / (|f_1| (r_21^p - 1)), with F_s = 1.25 for three grids.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ComparedQuantity:
    """Names of a compared quantity: mapping key, words, symbol and SI unit."""

    key: str
    title: str
    symbol: str
    unit: str

    @property
    def label(self) -> str:
        """Symbol with unit."""
        return f"{self.symbol} [{self.unit}]"


@dataclass(frozen=True)
class ComparisonRow:
    """A line of the comparison: quantity, both solutions, fe/rigid - 1, and the paper's two values (SI)."""

    quantity: ComparedQuantity
    fe: float
    rigid: float
    difference: float
    paper_analytical: float | None = None
    paper_abaqus: float | None = None


def _by_key(*quantities: ComparedQuantity) -> dict[str, ComparedQuantity]:
    return {quantity.key: quantity for quantity in quantities}


QUANTITIES = _by_key(
    ComparedQuantity("t", "Time to the tail-slap", "t", "s"),
    ComparedQuantity("v_gx", "Velocity of G along the wall", "v_GX", "m/s"),
    ComparedQuantity("v_gy", "Velocity of G across the wall", "v_GY", "m/s"),
    ComparedQuantity("omega", "Angular velocity", "ω", "rad/s"),
    ComparedQuantity("slide", "Slide of the corner along the wall", "s", "m"),
)
KEYS = tuple(QUANTITIES)


@dataclass(frozen=True)
class Compared:
    """Comparison of FE and rigid vehicle: quantities by key, the one that a map shows, the instant of both."""

    quantities: Mapping[str, ComparedQuantity]
    mapped: str
    where: str


FORCE = _by_key(ComparedQuantity("peak_force", "Peak lateral force", "F", "N"))
TAIL_SLAP = Compared(FORCE | QUANTITIES, "peak_force", "at the tail-slap")
"""Quantities of the constrained corner: the force of Stage 3, and the five that it follows from."""

OF_STRIKES = _by_key(
    ComparedQuantity("strike_1.mean_50ms", "First strike's peak, 50 ms mean", "F₁, 50 ms", "N"),
    ComparedQuantity("strike_1.impulse", "First strike's impulse", "J₁", "N s"),
    ComparedQuantity("strike_2.mean_50ms", "Second strike's peak, 50 ms mean", "F₂, 50 ms", "N"),
    ComparedQuantity("strike_2.impulse", "Second strike's impulse", "J₂", "N s"),
    ComparedQuantity("strike_2.duration", "Second strike's duration", "Δt₂", "s"),
)
STRIKES = Compared(OF_STRIKES, "strike_2.mean_50ms", "of both strikes")
"""Quantities of a whole impact."""

PAPER_SOURCE = "B. Chuong and R. B. Malla, Infrastructures 2025, 10(11), 307, Table 3"

# The paper prints the magnitude of v_GY; here it carries this program's sign, negative towards the wall.
PAPER_TABLE_3: Mapping[str, Mapping[str, float]] = {
    "analytical": {"t": 0.383, "v_gx": 23.270, "v_gy": -3.274, "omega": 0.65, "slide": 9.420},
    "abaqus": {"t": 0.37, "v_gx": 23.305, "v_gy": -3.289, "omega": 0.66, "slide": 8.915},
}


def relative_difference(
    fe: Mapping[str, float], rigid: Mapping[str, float], keys: Sequence[str] = KEYS
) -> dict[str, float]:
    """fe/rigid - 1 for each key, dimensionless.

    Where the rigid value is zero the difference is 0 if the FE value is zero as well, and infinite if not:
    infinity fails every limit, so nothing that deviates from zero can pass as equal.
    """
    return {key: _relative(float(fe[key]), float(rigid[key])) for key in keys}


def largest(differences: Mapping[str, float]) -> float:
    """Size of the largest difference; NaN where there is none, or one is not a finite number."""
    sizes = [abs(value) for value in differences.values()]
    return max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan


def largest_relative(values: Mapping[str, float], others: Mapping[str, float]) -> float:
    """Size of the largest relative difference of the five quantities; NaN where there is no result, or no number."""
    return largest(relative_difference(values, others)) if values and others else math.nan


def comparison_rows(
    fe: Mapping[str, float],
    rigid: Mapping[str, float],
    paper: Mapping[str, Mapping[str, float]] | None = PAPER_TABLE_3,
) -> tuple[ComparisonRow, ...]:
    """The rows of the comparison table; `paper=None` where the scene is not the paper's."""
    columns = {} if paper is None else paper
    analytical, abaqus = columns.get("analytical", {}), columns.get("abaqus", {})
    difference = relative_difference(fe, rigid)
    return tuple(
        ComparisonRow(
            quantity, float(fe[key]), float(rigid[key]), difference[key], analytical.get(key), abaqus.get(key)
        )
        for key, quantity in QUANTITIES.items()
    )


def _relative(fe: float, rigid: float) -> float:
    if rigid != 0.0:
        return fe / rigid - 1.0
    return 0.0 if fe == 0.0 else math.copysign(math.inf, fe)


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Metrics:
    """Distances of a history to its reference, dimensionless; 0 where the two are equal."""

    magnitude: float
    phase: float
    combined: float
    mean_residual: float
    deviation: float

    @property
    def within(self) -> bool:
        """True if all are within their customary limits."""
        limits = asdict(LIMITS)
        return all(abs(value) <= limits[name] for name, value in asdict(self).items())


def compare_histories(
    instants: Floats, history: Floats, reference: Floats, is_known: NDArray[np.bool_] | bool = True
) -> Metrics:
    """Metrics of `history` against `reference`, both of shape (instants,), in any one unit.

    Instants [s] rise, and need not be evenly spaced; is_known, shape (instants - 1,): time between two that counts.
    Numbers that are not finite, less than two instants, and a reference that is zero throughout give NaN.
    """
    if instants.size < 2:
        return Metrics(*(5 * (math.nan,)))
    steps = np.diff(instants) * is_known
    weights = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))  # [s], of the trapezoidal rule
    with np.errstate(all="ignore"):
        size, its = _norm(weights, history), _norm(weights, reference)
        magnitude = float(size / its - 1.0)
        phase = _angle(weights, history / size, reference / its) / math.pi
        residual = (history - reference) / np.abs(reference).max(initial=0.0)
        mean = np.sum(weights * residual) / weights.sum()
        deviation = np.sqrt(np.sum(weights * (residual - mean) ** 2) / weights.sum())
    found = (magnitude, phase, math.hypot(magnitude, phase), float(mean), float(deviation))
    return Metrics(*(value if math.isfinite(value) else math.nan for value in found))


def weighted_metrics(channels: Sequence[Metrics], momenta: Sequence[float]) -> Metrics:
    """Mean of the sizes of the metrics of several channels, weighted by the momentum of each, as W179 has it.

    Parameters
    ----------
    channels : sequence of Metrics
        Of each channel.
    momenta : sequence of float
        Of each channel, in one unit; weights are their fractions of the sum.

    Returns
    -------
    Metrics
        No sign: channels that differ in opposite directions do not cancel each other.
    """
    sizes = np.abs([list(asdict(metrics).values()) for metrics in channels])
    return Metrics(*(float(each) for each in np.asarray(momenta) @ sizes / np.sum(momenta)))


def _norm(weights: Floats, values: Floats) -> np.float64:
    return np.sqrt(np.sum(weights * values**2))


def _angle(weights: Floats, unit: Floats, other: Floats) -> float:
    """Angle [rad] between two functions of norm 1; unlike the arccosine it keeps its digits where it is small."""
    return 2.0 * math.atan2(_norm(weights, unit - other), _norm(weights, unit + other))


LIMITS = Metrics(0.40, 0.40, 0.40, 0.05, 0.35)
"""Customary limits of the sizes of the metrics."""


GAP, LEAST_GAP = 5.0, 0.05
"""Time between two values that is not interpolated: over the median of such times, and over all time of the values."""

COVERED = 0.5
"""Least part of the reference's time that has to be compared."""


@dataclass(frozen=True)
class Beside:
    """A column beside the reference's, while both are known.

    Attributes
    ----------
    name : str
        Of the column.
    t, value, reference : ndarray, shape (instants,)
        Instants of both [s], and both histories there.
    metrics : Metrics
        Of the one against the other.
    covered : float
        Time compared over that of the reference [-].
    gaps : tuple of pairs
        Ends [s] of the times between that are not compared.
    """

    name: str
    t: Floats
    value: Floats
    reference: Floats
    metrics: Metrics
    covered: float = 1.0
    gaps: tuple[tuple[float, float], ...] = ()

    @property
    def difference(self) -> Floats:
        """Value less reference."""
        return self.value - self.reference

    @property
    def largest(self) -> tuple[float, float]:
        """The largest difference over the reference's peak, and when it is [s]."""
        k = int(np.argmax(np.abs(self.difference)))
        peak = float(np.abs(self.reference).max())
        return (float(self.difference[k]) / peak if peak else float("nan")), float(self.t[k])

    @property
    def at_end(self) -> float:
        """Value over reference - 1 at the last common instant."""
        last = float(self.reference[-1])
        return float(self.value[-1]) / last - 1.0 if last else float("nan")

    @property
    def within(self) -> bool:
        """True if all metrics are within their customary limits, over enough of the reference's time."""
        return self.metrics.within and self.covered >= COVERED


def beside(name: str, history: Mapping[str, Floats], reference: Mapping[str, Floats]) -> Beside | None:
    """The column of this name at the instants of both, interpolated; None where they have less than two in common.

    Columns "t" [s] rise. Values that are not finite are left out, and so are gaps, where either has no values for long.
    """
    records = [_finite(columns["t"], columns[name]) for columns in (history, reference)]
    if min(t.size for t, _ in records) < 2:
        return None
    first, last = max(t[0] for t, _ in records), min(t[-1] for t, _ in records)
    within = [t[(t >= first) & (t <= last)] for t, _ in records]
    if min(t.size for t in within) < 2:
        return None
    gaps = [gap for t, _ in records for gap in _gaps(t) if gap[0] < last and gap[1] > first]
    t = np.union1d(*within)
    t = t[~_inside(t, gaps)]
    is_known = ~_inside(0.5 * (t[1:] + t[:-1]), gaps)
    compared = float(np.sum(np.diff(t)[is_known]))
    if not compared:
        return None
    value, expected = (np.interp(t, *record) for record in records)
    metrics = compare_histories(t, value, expected, is_known)
    covered = min(1.0, compared / float(reference["t"][-1] - reference["t"][0]))
    ends = tuple(sorted((max(begin, first), min(end, last)) for begin, end in gaps))
    return Beside(name, t, value, expected, metrics, covered, ends)


def _finite(t: Floats, values: Floats) -> tuple[Floats, Floats]:
    known = np.isfinite(t) & np.isfinite(values)
    return t[known], values[known]


def _gaps(t: Floats) -> list[tuple[float, float]]:
    """Ends of the times between two instants that are not interpolated."""
    steps = np.diff(t)
    is_gap = (steps > GAP * np.median(steps)) & (steps > LEAST_GAP * (t[-1] - t[0]))
    return [(float(t[k]), float(t[k + 1])) for k in np.flatnonzero(is_gap)]


def _inside(t: Floats, gaps: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """True at instants between the ends of a gap."""
    inside = np.zeros(t.shape, bool)
    for begin, end in gaps:
        inside |= (t > begin) & (t < end)
    return inside


SAFETY_FACTOR = 1.25
"""F_s for three grids and an observed order."""

CAUTIOUS_FACTOR = 3.0
"""F_s for two grids, or for three whose observed order is not to be believed."""

MIN_ORDER = 0.5
"""Observed orders below this say that the values do not converge, or not yet."""

ROUNDING = 1e-14
"""Relative change below which values on two grids are the same."""


@dataclass(frozen=True)
class GridConvergence:
    """Convergence on three grids. values: fine, medium, coarse; ratios: r_21, r_32; behaviour: of their sequence.

    order: the observed one, NaN where there is none; extrapolated: to grid size zero. gci_fine, gci_coarse:
    relative, of the fine and the medium grid; asymptotic: gci_coarse / (r_21^p gci_fine), 1 in the asymptotic range.
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
        """Estimated relative error of the fine grid's value: its distance to the extrapolated one."""
        fine = self.values[0]
        return abs(fine - self.extrapolated) / abs(fine) if fine else math.nan


def grid_convergence(values: tuple[float, float, float], ratios: tuple[float, float]) -> GridConvergence:
    """Judge values on a fine, a medium and a coarse grid; ratios: r_21 = h_2/h_1 and r_32 = h_3/h_2, above 1.

    Where the values oscillate, diverge or hardly converge there is no extrapolated value: it is the fine grid's,
    and the indices are the relative changes times the cautious factor. Raises ValueError for ratios not above 1.
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
    """In a word, and the observed order."""
    if abs(first) <= ROUNDING * size:
        return "settled", math.nan
    if first * second <= 0.0:
        return "oscillating", math.nan
    order = observed_order(second / first, ratios)
    if not order >= MIN_ORDER:
        return ("slow" if order > 0.0 else "diverging"), order
    return "converging", order


def observed_order(quotient: float, ratios: tuple[float, float]) -> float:
    """The order p from (f_3 - f_2)/(f_2 - f_1) > 0, by the fixed point of V&V 20; -inf where there is none."""
    r_21, r_32 = ratios
    if r_21 == r_32:
        return math.log(quotient) / math.log(r_21)
    from scipy.optimize import brentq

    def excess(p: float) -> float:
        return float((r_32**p - 1.0) / (r_21**p - 1.0) * r_21**p - quotient)

    low, high = 1e-6, 40.0
    return float(brentq(excess, low, high)) if excess(low) < 0.0 < excess(high) else -math.inf
