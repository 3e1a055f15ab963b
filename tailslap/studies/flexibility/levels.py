"""Down to which first frequency a difference stays below a level, and whether it is a power of the frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SHARE = 1.0 / 3.0
"""Share of a level, or of a difference, that the numerical error must stay below for either to be known; a difference
that is below the level with its error on top is known to be."""

CROSSED, NOT_REACHED, ABOVE_ALL, UNKNOWN = KINDS = ("crossed", "not reached", "above all", "unknown")
"""The level is crossed; not within the points that passed; by all of them; the error is too large to say."""

STRAIGHT = 0.1
"""Relative distance from the fitted power law up to which points are said to follow it."""

MIN_FITTED = 4


@dataclass(frozen=True)
class Sample:
    """A point: first frequency [Hz], size of the difference, numerical error, whether its checks passed."""

    frequency: float
    difference: float
    error: float
    passed: bool


@dataclass(frozen=True)
class Level:
    """What is known of a level. frequency [Hz]: where it is crossed; the softest good point if it is not reached; the
    stiffest point if all are above; the stiffest point that is not known, NaN without any that passed."""

    level: float
    kind: str
    frequency: float

    @property
    def text(self) -> str:
        """The lowest first frequency as people read it; <: good down to there at least, >: not even there."""
        sign = {CROSSED: "", NOT_REACHED: "<\N{NO-BREAK SPACE}", ABOVE_ALL: ">\N{NO-BREAK SPACE}"}.get(
            self.kind
        )
        return "not known" if sign is None else sign + hertz(self.frequency)


@dataclass(frozen=True)
class PowerLaw:
    """difference = factor * frequency ** exponent, frequencies in Hz, from `highest` down to `lowest`."""

    exponent: float
    factor: float
    highest: float
    lowest: float


def hertz(frequency: float) -> str:
    """A frequency [Hz] with its unit, which a line does not break off."""
    if not math.isfinite(frequency):
        return "–"
    number, unit = (frequency / 1e3, "kHz") if frequency >= 999.5 else (frequency, "Hz")
    return f"{number:.3g}\N{NO-BREAK SPACE}{unit}"


def lowest_frequency(samples: Sequence[Sample], level: float) -> Level:
    """Down to which first frequency the difference is at most the level; samples from stiff to soft.

    Between two points that passed, next to each other, differences and errors follow powers of the frequency.
    """
    last: int | None = None
    for number, sample in enumerate(samples):
        if not sample.passed:
            continue
        if not math.isfinite(sample.error):
            return Level(level, UNKNOWN, sample.frequency)
        if sample.difference > level:
            return _crossing(samples, last, number, level)
        if not (sample.error < SHARE * level or sample.difference + sample.error <= level):
            return Level(level, UNKNOWN, sample.frequency)
        last = number
    if last is None:
        return Level(level, UNKNOWN, math.nan)
    return Level(level, NOT_REACHED, samples[last].frequency)


def jointly(levels: Sequence[Level]) -> Level:
    """What holds for each of several series of points, given what is known of the same level in each."""
    for kind in (ABOVE_ALL, UNKNOWN):
        found = [level.frequency for level in levels if level.kind == kind]
        if found:
            return Level(levels[0].level, kind, max(filter(math.isfinite, found), default=math.nan))
    highest = max(levels, key=lambda level: (level.frequency, level.kind == CROSSED))
    return Level(highest.level, highest.kind, highest.frequency)


def _crossing(samples: Sequence[Sample], last: int | None, number: int, level: float) -> Level:
    """The level between the last point below it, if any, and this one above it."""
    soft = samples[number]
    if last is None:
        known = soft.error < SHARE * soft.difference
        return Level(level, ABOVE_ALL if known else UNKNOWN, soft.frequency)
    stiff = samples[last]
    share = _share(stiff.difference, soft.difference, level)
    frequency = stiff.frequency * (soft.frequency / stiff.frequency) ** share
    error = _floor(stiff.error) ** (1.0 - share) * _floor(soft.error) ** share
    known = number == last + 1 and error < SHARE * level
    return Level(level, CROSSED if known else UNKNOWN, frequency if known else soft.frequency)


def _share(low: float, high: float, level: float) -> float:
    """How far between low and high the level lies, on a logarithmic scale."""
    return math.log(level / _floor(low)) / math.log(high / _floor(low))


def _floor(value: float) -> float:
    """The value, or rounding where it is less: the logarithm of nothing is none."""
    return max(value, float(np.finfo(float).eps))


def power_law(samples: Sequence[Sample]) -> PowerLaw | None:
    """The law that most points from the stiff end on follow; None where no four do. samples from stiff to soft."""
    known = [s for s in samples if s.passed and s.error < SHARE * s.difference]
    for count in range(len(known), MIN_FITTED - 1, -1):
        x, y = (np.log([getattr(s, name) for s in known[:count]]) for name in ("frequency", "difference"))
        exponent, offset = np.polyfit(x, y, 1)
        if np.abs(np.expm1(y - exponent * x - offset)).max() <= STRAIGHT:
            ends = (known[0].frequency, known[count - 1].frequency)
            return PowerLaw(float(exponent), math.exp(offset), *ends)
    return None
