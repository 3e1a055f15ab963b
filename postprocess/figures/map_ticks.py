"""Round values along the axes of a map, and where they lie between its cells."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from postprocess.figures.style import SUPERSCRIPTS

MANY_DECADES, FEW_DECADES = 4.5, 2.2
"""Decades from which every second power of ten is a tick, and below which threes are ticks too."""

POWERS_BELOW, POWERS_ABOVE = 1e-2, 1e3
"""Powers of ten outside these are written as such."""

MAX_STEPS = 4
"""Steps between ticks where the values are even."""


def round_ticks(values: Sequence[float]) -> list[float]:
    """Round values within the range of these: multiples of 1, 2 or 5 where they are even, else powers of ten, with
    threes on short scales; 0 where they start with it."""
    if is_even(values):
        return _even_ticks(values[0], values[-1])
    zero = [0.0] * (values[0] == 0.0)
    return [*zero, *_power_ticks(values[len(zero)], values[-1])]


def places(ticks: Sequence[float], values: Sequence[float]) -> list[float]:
    """Where the ticks lie, in cells from the edge, by interpolation on the values' own scale; the first value lies
    in the middle of the first cell, at 0.5."""
    middles = np.arange(len(values)) + 0.5
    if is_even(values):
        return [float(place) for place in np.interp(ticks, values, middles)]
    lowest = values[0] or 0.1 * values[1]  # stands for 0, which has no logarithm
    x, known = (np.log(np.maximum(numbers, lowest)) for numbers in (ticks, values))
    return [float(place) for place in np.interp(x, known, middles)]


def tick_texts(ticks: Sequence[float]) -> list[str]:
    """Plain numbers, or all as powers of ten where one would be long."""
    positive = [tick for tick in ticks if tick > 0.0]
    if positive and (min(positive) < POWERS_BELOW or max(positive) > POWERS_ABOVE):
        return [_power_text(tick) for tick in ticks]
    return [f"{tick:g}" for tick in ticks]


def is_even(values: Sequence[float]) -> bool:
    """Whether the values have even steps; two values have, unless a decade or more lies between them."""
    steps = np.diff(values)
    if len(values) == 2:
        return bool(values[0] == 0.0 or values[1] < 10.0 * values[0])
    return bool(np.ptp(steps) < 1e-6 * abs(steps[0]))


def _power_ticks(low: float, high: float) -> list[float]:
    decades = math.log10(high / low)
    mantissas = (1.0, 3.0) if decades < FEW_DECADES else (1.0,)
    every = 2 if decades >= MANY_DECADES else 1
    exponents = range(math.floor(math.log10(low) / every) * every, math.ceil(math.log10(high)) + 1, every)
    return _within(low, high, (mantissa * 10.0**exponent for exponent in exponents for mantissa in mantissas))


def _even_ticks(low: float, high: float) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(MAX_STEPS, steps=[1, 2, 5, 10]).tick_values(low, high)
    return _within(low, high, (round(float(tick), 12) for tick in ticks))


def _within(low: float, high: float, ticks: Iterable[float]) -> list[float]:
    return [tick for tick in ticks if low - 1e-9 * abs(low) <= tick <= high * (1.0 + 1e-9)]


def _power_text(tick: float) -> str:
    """10 to a power; 1 and 0 as they are."""
    if tick in (0.0, 1.0):
        return f"{tick:g}"
    exponent = math.floor(math.log10(tick) + 1e-9)
    mantissa = tick / 10.0**exponent
    power = f"10{str(exponent).translate(SUPERSCRIPTS)}"
    return power if abs(mantissa - 1.0) < 1e-9 else f"{mantissa:g}·{power}"
