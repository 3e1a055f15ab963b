"""Lowest frequency at which a difference remains below a level."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from postprocess.units import rounded_up
from tailslap.errors import InputError
from tailslap.scene.units import Quantity
from tailslap.scene.vary import parse_value

HERTZ = Quantity("a frequency", "Hz", '"8 Hz"', least=0.01, most=1e5)
"""Values of --lowest and --highest."""

KNOWN_FRACTION = 1.0 / 3.0
"""Fraction of a level, or of a difference, that the numerical error must not exceed for either to be known."""

CROSSED, NOT_REACHED, ABOVE_ALL, UNKNOWN = "crossed", "not reached", "above all", "unknown"
"""Kinds of results: crossed between two points, not reached, exceeded by all points, or unknown because of the error.
"""


class Sample(NamedTuple):
    """First frequency [Hz], difference, error and checks of a plate."""

    frequency: float
    difference: float
    error: float
    passed: bool

    @property
    def bound(self) -> float:
        """Return the difference plus its error."""
        return self.difference + self.error


@dataclass(frozen=True)
class Reach:
    """Lowest frequency of a level.

    The frequency [Hz] is that of the crossing, where the difference plus its error equals the level. It is that of the
    softest plate that passed where the level is not reached, and of the stiffest where all exceed it. Where it is
    unknown, it is that of the softest plate known to be below the level; NaN without one.
    """

    level: float
    kind: str
    frequency: float

    @property
    def text(self) -> str:
        """Return the frequency, rounded to the safe side.

        A sign < means accurate down to this frequency at least, > inaccurate at this frequency.
        """
        if math.isnan(self.frequency):
            return "unknown"
        sign = {CROSSED: "≈", ABOVE_ALL: ">"}.get(self.kind, "<")
        return f"{sign}\N{NO-BREAK SPACE}{hertz(rounded_up(self.frequency))}"


def hertz(frequency: float) -> str:
    """Format a frequency [Hz] without line break."""
    if not math.isfinite(frequency):
        return "–"
    number, unit = (frequency / 1e3, "kHz") if frequency >= 999.5 else (frequency, "Hz")
    return f"{number:.3g}\N{NO-BREAK SPACE}{unit}"


def frequencies(lowest: str, highest: str, points: int) -> tuple[float, ...]:
    """Return falling first frequencies [Hz] in equal ratios.

    Raises InputError for invalid ends.
    """
    ends = []
    for option, text in (("--lowest", lowest), ("--highest", highest)):
        try:
            ends.append(HERTZ.parse(parse_value(text)))
        except ValueError as error:
            raise InputError(option, text, str(error)) from None
    if not ends[0] < ends[1]:
        raise InputError("--lowest", lowest, f'it must be below --highest, "{highest}"')
    return tuple(np.geomspace(ends[1], ends[0], points).tolist())


def reaches(samples: Sequence[Sample], levels: Sequence[float]) -> tuple[Reach, ...]:
    """Return the lowest frequency of each level.

    Samples are ordered from stiff to soft.
    """
    return tuple(lowest_frequency(samples, level) for level in levels)


def lowest_frequency(samples: Sequence[Sample], level: float) -> Reach:
    """Return the lowest first frequency of a level.

    The difference is at most the level above it. Between two adjacent points that passed, differences and errors follow
    powers of the frequency. The level is crossed by the difference plus its error. Samples are ordered from stiff to
    soft.
    """
    last: int | None = None
    for number, sample in enumerate(samples):
        if not sample.passed:
            continue
        if not math.isfinite(sample.error):
            return _unknown(samples, last, level)
        if sample.bound > level:
            return _crossing(samples, last, number, level)
        last = number
    if last is None:
        return _unknown(samples, last, level)
    return Reach(level, NOT_REACHED, samples[last].frequency)


def _unknown(samples: Sequence[Sample], last: int | None, level: float) -> Reach:
    """Return an unknown level below the last point below it, if any."""
    return Reach(level, UNKNOWN, math.nan if last is None else samples[last].frequency)


def _crossing(samples: Sequence[Sample], last: int | None, number: int, level: float) -> Reach:
    """Return the crossing of the level between two points.

    The first is the last point below the level, if any, and the second is the first point above it.
    """
    soft, floor = samples[number], float(np.finfo(float).eps)
    if last is None:
        is_known = soft.error < KNOWN_FRACTION * soft.difference
        return Reach(level, ABOVE_ALL, soft.frequency) if is_known else _unknown(samples, last, level)
    stiff = samples[last]
    low = max(stiff.bound, floor)  # a positive number for the logarithm
    part = math.log(level / low) / math.log(soft.bound / low)
    error = max(stiff.error, floor) ** (1.0 - part) * max(soft.error, floor) ** part
    if number != last + 1 or not error < KNOWN_FRACTION * level:
        return _unknown(samples, last, level)
    return Reach(level, CROSSED, stiff.frequency * (soft.frequency / stiff.frequency) ** part)


def jointly(levels: Sequence[Reach]) -> Reach:
    """Return the level that holds for several series.

    It is unknown only where no other series has a crossing at a higher frequency.
    """

    def priority(level: Reach) -> tuple[bool, float, bool]:
        frequency = math.inf if math.isnan(level.frequency) else level.frequency
        return level.kind == ABOVE_ALL, frequency, level.kind == CROSSED

    return max(levels, key=priority)
