"""Verify Sobol indices, their intervals and points by SciPy's estimators."""

import math

import numpy as np
import pytest
import sobol_coverage as benchmark
from scipy import stats

from tailslap.campaign import sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.sampling import sobol_indices, sobol_points


def ishigami(rows):
    """f(A), f(B) and rows f(AB) of Ishigami's function on (-pi, pi)^3."""
    points = math.pi * (2.0 * stats.qmc.Sobol(6, seed=np.random.default_rng(1)).random(rows).T - 1.0)
    a, b = points[:3], points[3:]
    tables = [a, b, *(np.where(np.arange(3)[:, None] == i, b, a) for i in range(3))]
    forces = [np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x) for x, y, z in tables]
    return np.array(forces)


def test_estimators_are_scipys_and_give_ishigamis_indices():
    """Compare with SciPy and the exact indices of Ishigami's function.

    V_1 = (1 + 0.1 pi^4/5)^2/2, V_2 = 7^2/8 and V_13 = 0.1^2 pi^8 8/225. Control variate of the first-order index:
    T cov(f_A, f_B), since f_AB varies with f_A by 1 - T.
    """
    table = ishigami(2**14)
    (f_a, f_b), f_ab, indices = table[:2], table[2:], sobol_indices(table)
    reference = stats.sobol_indices(func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": f_ab[:, None]}, n=2**14)
    mean, variance = np.mean(table[:2]), np.var(table[:2])
    chance = np.mean((f_a - mean) * (f_b - mean)) / variance
    first = reference.first_order + reference.total_order * chance
    assert indices.first == pytest.approx(np.clip(first, 0.0, 1.0), abs=1e-12)
    assert indices.total == pytest.approx(reference.total_order, abs=1e-12)
    v_1, v_2, v_13 = (1 + 0.1 * math.pi**4 / 5) ** 2 / 2, 49 / 8, 0.01 * math.pi**8 * 8 / 225
    variance = v_1 + v_2 + v_13
    assert indices.first == pytest.approx(np.array([v_1, v_2, 0.0]) / variance, abs=2e-3)
    assert indices.total == pytest.approx(np.array([v_1 + v_13, v_2, v_13]) / variance, abs=2e-3)


def by_hand(table):
    """First-order and total indices, the variance bounded by the totals' numerators."""
    (a, b), ab = table[:2], table[2:]
    changes, variance = np.mean((a - ab) ** 2, axis=1) / 2.0, np.var([a, b])
    centre = np.mean([a, b])
    of_b, chance = np.mean(b * ab, axis=1) - centre**2, np.mean(a * b) - centre**2
    bounded = min(variance, changes.sum())
    return np.array([of_b - (1.0 - changes / variance) * chance, changes]) / bounded


def test_the_intervals_are_those_of_the_jackknife_of_groups():
    """Rows with NaN are omitted before the groups are formed."""
    table = ishigami(256)
    table[3, [0, 1, 40, 41, 42]] = np.nan
    rows, size = np.flatnonzero(np.isfinite(table[3])), 256 // sampling.GROUPS
    table -= np.mean(table[:2, rows])
    without = [by_hand(table[:, rows[rows // size != group]]) for group in range(sampling.GROUPS)]
    error = np.std(without, axis=0) * math.sqrt(sampling.GROUPS - 1)
    wide = stats.t.ppf(0.5 + 0.5 * sampling.CONFIDENCE, sampling.GROUPS - 1) * error
    indices, middle = sobol_indices(table), by_hand(table[:, rows])
    changes = 0.5 * (table[0] - table[2:])[:, rows] ** 2
    further = changes.max() / changes[0].sum() * middle[1][0]
    for i, interval in enumerate((indices.first_interval, indices.total_interval)):
        expected = np.clip([middle[i] - wide[i], middle[i] + wide[i] + further], 0.0, 1.0)
        assert interval == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("inputs", "rows"), [(5, 64), (14, 64), (14, 128)])
def test_the_intervals_cover_indices_of_rare_jumps(inputs, rows):
    """Few rows do not contain jumps of all inputs."""
    covered = benchmark.coverage(benchmark.jumps(inputs, 0.003), rows, 12)["covered"]
    assert np.min(covered) >= 0.95


def test_the_errors_of_the_indices_are_those_of_random_rows():
    """Half of an interval is a quantile of the error over repetitions."""
    random, results, half = np.random.default_rng(2), [], []
    for _ in range(60):
        x, y = random.uniform(0.5, 1.0, (2, 2, 512))
        result = sobol_indices(np.array([x[0] * y[0], x[1] * y[1], x[1] * y[0], x[0] * y[1]]))
        results.append([*result.first, *result.total])
        intervals = np.hstack([result.first_interval, result.total_interval])
        half.append(results[-1] - intervals[0])
    quantile = stats.t.ppf(0.5 + 0.5 * sampling.CONFIDENCE, sampling.GROUPS - 1)
    assert np.mean(half, axis=0) == pytest.approx(quantile * np.std(results, axis=0, ddof=1), rel=0.3)


@pytest.mark.parametrize(("inputs", "rows"), [(2, 32), (11, 32), (21, 64), (2, 512)])
def test_the_intervals_cover_exact_indices(inputs, rows):
    """95 % of the indices of four functions are covered."""
    covered = [benchmark.coverage(function, rows, 12)["covered"] for function in benchmark.functions(inputs)]
    assert np.min(np.mean(covered, axis=0)) >= 0.95
    assert np.min(covered) >= 0.85, "each function"


def unit_ranges(inputs):
    return tuple(Range(f"x{i}", 0.0, 1.0, "", None, "") for i in range(inputs))


@pytest.mark.parametrize("inputs", [1, 2, 3, 5, 7, 9, 11, 15, 21, 35])
def test_no_two_columns_of_the_points_coincide(inputs):
    """Correlations stay below 5 standard deviations of independent columns."""
    for rows in (2**m for m in range(5, 13)):
        correlation = np.corrcoef(np.vstack(sobol_points(unit_ranges(inputs), rows)))
        assert np.abs(correlation - np.eye(2 * inputs)).max() < 5.0 / math.sqrt(rows), rows


def test_points_are_uniform():
    """Kolmogorov's statistic of each column, A and B together."""
    for rows in (32, 256, 4096):
        for column in np.vstack(sobol_points(unit_ranges(3), rows)):
            assert stats.kstest(column, "uniform").pvalue > 0.5
            assert len(np.unique(column)) == rows


def test_totals_whose_sum_is_below_one_are_refused():
    """f changes by less than its variance between A and B."""
    random = np.random.default_rng(4)
    a = random.random((3, 64))
    b = np.clip(a + 0.1 * random.standard_normal(a.shape), 0.0, 1.0)
    table = np.array([a.sum(axis=0), b.sum(axis=0), *(a.sum(axis=0) - a + b)])
    rows, refusal = sampling.index_rows(unit_ranges(3), table)
    assert rows == []
    assert "the sum of the total indices is 0." in refusal
    rows, refusal = sampling.index_rows(unit_ranges(3), np.array([*table[:2], *[table[0]] * 3]))
    assert rows == []
    assert "the sum of the total indices is 0.00" in refusal
    for seed in range(20):  # additive: the sum is 1, and is never shown below it
        x, y = np.random.default_rng(seed).random((2, 3, 32))
        table = np.array([x.sum(axis=0), y.sum(axis=0), *(x.sum(axis=0) - x + y)])
        rows, refusal = sampling.index_rows(unit_ranges(3), table)
        assert refusal or sum(row["total"] for row in rows) >= 1.0 - 1e-12


def test_few_changed_outputs_have_the_limits_of_a_binomial_fraction():
    """No change in 64 rows bounds the probability.

    (1 - p)^64 = (1 - confidence)/2.
    """
    a, b = np.arange(64) % 2 * 1.0, np.arange(64) // 2 % 2 * 1.0
    indices = sobol_indices(np.array([a, b, a, b]))
    limit = 1.0 - (0.5 - 0.5 * sampling.CONFIDENCE) ** (1.0 / 64.0)
    assert indices.total_interval[:, 0] == pytest.approx([0.0, limit / 0.5], abs=1e-12)
    assert indices.first_interval[:, 0] == pytest.approx([0.0, limit / 0.5], abs=1e-12)
    assert (indices.first[0], indices.total[0]) == (0.0, 0.0)
