"""Compiled band of a page, with what decides it."""

import math
from typing import NamedTuple

import numpy as np

from machine_code.compiled import compact, compiled
from postprocess.signals.compiled_filters import centred_means
from solver.impact.accuracy import solve_sample
from tailslap.browser.kernels import ENDS, POSSIBLE, assemble, complete
from tailslap.case.impact.answers import MEAN_WINDOW


class Ranges(NamedTuple):
    """Ranges of varied quantities.

    quantities, shape (ranges, 3): the varied one, one of which a part is added, and the greatest value; -1 for none.
    widths, shape (ranges, 6): half the width, absolute, over the quantity, and over the other; both ends of a range
    that is fixed, NaN otherwise; of an omitted quantity its assumed value over the other, otherwise 0. bounds, shape
    (ranges, 2): of the key; mass: the quantity that is the vehicle's mass; light, shape (vehicles, 2): masses of light
    vehicles and their tolerance, by which it varies; drawn, shape (ranges, n): places within the ranges. Results: ends,
    shape (ranges, 2): NaN for a value outside a fixed range; fractions, shape (ranges,): of the variance of the force.
    scaled, shape (ranges, n), matrix, shape (ranges, ranges + 1): workspace.
    """

    quantities: np.ndarray
    widths: np.ndarray
    bounds: np.ndarray
    mass: int
    light: np.ndarray
    drawn: np.ndarray
    ends: np.ndarray
    fractions: np.ndarray
    scaled: np.ndarray
    matrix: np.ndarray


class Growth(NamedTuple):
    """Growth of the force of the first vehicles with the speed.

    speeds: lower and higher one [m/s]; forces, shape (2, pairs) [N]; ratio, shape (1,): result, the geometric mean of
    higher over lower forces, 0 without one.
    """

    speeds: np.ndarray
    forces: np.ndarray
    ratio: np.ndarray


@compact
def solve_band(nominal, values, parts, ranges, classes, growth, case, outcome, means, forces, percentiles):
    """Solve the impacts of a band.

    The percentiles of their largest means, the fractions of the variance and the growth are filled.

    nominal: shape (quantities, 1); values, shape (quantities, n); means: workspaces of the mean forces; forces, shape
    (n,); percentiles, shape (2, m): their places and results. Returns the reason why there is no band with its item,
    the verdict on a motion, the number of ranges, and the class of vehicles by which the band is calibrated, or -1.
    """
    complete(nominal, parts)
    varied, item = spread(nominal, values, ranges)
    if item >= 0:
        return ENDS, item, 0, varied, -1
    for i in range(values.shape[1]):
        reason, item, verdict, forces[i] = largest_mean(values, parts, case, outcome, means, i)
        if reason != POSSIBLE or verdict != 0:
            return reason, item, verdict, varied, -1
    explain(ranges, forces)
    pairs = growth.forces.shape[1]
    for s in range(2):
        for i in range(pairs):
            values[parts.common[0], i] = growth.speeds[s]
            reason, item, verdict, growth.forces[s, i] = largest_mean(values, parts, case, outcome, means, i)
            if reason != POSSIBLE or verdict != 0:
                return reason, item, verdict, varied, -1
    total, count = 0.0, 0
    for i in range(pairs):
        if growth.forces[0, i] > 0.0 and growth.forces[1, i] > 0.0:
            total, count = total + math.log(growth.forces[1, i] / growth.forces[0, i]), count + 1
    growth.ratio[0] = math.exp(total / float(count)) if count > 0 else 0.0
    fill_percentiles(forces, forces.size, percentiles)
    return POSSIBLE, 0, 0, varied, calibrate(nominal, parts, classes, percentiles)


@compiled
def largest_mean(values, parts, case, outcome, means, i):
    """Solve sample i.

    Returns the reason why it is impossible with its item, the verdict on its motion, and the largest 50 ms mean [N].
    """
    train, tyres, start, choice, clock, work = case
    integral, touched, mean = means
    reason, item = assemble(values, parts, train, tyres, start, i)
    if reason != POSSIBLE:
        return reason, item, 0, 0.0
    interval = choice.interval
    solve_sample((train, tyres, start[i], choice, clock, work), outcome, i, outcome.rows[0])
    if outcome.verdict[i] != 0:
        return POSSIBLE, 0, outcome.verdict[i], 0.0
    size = mean_forces(outcome.rows[0], interval, clock.reached[i], touched)
    centred_means(touched, size, 0.5 * MEAN_WINDOW / interval, integral, mean)
    largest = 0.0
    for k in range(1, size):
        largest = max(largest, mean[k])
    return POSSIBLE, 0, 0, largest


@compiled
def explain(ranges, forces):
    """Fill the fraction of the variance of forces due to each range.

    By linear regression on their places, as `band_samples.variance_fractions`; 0 of a range that is not varied. The
    normal equations are well conditioned, since the columns of a Latin hypercube hardly depend on one another.
    """
    size, count = ranges.drawn.shape
    mean, variance = moments(forces)
    for r in range(size):
        is_fixed = np.isnan(ranges.ends[r, 0])
        middle, spread_of = moments(ranges.drawn[r])
        scale = 0.0 if is_fixed else 1.0 / math.sqrt(spread_of)
        for i in range(count):
            ranges.scaled[r, i] = scale * (ranges.drawn[r, i] - middle)
    for r in range(size):
        for q in range(size):
            ranges.matrix[r, q] = 1.0 if r == q else inner(ranges.scaled[r], ranges.scaled[q])
        total = 0.0
        for i in range(count):
            total += ranges.scaled[r, i] * (forces[i] - mean)
        ranges.matrix[r, size] = total / float(count)
    eliminate(ranges.matrix, ranges.fractions)
    for r in range(size):
        ranges.fractions[r] = ranges.fractions[r] ** 2 / max(variance, 2.0**-1022)


@compiled
def moments(values):
    """Return mean and variance of values."""
    mean = variance = 0.0
    for i in range(values.size):
        mean += values[i]
    mean = mean / float(values.size)
    for i in range(values.size):
        variance += (values[i] - mean) ** 2
    return mean, variance / float(values.size)


@compiled
def inner(first, second):
    """Return the mean of the products of values."""
    total = 0.0
    for i in range(first.size):
        total += first[i] * second[i]
    return total / float(first.size)


@compiled
def eliminate(matrix, solution):
    """Solve symmetric positive definite equations, right-hand side last."""
    size = solution.size
    for k in range(size):
        for r in range(k + 1, size):
            factor = matrix[r, k] / matrix[k, k]
            for q in range(k, size + 1):
                matrix[r, q] -= factor * matrix[k, q]
    for k in range(size - 1, -1, -1):
        total = matrix[k, size]
        for q in range(k + 1, size):
            total -= matrix[k, q] * solution[q]
        solution[k] = total / matrix[k, k]


@compiled
def fill_percentiles(forces, count, percentiles):
    """Sort forces, and fill the percentiles of the least ones.

    Those beyond the count are infinite.
    """
    sort(forces)
    for k in range(percentiles.shape[1]):
        place = 0.01 * percentiles[0, k] * float(count - 1)
        j = min(int(place), count - 2)
        percentiles[1, k] = forces[j] + (place - float(j)) * (forces[j + 1] - forces[j])


@compiled
def calibrate(nominal, parts, classes, percentiles):
    """Widen percentiles about the median by the class of the vehicle.

    classes, shape (classes, 5): least and greatest speed and mass, and factor on logarithms, NaN for none. Returns the
    class, or -1.
    """
    speed, mass, median = nominal[parts.common[0], 0], 0.0, percentiles[1, percentiles.shape[1] // 2]
    for u in range(parts.units.shape[0]):
        mass += nominal[parts.units[u, 2], 0]
    for c in range(classes.shape[0]):
        if speed < classes[c, 0] or speed > classes[c, 1] or mass < classes[c, 2] or mass > classes[c, 3]:
            continue
        for k in range(percentiles.shape[1] if classes[c, 4] > 0.0 else 0):
            percentiles[1, k] = median * (percentiles[1, k] / median) ** classes[c, 4]
        return c
    return -1


@compiled
def mean_forces(rows, interval, end, touched):
    """Fill mean forces between rows, after a first value of 0.

    Returns their number.
    """
    count, impulse = int(np.ceil(end / interval)), 0.0
    touched[0] = 0.0
    for k in range(count + 1):
        before = impulse
        if float(k) * interval < end + (1.0 - 1e-9) * interval:  # rows beyond were never written
            impulse = max(impulse, rows[k, 0]) if k > 0 else rows[0, 0]
        if k > 0:
            touched[k] = (impulse - before) / interval
    return count + 1


@compiled
def sort(values):
    """Sort values in place, by insertion."""
    for i in range(1, values.size):
        value, k = values[i], i
        while k > 0 and values[max(k - 1, 0)] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value


@compiled
def spread(nominal, values, ranges):
    """Fill the quantities of all samples, shape (quantities, n).

    Returns the number of ranges, and one whose ends are beyond the bounds of its key, or -1.
    """
    varied = 0
    for i in range(values.shape[1]):
        for q in range(values.shape[0]):
            values[q, i] = nominal[q, 0]
    for r in range(ranges.quantities.shape[0]):
        q, further, most = ranges.quantities[r, 0], ranges.quantities[r, 1], ranges.quantities[r, 2]
        value, low, high = nominal[q, 0], ranges.widths[r, 3], ranges.widths[r, 4]
        if ranges.widths[r, 5] > 0.0:  # assumed where the scene omits it
            value = ranges.widths[r, 5] * nominal[further, 0]
        if np.isnan(low):
            half = ranges.widths[r, 0] + ranges.widths[r, 1] * value
            if further >= 0:
                half += ranges.widths[r, 2] * nominal[further, 0]
            for v in range(ranges.light.shape[0] if q == ranges.mass else 0):
                if abs(value - ranges.light[v, 0]) <= ranges.light[v, 1]:
                    half = ranges.light[v, 1]
            low, high = value - half, value + half
            if most >= 0:
                low, high = max(low, 0.0), min(high, nominal[most, 0])
        margin = 1e-9 * (high - low)
        if not (value >= low - margin and value <= high + margin):
            ranges.ends[r, 0] = ranges.ends[r, 1] = np.nan
            continue
        ranges.ends[r, 0], ranges.ends[r, 1] = low, high
        if not (low >= ranges.bounds[r, 0] and low < high and high <= ranges.bounds[r, 1]):
            return varied, r
        varied += 1
        for i in range(values.shape[1]):
            values[q, i] = low + (high - low) * ranges.drawn[r, i]
    return varied, -1
