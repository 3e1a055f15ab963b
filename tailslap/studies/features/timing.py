"""Times of loops that take turns, so that whatever else the machine does falls on all of them alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SEED, RESAMPLES = 20251, 2000
CONFIDENCE = 0.95
"""Of the intervals."""


@dataclass(frozen=True)
class Spread:
    """Best, median, and the quartiles of some times, in one unit."""

    best: float
    median: float
    lower_quartile: float
    upper_quartile: float


@dataclass(frozen=True)
class Ratio:
    """Median of the ratios turn by turn, and the ends of its 95 % confidence interval."""

    median: float
    low: float
    high: float


def take_turns(
    runs: Sequence[Callable[[], float]], turns: int, progress: Callable[[float], None] = lambda share: None
) -> Floats:
    """What each run returns in each turn, shape (turns, runs): A B C, then C B A, and so on."""
    table = np.empty((turns, len(runs)))
    for turn in range(turns):
        order = range(len(runs)) if turn % 2 == 0 else reversed(range(len(runs)))
        for i in order:
            table[turn, i] = runs[i]()
        progress((turn + 1) / turns)
    return table


def seconds(work: Callable[[], object]) -> float:
    """Wall-clock time of one call [s]."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def spread(times: Floats) -> Spread:
    """Of times of shape (turns,)."""
    lower, median, upper = np.percentile(times, (25.0, 50.0, 75.0))
    return Spread(float(times.min()), float(median), float(lower), float(upper))


def ratio(times: Floats, reference: Floats) -> Ratio:
    """Median of times over reference, both of shape (turns,), with a percentile bootstrap over the turns.

    Turn by turn, because a slow spell of the machine then cancels; the median, because one hiccup must not count.
    """
    from scipy.stats import bootstrap

    values = times / reference
    interval = bootstrap(
        (values,),
        np.median,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        random_state=np.random.default_rng(SEED),
    ).confidence_interval
    return Ratio(float(np.median(values)), float(interval.low), float(interval.high))
