"""Compiled means and low-pass filters of histories."""

import math

from machine_code.compiled import compiled


@compiled
def means_of_all(values, half, integral, means):
    """Fill the centred means of histories.

    values, means: shape (histories, n); half: of the width, in samples; integral: workspace, shape (n + 1,).
    """
    for k in range(values.shape[0]):
        centred_means(values[k], values.shape[1], half, integral, means[k])


@compiled
def centred_means(values, size, half, integral, means):
    """Fill the centred means of a history's first `size` samples.

    Before the start the first value is continued. Near the end stands the last mean that does not extend beyond it.
    """
    integral[0] = 0.0
    for k in range(size):
        integral[k + 1] = integral[k] + values[k]
    inside = max(0, int(float(size) - half + 0.5))
    for k in range(size):
        centre = float(k) + 0.5 if k < inside else float(size) - half
        after, before = (centre + half), (centre - half)
        means[k] = (_up_to(values, size, integral, after) - _up_to(values, size, integral, before)) / (
            2.0 * half
        )


@compiled
def _up_to(values, size, integral, place):
    """Return the integral from the start to a place in samples."""
    if place <= 0.0:
        return place * values[0]
    k = min(int(place), size - 1)
    return integral[k] + (place - float(k)) * values[k]


@compiled
def low_pass_of_all(values, padding, corner, padded, filtered):
    """Fill histories that are filtered forward and backward.

    values, filtered: shape (histories, n); other arguments: as of `filter_both_ways`.
    """
    for k in range(values.shape[0]):
        filter_both_ways(values[k], values.shape[1], padding, corner, padded, filtered[k])


@compiled
def filter_both_ways(values, size, padding, corner, padded, filtered):
    """Fill a history's first `size` samples, filtered forward and backward.

    padding: samples with which each end is continued; corner: w_a of the difference equation of SAE J211-1; padded:
    workspace, of at least `size` and twice the padding.
    """
    whole = size + 2 * padding
    for i in range(whole):
        padded[i] = values[min(max(i - padding, 0), size - 1)]
    _one_way(padded, whole, corner, 0, 1)
    _one_way(padded, whole, corner, whole - 1, -1)
    for i in range(size):
        filtered[i] = padded[i + padding]


@compiled
def _one_way(values, size, corner, first, step):
    """Filter values in place, from the steady state of the first one.

    step: 1 forward, -1 backward.
    """
    scale = 1.0 + math.sqrt(2.0) * corner + corner**2
    a_0, b_1 = corner**2 / scale, 2.0 * (1.0 - corner**2) / scale
    b_2 = (math.sqrt(2.0) * corner - 1.0 - corner**2) / scale
    base = values[first]
    x_1, x_2, y_1, y_2 = 0.0, 0.0, 0.0, 0.0  # differences from the steady state
    for i in range(size):
        k = first + step * i
        x = values[k] - base
        y = a_0 * (x + 2.0 * x_1 + x_2) + b_1 * y_1 + b_2 * y_2
        values[k] = base + y
        x_1, x_2, y_1, y_2 = x, x_1, y, y_1
