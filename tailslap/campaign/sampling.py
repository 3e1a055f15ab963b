"""Samples of varied inputs, their distributions and Sobol indices.

Sobol indices are the fractions of the variance due to each input, alone and with its interactions. Total indices follow
Jansen (1999, Comput. Phys. Commun. 117, 35), first-order indices Saltelli et al. (2010, Comput. Phys. Commun. 181, 259,
Table 2 b). The covariance of both tables, whose expected value is zero, is a control variate. The variance is at most
the sum of the numerators of the total indices (Efron and Stein 1981, Ann. Stat. 9, 586).

Few rows of a Sobol sequence have columns that coincide. Rows are therefore a Latin hypercube until each group of a
scrambled sequence has enough of them. Intervals follow from the jackknife of the groups. Where an output jumps, few
rows may not contain the rare large changes of an input, which the jackknife cannot see: upper limits include one
further row with the largest change due to any input.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tailslap.campaign.input_ranges import Range
from tailslap.case import resources
from tailslap.case.force_band import PERCENTILES, percentile_names

if TYPE_CHECKING:
    from tailslap.campaign.records import Record

Array = NDArray[np.float64]

SEED = 307
"""Seed of all random numbers, so that results are reproducible."""

LEAST_ROWS, GROUPS, ROWS_PER_COLUMN = 32, 16, 8
"""Fewest rows of a table, number of groups, and rows of a group per column that a Sobol sequence requires."""

CONFIDENCE, CONTRADICTION = 0.98, 0.9999
"""Two-sided probability of the intervals stated as 95 %, and one-sided probability of a refusal.

The margin allows for skewed outputs and few rows.
"""

TOO_FEW = "Sobol indices are not determined: too few samples differ for an error. Increase --samples."

FEW = 10
"""Number of changed outputs below which upper limits are those of a binomial fraction."""

MIN_ROWS = 16
"""Rows below which there are no indices."""


def sobol_points(ranges: tuple[Range, ...], rows: int) -> tuple[Array, Array]:
    """Draw two tables of inputs, each of shape (inputs, rows).

    They are the halves of one set of points in twice the dimensions.
    """
    random, columns = np.random.default_rng(SEED), 2 * len(ranges)
    if not _are_nets(len(ranges), rows):
        drawn = latin_hypercube(columns, rows, random.spawn(1)[0])
    else:
        from scipy.stats import qmc

        drawn = qmc.Sobol(columns, scramble=True, bits=64, seed=random).random(rows).T
    lower, upper = (np.array([[getattr(item, end)] for item in ranges]) for end in ("lower", "upper"))
    a, b = (lower + (upper - lower) * half for half in np.split(drawn, 2))
    return a, b


def latin_hypercube(columns: int, rows: int, random: np.random.Generator) -> Array:
    """Return points of the unit cube, shape (columns, rows).

    Each of `rows` equal parts of every axis has one.
    """
    offsets = random.uniform(size=(rows, columns)).T
    parts = np.tile(np.arange(1, rows + 1), (columns, 1))
    for column in parts:
        random.shuffle(column)
    return np.asarray((parts - offsets) / rows)


def _are_nets(inputs: int, rows: int) -> bool:
    """Return True if groups have distinct columns."""
    return rows >= GROUPS * ROWS_PER_COLUMN * 2 * inputs


def points_in_words(inputs: int, rows: int) -> str:
    """Return the kind of point set in words."""
    return "a scrambled Sobol sequence" if _are_nets(inputs, rows) else "a Latin hypercube"


def sampled(
    ranges: tuple[Range, ...], at_least: int, solve: Callable[[dict[str, Array]], Mapping[str, Array]]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Sample the inputs and compute their results (Saltelli 2010).

    The number of rows is a power of two.

    Parameters
    ----------
    ranges : tuple of Range
        Independent, uniformly distributed inputs.
    at_least : int
        Least number of samples in all.
    solve : callable
        Takes inputs by key, shape (n,) [SI], and returns columns by name, shape (n,); NaN without a solution.

    Returns
    -------
    inputs : dict of ndarray, shape ((inputs + 2) rows,)
        By key: two tables without common rows, and for each input the first table with that input from the second.
    tables : dict of ndarray, shape (inputs + 2, rows)
        Results by name, in the same order.
    """
    rows = 1 << math.ceil(math.log2(max(LEAST_ROWS, at_least / (len(ranges) + 2))))
    a, b = sobol_points(ranges, rows)
    mixed = [np.where(np.arange(len(a))[:, None] == i, b, a) for i in range(len(a))]
    inputs = dict(zip((item.key for item in ranges), np.hstack([a, b, *mixed]), strict=True))
    return inputs, {name: column.reshape(-1, rows) for name, column in solve(inputs).items()}


def solved_in_blocks(
    solve: Callable[[dict[str, Array]], Mapping[str, Array]],
    inputs: Mapping[str, Array],
    block: int,
    show: Callable[[float], None] = lambda fraction: None,
    first: int = 1,
) -> dict[str, Array]:
    """Compute results of inputs in blocks on all cores.

    solve: see `sampled`. block: number of samples at a time. show: takes the fraction of finished samples. first:
    number of samples before all others, which compile, or are refused at little cost.
    """
    from concurrent.futures import ThreadPoolExecutor

    size, results = next(iter(inputs.values())).size, dict[str, Array]()
    blocks = [slice(0, first), *(slice(start, start + block) for start in range(first, size, block))]
    threads = ThreadPoolExecutor(resources.available_cores())  # compiled code runs beside other threads

    def of_block(rows: slice) -> Mapping[str, Array]:
        return solve({key: values[rows] for key, values in inputs.items()})

    def of_blocks() -> Iterator[Mapping[str, Array]]:
        yield of_block(blocks[0])
        yield from threads.map(of_block, blocks[1:])

    try:
        for number, (rows, columns) in enumerate(zip(blocks, of_blocks(), strict=True), 1):
            for name, values in columns.items():
                results.setdefault(name, np.empty(size))[rows] = values
            show(number / len(blocks))
    finally:
        threads.shutdown(cancel_futures=True)
    return results


@dataclass(frozen=True)
class Band:
    """Distribution of a quantity [SI].

    `percentiles` are those of PERCENTILES, `values` all finite samples.
    """

    percentiles: tuple[float, ...]
    mean: float
    standard_deviation: float
    values: Array

    def fraction_below(self, value: float) -> float:
        """Return the fraction of samples below a value."""
        return float(np.mean(self.values < value))

    def numbers(self) -> dict[str, float]:
        """Return the numbers of a summary."""
        ends = zip(percentile_names(), self.percentiles, strict=True)
        moments = {"mean": self.mean, "standard_deviation": self.standard_deviation}
        return {**dict(ends), **moments}


def band_of(values: Array) -> Band:
    """Return the distribution of a sample's finite values.

    Of a table, these are its first two rows.
    """
    values = values[:2].ravel() if values.ndim == 2 else values
    finite = values[np.isfinite(values)]
    places = 0.01 * np.array(PERCENTILES) * (finite.size - 1)
    ends = np.interp(places, np.arange(finite.size), np.sort(finite))  # `np.percentile` loads masked arrays
    return Band(tuple(ends.tolist()), float(finite.mean()), float(finite.std(ddof=1)), finite)


class Indices(NamedTuple):
    """Sobol indices with 95 % confidence intervals.

    Indices have shape (inputs,), intervals shape (2, inputs). `refusal` is the reason why they are not shown, or "".
    """

    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    refusal: str


def sobol_indices(table: Array) -> Indices:
    """Return first-order and total indices with their intervals.

    Rows with NaN are excluded. The jackknife excludes each group of rows in turn, with Student's t. Groups belong to
    one sequence or Latin hypercube, and their means scatter less than those of independent groups, so that the
    intervals are conservative.

    Parameters
    ----------
    table : ndarray, shape (inputs + 2, rows)
        Results of `sampled`.
    """
    finite, inputs = np.isfinite(table).all(axis=0), len(table) - 2
    group = (np.arange(finite.size) * GROUPS // finite.size)[finite]
    table = table[:, finite] - np.mean(table[:2, finite])
    terms = _terms(table)
    sums = np.array([np.bincount(group, row, GROUPS) for row in terms])
    count = np.bincount(group, minlength=GROUPS)
    sums, count = sums[:, count > 0], count[count > 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = _ratios(sums.sum(axis=1) / group.size)
        without = _ratios((sums.sum(axis=1, keepdims=True) - sums) / (group.size - count))
        error = np.sqrt((count.size - 1) * np.var(without, axis=1))
    low, high = ratios[:-1] + np.outer(
        (-1.0, 1.0), _quantile(0.5 + 0.5 * CONFIDENCE, count.size) * error[:-1]
    )
    high += _further_row(terms[inputs:-3], ratios[inputs:-1])
    is_undetermined, bound = _bounds(table, ratios[inputs:-1])
    low, high = np.where(is_undetermined, 0.0, low), np.where(is_undetermined, np.maximum(bound, high), high)
    first, total, *ends = (
        part for row in (ratios[:-1], low, high) for part in np.split(np.clip(row, 0.0, 1.0), 2)
    )
    refusal = _refusal(ratios, error, _quantile(CONTRADICTION, count.size))
    return Indices(first, total, np.array(ends[::2]), np.array(ends[1::2]), refusal)


def _terms(table: Array) -> Array:
    """Return the products whose means determine the indices.

    The shape is (2 inputs + 3, rows).
    """
    a, b, *_ = table
    mixed = table[2:]
    return np.vstack([b * mixed, 0.5 * (a - mixed) ** 2, a * b, 0.5 * (a * a + b * b), 0.5 * (a + b)])


def _ratios(means: Array) -> Array:
    """Return both indices and the sum of the totals.

    means: of `_terms`, along the first axis.
    """
    inputs = (len(means) - 3) // 2
    mixed, changes, (both, square, mean) = means[:inputs], means[inputs:-3], means[-3:]
    variance, chance = square - mean**2, both - mean**2
    first = mixed - mean**2 - (1.0 - changes / variance) * chance
    in_all = changes.sum(axis=0, keepdims=True)
    bounded = np.minimum(variance, in_all)
    return np.concatenate([first / bounded, changes / bounded, in_all / variance])


def _further_row(changes: Array, total: Array) -> float:
    """Return the index due to one further row with the largest change.

    changes, shape (inputs, rows): terms of the total indices, whose sums are in proportion to them.
    """
    first = int(np.argmax(changes.sum(axis=1)))
    return float(np.nan_to_num(total[first] * changes.max() / changes[first].sum(), nan=0.0))


def _bounds(table: Array, total: Array) -> tuple[Array, Array]:
    """Return upper limits of indices with few changed outputs.

    The limits are that of the fraction that changes (Clopper-Pearson) times the larger mean change, of the input or of
    all inputs together.
    """
    from scipy.special import betaincinv

    rows, changed = table.shape[1], np.count_nonzero(table[0] != table[2:], axis=1)
    fraction = betaincinv(changed + 1.0, np.maximum(rows - changed, 0.5), 0.5 + 0.5 * CONFIDENCE)
    of_all = rows / max(1, np.count_nonzero(table[0] != table[1]))
    bound = fraction * np.maximum(of_all, total * rows / np.maximum(changed, 1))
    return np.tile(changed < FEW, 2), np.tile(bound, 2)


def _quantile(probability: float, groups: int) -> float:
    """Return a quantile of Student's t."""
    from scipy.special import stdtrit  # scipy.stats takes longer to import than many studies

    return float(stdtrit(groups - 1, probability))


def _refusal(ratios: Array, error: Array, quantile: float) -> str:
    """Return the reason for refused indices, or "".

    The sum of the total indices is below 1 by more than its error, or the error is unknown.
    """
    highest = ratios[-1] + quantile * error[-1]
    if highest < 1.0:
        return (
            f"Sobol indices are not determined: the sum of the total indices is {ratios[-1]:.2f}, with its error "
            f"at most {highest:.2f}; for independent inputs it is at least 1. Increase --samples."
        )
    return "" if np.isfinite([*ratios, *error]).all() else TOO_FEW


def index_rows(ranges: tuple[Range, ...], table: Array) -> tuple[list[Record], str]:
    """Return the indices of each input with intervals.

    There are no rows where the indices are refused; the second value is the reason.
    """
    if np.count_nonzero(np.isfinite(table).all(axis=0)) < MIN_ROWS:
        return [], TOO_FEW
    indices = sobol_indices(table)
    if indices.refusal:
        return [], indices.refusal
    first, total = (indices.first_interval.T.tolist(), indices.total_interval.T.tolist())
    rows = [
        {
            **{name: getattr(item, name) for name in ("key", "lower", "upper", "unit", "origin")},
            "of_the_scene": item.scene_value,
            "first_order": float(indices.first[i]),
            "first_order_interval": first[i],
            "total": float(indices.total[i]),
            "total_interval": total[i],
        }
        for i, item in enumerate(ranges)
    ]
    return rows, ""


def rows_and_refusals(
    ranges: tuple[Range, ...], tables: Mapping[str, Array]
) -> tuple[dict[str, list[Record]], dict[str, str]]:
    """Return `index_rows` of all outputs that vary, and the reasons of refusals."""
    indexed = {name: index_rows(ranges, table) for name, table in tables.items() if _varies(table)}
    refusals = {name: why for name, (_, why) in indexed.items() if why}
    return {name: rows for name, (rows, _) in indexed.items()}, refusals


def _varies(table: Array) -> bool:
    """Return True unless the first two rows are constant."""
    finite = table[:2, np.isfinite(table).all(axis=0)]
    return bool(finite.std() > 1e-9 * abs(finite.mean()))
