"""Sobol indices: the share of the variance that comes from each input, alone and with its interactions.

The estimators are those of `scipy.stats.sobol_indices` (Saltelli et al. 2010, Comput. Phys. Commun. 181, 259,
Table 2 b and f), written as means over rows. That makes the bootstrap a product of two tables, where SciPy's
takes a square of the number of rows; and rows can be left out, where SciPy turns a NaN into an index of 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tailslap.studies.uncertainty.model import Array

RESAMPLES = 500
LEVEL = 0.95


@dataclass(frozen=True)
class Indices:
    """An index for each input, shape (inputs,), and the ends of its confidence interval, shape (2, inputs)."""

    first: Array
    total: Array
    first_interval: Array
    total_interval: Array


def sobol_indices(force_a: Array, force_b: Array, force_ab: Array, seed: int) -> Indices:
    """First-order and total indices, with percentile intervals of the bootstrap over rows.

    Arrays as in `Samples`, without NaN. The rows are quasi-random, more even than random ones, which the
    bootstrap does not see: its intervals err on the wide side. Without variance the indices are NaN.
    """
    terms = _terms(force_a, force_b, force_ab)
    random, rows = np.random.default_rng(seed), len(terms)
    resampled = [
        _resampled_mean(terms, random.integers(0, rows, rows, dtype=np.int32)) for _ in range(RESAMPLES)
    ]
    ends = np.quantile(_ratios(np.array(resampled)), ((1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0), axis=0)
    first, total = np.split(_ratios(terms.mean(axis=0)), 2)
    first_interval, total_interval = np.split(ends, 2, axis=-1)
    return Indices(first, total, first_interval, total_interval)


def _terms(force_a: Array, force_b: Array, force_ab: Array) -> Array:
    """What the means are taken of, shape (rows, 2 inputs + 2): first-order and total terms, F^2 and F."""
    mean = np.mean([force_a, force_b])
    a, b, ab = force_a - mean, force_b - mean, force_ab - mean
    terms: Array = np.vstack([b * (ab - a), 0.5 * (a - ab) ** 2, 0.5 * (a * a + b * b), 0.5 * (a + b)]).T
    return np.ascontiguousarray(terms)


def _resampled_mean(terms: Array, drawn: NDArray[np.int32]) -> Array:
    mean: Array = np.bincount(drawn, minlength=len(terms)) @ terms / len(terms)
    return mean


def _ratios(means: Array) -> Array:
    """Indices, first-order ones and then total ones, from the means of the terms along the last axis."""
    variance = means[..., -2:-1] - means[..., -1:] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios: Array = means[..., :-2] / variance
    return ratios
