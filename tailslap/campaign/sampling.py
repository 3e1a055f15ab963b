"""Inputs that vary over ranges: which and how far, the combinations that are drawn, where a spread comes from.

Default ranges: MASH 2016 for speed and angle of any test and the inertial mass of its two light vehicles, as printed
beside the measured values of crash tests 612541-01-1 to -4 in National Academies (2024), doi 10.17226/27896, chapters
12, 13, 18 and 19. The tolerances of its trucks' masses were not found published. Friction, restitution and the duration
of the strike: assumed, wide enough for the values of the paper's tables.

Sobol indices: the part of the variance that comes from each input, alone and with its interactions. Totals by Jansen
(1999, Comput. Phys. Commun. 117, 35); first-order indices by Saltelli et al. (2010, Comput. Phys. Commun. 181, 259,
Table 2 b), with the covariance of both tables, which is zero but for chance, as control variate. The variance is at
most the sum of the totals' numerators (Efron and Stein 1981, Ann. Stat. 9, 586).

Points: few rows of a Sobol sequence have columns that coincide. Rows are therefore a Latin hypercube until each group
of a scrambled sequence has enough of them. Intervals: jackknife of the groups.
"""

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.units import MPH, POUND, measure
from tailslap.case.case import Case
from tailslap.errors import InputError, Verbatim
from tailslap.scene import schema, write
from tailslap.scene.read import unit_remarks
from tailslap.scene.vary import Source, parse_value, vary

Array = NDArray[np.float64]
# The ends of a range [SI], and where it comes from.
Limits = tuple[float, float, str]

# Of every random number: the same call gives the same numbers.
SEED = 307

# Fewest rows of a table; groups of rows; rows of a group, for each column, from which on a Sobol sequence serves it.
LEAST_ROWS, GROUPS, ROWS_PER_COLUMN = 32, 16, 8

# Two-sided, of intervals stated as 95 %: skewed outputs and few rows take the rest. One-sided, of a refusal.
CONFIDENCE, CONTRADICTION = 0.98, 0.9999

TOO_FEW = "Sobol indices are not determined: too few samples differ for an error. Increase --samples."

# Changed outputs below which the upper limits are those of a binomial fraction.
FEW = 10

PERCENTILES = (5, 50, 95)
# Rows below which there are no indices.
MIN_ROWS = 16

ASSUMED, FROM_USER = "assumed", "--range"

# MASH's name: inertial mass and its tolerance [lb].
LIGHT_VEHICLES = {"1100C": (2420.0, 55.0), "2270P": (5000.0, 110.0)}


def default_limits(scene: schema.Scene) -> dict[str, Limits]:
    """The range of each key that varies by default, where the scene has the key."""
    limits: dict[str, Limits] = {"strike.duration": (0.08, 0.18, ASSUMED)}
    for name, (pounds, tolerance) in LIGHT_VEHICLES.items():
        if abs(scene.vehicle.mass - pounds * POUND) <= tolerance * POUND:
            origin = f"± {tolerance:g} lb, MASH {name}"
            limits["vehicle.mass"] = about(scene.vehicle.mass, tolerance * POUND, origin)
    if scene.impact:
        limits |= {
            "impact.friction": (0.3, 0.6, ASSUMED),
            "impact.restitution": (0.0, 0.4, ASSUMED),
            "impact.speed": about(scene.impact.speed, 2.5 * MPH, "± 2.5 mph, MASH"),
            "impact.angle": about(scene.impact.angle, math.radians(1.5), "± 1.5 deg, MASH"),
        }
    return limits


def about(value: float, tolerance: float, origin: str) -> Limits:
    """The range of so much below and above a value."""
    return value - tolerance, value + tolerance, origin


@dataclass(frozen=True)
class Range:
    """An input that varies evenly between two values [unit]; given: the scene's own value, where it has one."""

    key: str
    lower: float
    upper: float
    unit: str
    given: float | None
    origin: str

    def in_words(self) -> tuple[str, str]:
        """The range and the scene's own value, angles in degrees."""
        lower, upper, own = (
            None if value is None else measure(value, self.unit, ".5g", named=bool(self.unit) and last)
            for value, last in ((self.lower, False), (self.upper, True), (self.given, True))
        )
        return f"{lower} to {upper}", own or "–"


def ranges_of(
    case: Case,
    used: tuple[str, ...],
    limits: Mapping[str, Limits],
    ranges: tuple[str, ...],
    fixed: tuple[str, ...],
) -> tuple[Range, ...]:
    """The ranges for a case, in the order of the keys that may vary. Raises InputError.

    Parameters
    ----------
    case : Case
        Whose scene and source say what a key means and what its own value is.
    used : tuple of str
        The keys that may vary.
    limits : dict
        The ranges of those that vary by default.
    ranges, fixed : tuple of str
        What the user says: KEY=LOWER:UPPER, and keys that do not vary.
    """
    ends: dict[str, tuple[Any, Any, str]] = {key: its for key, its in limits.items() if key in used}
    for text in ranges:
        key, lower, upper = _split(text, used)
        if key in ends and ends[key][2] == FROM_USER:
            raise InputError("--range", text, "this key has two ranges")
        ends[key] = (lower, upper, FROM_USER)
    for key in fixed:
        if key in ends and ends[key][2] == FROM_USER:
            raise InputError("--fix", key, "--range and --fix exclude each other; remove one of the two")
        if ends.pop(key, None) is None:
            raise InputError("--fix", key, f"this key does not vary; allowed are {', '.join(ends) or 'none'}")
    if not ends:
        raise InputError("--fix", ", ".join(fixed), "at least one key must vary")
    return tuple(_range(case, key, *ends[key]) for key in used if key in ends)


def _split(text: str, used: tuple[str, ...]) -> tuple[str, str, str]:
    """Key and ends of KEY=LOWER:UPPER."""
    key, equals, values = (part.strip() for part in text.partition("="))
    lower, colon, upper = (part.strip() for part in values.partition(":"))
    if not all((key, equals, lower, colon, upper)):
        raise InputError("--range", text, "allowed is KEY=LOWER:UPPER, e.g. impact.friction=0.2:0.5")
    if key not in used:
        why = f"the peak force of this scene is independent of this key; allowed are {', '.join(used)}"
        raise InputError(key, values, why)
    return key, lower, upper


def _range(case: Case, key: str, lower: Any, upper: Any, origin: str) -> Range:
    """The range, its ends read as the scene would read them, with its units and bounds."""
    typed = origin == FROM_USER
    try:
        given = ({key: parse_value(end) if typed else end} for end in (lower, upper))
        found = [vary(case.source, changes) for changes in given]
    except InputError as error:
        if typed:
            raise
        where = Verbatim(f"{lower} to {upper} by default ({origin})")
        raise InputError(key, where, f"{error.allowed}; --range changes the range") from None
    ends = [_row(*varied, key) for varied in found]
    remarks = (unit_remarks(source).get(key) for _, source in found if typed)
    if remark := next(filter(None, remarks), None):
        warnings.warn(remark, stacklevel=2)
    low, high = (float(row.value or 0.0) if row else math.nan for row in ends)
    if not high > low:
        text = f"{lower}:{upper}" if typed else f"{lower!r}:{upper!r}"
        raise InputError(key, text, "the upper limit must exceed the lower limit")
    own = _row(case.scene, case.source, key)
    unit = ends[0].unit if ends[0] else ""
    return Range(key, low, high, unit, None if own is None else float(own.value or 0.0), origin)


def _row(scene: schema.Scene, source: Source, key: str) -> write.SceneInput | None:
    """The key as a row of the scene's table of inputs."""
    return next((row for row in write.scene_inputs(scene, source) if row.key == key), None)


def sobol_points(ranges: tuple[Range, ...], rows: int) -> tuple[Array, Array]:
    """Two tables of inputs, each of shape (inputs, rows): halves of one set of points in twice the dimensions."""
    from scipy.stats import qmc

    random, columns = np.random.default_rng(SEED), 2 * len(ranges)
    if not _are_nets(len(ranges), rows):
        drawn = qmc.LatinHypercube(columns, seed=random).random(rows).T
    else:
        drawn = qmc.Sobol(columns, scramble=True, bits=64, seed=random).random(rows).T
    lower, upper = (np.array([[getattr(item, end)] for item in ranges]) for end in ("lower", "upper"))
    a, b = (lower + (upper - lower) * half for half in np.split(drawn, 2))
    return a, b


def _are_nets(inputs: int, rows: int) -> bool:
    """Return whether the groups of a Sobol sequence have columns that do not coincide."""
    return rows >= GROUPS * ROWS_PER_COLUMN * 2 * inputs


def points_in_words(inputs: int, rows: int) -> str:
    """Return the kind of set that the rows are points of."""
    return "a scrambled Sobol sequence" if _are_nets(inputs, rows) else "a Latin hypercube"


def sampled(
    ranges: tuple[Range, ...], at_least: int, solve: Callable[[dict[str, Array]], Mapping[str, Array]]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Combinations of inputs and what is computed of them, at least so many, a power of two of rows (Saltelli 2010).

    Parameters
    ----------
    ranges : tuple of Range
        Of the inputs, each even over its range, independent of the others.
    at_least : int
        Combinations in all.
    solve : callable
        Takes inputs by key, shape (n,) [SI], and returns columns by name, shape (n,); NaN: refused.

    Returns
    -------
    inputs : dict of ndarray, shape ((inputs + 2) rows,)
        By key: two tables that share no row, and for each input the first table with that input from the second.
    tables : dict of ndarray, shape (inputs + 2, rows)
        By name, in the same order.
    """
    rows = 1 << math.ceil(math.log2(max(LEAST_ROWS, at_least / (len(ranges) + 2))))
    a, b = sobol_points(ranges, rows)
    mixed = [np.where(np.arange(len(a))[:, None] == i, b, a) for i in range(len(a))]
    inputs = dict(zip((item.key for item in ranges), np.hstack([a, b, *mixed]), strict=True))
    return inputs, {name: column.reshape(-1, rows) for name, column in solve(inputs).items()}


@dataclass(frozen=True)
class Band:
    """Spread of a quantity [SI]: percentiles are those of PERCENTILES; values: all known ones."""

    percentiles: tuple[float, ...]
    mean: float
    standard_deviation: float
    values: Array

    def fraction_below(self, value: float) -> float:
        """Fraction of the combinations that stay below a value."""
        return float(np.mean(self.values < value))

    def numbers(self) -> dict[str, float]:
        """Numbers of a summary."""
        ends = zip(PERCENTILES, self.percentiles, strict=True)
        moments = {"mean": self.mean, "standard_deviation": self.standard_deviation}
        return {**{f"percentile_{p}": x for p, x in ends}, **moments}


def band_of(values: Array) -> Band:
    """Band of a sample without what is NaN; of the first two rows of a table."""
    values = values[:2].ravel() if values.ndim == 2 else values
    known = values[np.isfinite(values)]
    ends = tuple(np.percentile(known, PERCENTILES).tolist())
    return Band(ends, float(known.mean()), float(known.std(ddof=1)), known)


class Indices(NamedTuple):
    """An index for each input, shape (inputs,), and the ends of its 95 % interval, shape (2, inputs).

    refusal: why they are not to be shown, or "".
    """

    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    refusal: str


def sobol_indices(table: Array) -> Indices:
    """Return first-order and total indices with their intervals.

    table: as of `sampled`; rows with NaN are left out. Each group of rows in turn is left out: the jackknife, with
    Student's t. Groups are of one sequence or Latin hypercube, whose means scatter less than those of independent
    groups: the intervals are wider than necessary.
    """
    known, inputs = np.isfinite(table).all(axis=0), len(table) - 2
    group = (np.arange(known.size) * GROUPS // known.size)[known]
    table = table[:, known] - np.mean(table[:2, known])
    sums = np.array([np.bincount(group, row, GROUPS) for row in _terms(table)])
    count = np.bincount(group, minlength=GROUPS)
    sums, count = sums[:, count > 0], count[count > 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        found = _ratios(sums.sum(axis=1) / group.size)
        without = _ratios((sums.sum(axis=1, keepdims=True) - sums) / (group.size - count))
        error = np.sqrt((count.size - 1) * np.var(without, axis=1))
    low, high = found[:-1] + np.outer((-1.0, 1.0), _quantile(0.5 + 0.5 * CONFIDENCE, count.size) * error[:-1])
    few, bound = _bounds(table, found[inputs:-1])
    low, high = np.where(few, 0.0, low), np.where(few, np.maximum(bound, high), high)
    first, total, *ends = (
        part for row in (found[:-1], low, high) for part in np.split(np.clip(row, 0.0, 1.0), 2)
    )
    refusal = _refusal(found, error, _quantile(CONTRADICTION, count.size))
    return Indices(first, total, np.array(ends[::2]), np.array(ends[1::2]), refusal)


def _terms(table: Array) -> Array:
    """Return the products whose means give the indices, shape (2 inputs + 3, rows)."""
    a, b, *_ = table
    mixed = table[2:]
    return np.vstack([b * mixed, 0.5 * (a - mixed) ** 2, a * b, 0.5 * (a * a + b * b), 0.5 * (a + b)])


def _ratios(means: Array) -> Array:
    """Return first-order and total indices, and the sum of these by the variance of the samples.

    means: of `_terms`, along the first axis.
    """
    inputs = (len(means) - 3) // 2
    mixed, changes, (both, square, mean) = means[:inputs], means[inputs:-3], means[-3:]
    variance, chance = square - mean**2, both - mean**2
    first = mixed - mean**2 - (1.0 - changes / variance) * chance
    in_all = changes.sum(axis=0, keepdims=True)
    bounded = np.minimum(variance, in_all)
    return np.concatenate([first / bounded, changes / bounded, in_all / variance])


def _bounds(table: Array, total: Array) -> tuple[Array, Array]:
    """Return which indices rest on few changed outputs, and their upper limits.

    These are the limit of the fraction that changes (Clopper-Pearson) times the larger mean change: that of the input,
    or that of all inputs at once.
    """
    from scipy.stats import beta

    rows, changed = table.shape[1], np.count_nonzero(table[0] != table[2:], axis=1)
    fraction = beta.ppf(0.5 + 0.5 * CONFIDENCE, changed + 1.0, np.maximum(rows - changed, 0.5))
    of_all = rows / max(1, np.count_nonzero(table[0] != table[1]))
    bound = fraction * np.maximum(of_all, total * rows / np.maximum(changed, 1))
    return np.tile(changed < FEW, 2), np.tile(bound, 2)


def _quantile(probability: float, groups: int) -> float:
    """Return the quantile of Student's t of so many groups."""
    from scipy.stats import t

    return float(t.ppf(probability, groups - 1))


def _refusal(found: Array, error: Array, quantile: float) -> str:
    """Return why indices are refused, or "".

    The sum of the totals is below 1 beyond its error, or the error is unknown.
    """
    highest = found[-1] + quantile * error[-1]
    if highest < 1.0:
        return (
            f"Sobol indices are not determined: the sum of the total indices is {found[-1]:.2f}, with its error "
            f"at most {highest:.2f}; for independent inputs it is at least 1. Increase --samples."
        )
    return "" if np.isfinite([*found, *error]).all() else TOO_FEW


def index_rows(ranges: tuple[Range, ...], table: Array) -> tuple[list[dict[str, Any]], str]:
    """A row an input, with its range, its Sobol indices and their intervals; or none, and why they are refused."""
    if np.count_nonzero(np.isfinite(table).all(axis=0)) < MIN_ROWS:
        return [], TOO_FEW
    found = sobol_indices(table)
    if found.refusal:
        return [], found.refusal
    first, total = (found.first_interval.T.tolist(), found.total_interval.T.tolist())
    rows = [
        {
            **{name: getattr(item, name) for name in ("key", "lower", "upper", "unit", "origin")},
            "of_the_scene": item.given,
            "first_order": float(found.first[i]),
            "first_order_interval": first[i],
            "total": float(found.total[i]),
            "total_interval": total[i],
        }
        for i, item in enumerate(ranges)
    ]
    return rows, ""
