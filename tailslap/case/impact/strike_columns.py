"""Quantities of the first front and the first rear strike of impacts.

They are those of the foremost contact of the first unit and of the rearmost one of the last. Arrays with a row per
strike are in the order of time.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from postprocess.signals import filters
from solver.impact import Impacts
from tailslap.case.impact.answers import MEAN_WINDOW, Columns, ImpactAnswer

QUANTITIES = {
    "raw": ("raw", "kN", 1e3),
    "mean_50ms": ("50 ms mean", "kN", 1e3),
    "cfc60": ("CFC 60", "kN", 1e3),
    "impulse": ("impulse", "kN s", 1e3),
    "duration": ("duration", "ms", 1e-3),
}
"""Quantities of both strikes: label, displayed unit, and its size in SI. The first three are peaks of the total force
in the strike, raw and filtered."""
FORCES = ("raw", "mean_50ms", "cfc60")

COLUMNS = tuple(f"strike_{strike}.{name}" for strike in (1, 2) for name in QUANTITIES)

LARGEST = "peaks.mean_50ms"
"""Column of the largest 50 ms mean of an impact."""

AT_ONCE = 128
"""Impacts of which forces are filtered at once: more exceed the processor's cache, and memory where they last long."""

SAME_STRIKE = 0.05
"""Gap [s] below which contacts of a corner are one strike: a mean over 50 ms does not separate them."""


def columns_of_many(impacts: Impacts, interval: float, ends: tuple[int, int]) -> dict[str, np.ndarray]:
    """Return the `COLUMNS` and `LARGEST` of n impacts [SI], shape (n,).

    A missing strike is NaN. interval: between the rows of their forces [s]; ends:
    groups of both strikes.
    """
    contacts = impacts.group, impacts.start, impacts.end, impacts.impulse
    tables = []
    for first in range(0, impacts.error.size, AT_ONCE):
        part = slice(first, first + AT_ONCE)
        group, *values = (column[:, part] for column in contacts)
        curves = filters.force_curves(impacts.mean_force[:, part].T, interval, FORCES)
        curves = {name: np.ascontiguousarray(curve) for name, curve in curves.items()}
        strikes = [_first_strike(group == end, *values) for end in ends]
        largest = {LARGEST: curves["mean_50ms"].max(axis=-1)}
        tables.append(largest | _columns(strikes, (curves, curves), interval))
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def both_strikes(answer: ImpactAnswer) -> dict[str, float]:
    """Return the `COLUMNS` and `LARGEST` of an impact [SI].

    A missing strike is NaN. Filters are applied to the force of the corner, for the rigid vehicle to the total force.
    """
    contacts = np.array([(strike.start, strike.end, strike.impulse) for strike in answer.strikes])
    strikes = [
        _first_strike(
            np.array([[strike.corner == corner] for strike in answer.strikes], dtype=np.bool_).reshape(-1, 1),
            *contacts.reshape(-1, 3, 1).swapaxes(0, 1),
        )
        for corner in answer.ends
    ]
    total = answer.history["force_normal"][1:]
    curves = [
        filters.force_curves(force[None], answer.interval, FORCES)
        for force in (total, *(answer.pushes.get(corner, total) for corner in answer.ends))
    ]
    values = {LARGEST: curves[0]["mean_50ms"].max(axis=-1)} | _columns(strikes, curves[1:], answer.interval)
    return {name: float(column[0]) for name, column in values.items()}


StrikeValues = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Start and end [s] and impulse [N s] of n strikes, NaN where there is none."""


def _first_strike(
    is_here: np.ndarray, start: np.ndarray, end: np.ndarray, impulse: np.ndarray
) -> StrikeValues:
    """Join the contacts of a corner's first strike.

    is_here: which contacts are of the corner, shape (contacts, n); start, end [s] and impulse [N s] of all, likewise.
    """
    first = last = np.full(is_here.shape[1], np.nan)
    total, is_open = np.zeros(is_here.shape[1]), np.ones(is_here.shape[1], dtype=np.bool_)
    for here, starts, ends, added in zip(is_here, start, end, impulse, strict=True):
        joins = here & is_open & ~(starts - last > SAME_STRIKE)
        is_open &= joins | ~here
        first = np.where(joins & np.isnan(first), starts, first)
        last = np.where(joins, ends, last)
        total += np.where(joins, added, 0.0)
    return first, last, np.where(np.isnan(first), np.nan, total)


def _columns(
    strikes: Sequence[StrikeValues], curves: Sequence[Columns], interval: float
) -> dict[str, np.ndarray]:
    """Return the `COLUMNS` of n impacts [SI].

    curves: filtered forces during each strike, shape (n, rows).
    """
    values: dict[str, np.ndarray] = {}
    for number, ((start, end, impulse), force) in enumerate(zip(strikes, curves, strict=True), 1):
        measures = peaks_within(force, interval, start, end) | {"impulse": impulse, "duration": end - start}
        values |= {f"strike_{number}.{name}": measures[name] for name in QUANTITIES}
    return values


def peaks_within(
    curves: Mapping[str, np.ndarray], interval: float, start: np.ndarray, end: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the peaks of filtered curves in n strikes.

    curves: shape (n, rows); start, end [s], shape (n,): peaks are NaN where these are. A 50 ms mean counts if its
    window lies in the strike, or about the middle of a shorter one, because the next strike may follow at once.
    """
    occurs, peaks = np.isfinite(start + end), {}
    start, end = np.where(occurs, start, 0.0), np.where(occurs, end, 0.0)
    half = np.minimum(0.5 * MEAN_WINDOW, 0.5 * (end - start))
    for name, values in curves.items():
        inset = half if name == "mean_50ms" else 0.0 * half
        first = ((start + inset) / interval).astype(np.int64)
        last = np.maximum(np.ceil((end - inset) / interval).astype(np.int64), first + 1)
        peaks[name] = np.where(occurs, _largest(values, first, last), np.nan)
    return peaks


def _largest(values: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return the largest value of each row from `first` to before `last`."""
    n, size = values.shape
    ends = (np.stack([first, np.minimum(last, size)], axis=1) + size * np.arange(n)[:, None]).ravel()
    return np.maximum.reduceat(values.ravel(), ends[:-1] if ends[-1] == values.size else ends)[::2]
