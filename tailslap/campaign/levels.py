"""Down to which frequency a difference stays below a level, and whether it is a power of the frequency."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from postprocess.units import rounded_up
from tailslap.errors import InputError
from tailslap.scene.units import Quantity
from tailslap.scene.vary import parse_value

# Values of --lowest and --highest.
HERTZ = Quantity("a frequency", "Hz", '"8 Hz"', least=0.01, most=1e5)

# Fraction of a level, or of a difference, that the numerical error must stay below for either to be known.
KNOWN_FRACTION = 1.0 / 3.0

# The level is crossed; not within the points that passed; by all of them; the error is too large to say.
CROSSED, NOT_REACHED, ABOVE_ALL, UNKNOWN = "crossed", "not reached", "above all", "unknown"

# Relative distance from the fitted power law up to which points are said to follow it, and so many at least.
STRAIGHT, MIN_FITTED = 0.1, 4


class Sample(NamedTuple):
    """A plate: first frequency [Hz], size of the difference, numerical error, whether its checks passed."""

    frequency: float
    difference: float
    error: float
    passed: bool

    @property
    def bound(self) -> float:
        """The difference with its error on top."""
        return self.difference + self.error


@dataclass(frozen=True)
class Reach:
    """Knowledge of a level. frequency [Hz]: where it is crossed, with the error on top; the softest good plate if it is
    not reached; the stiffest if all are above; the stiffest that is not known, NaN without any that passed."""

    level: float
    kind: str
    frequency: float

    @property
    def text(self) -> str:
        """The lowest first frequency as people read it, two digits rounded to the safe side; <: good down to there at
        least, >: not even there."""
        signs = {
            CROSSED: "≈\N{NO-BREAK SPACE}",
            NOT_REACHED: "<\N{NO-BREAK SPACE}",
            ABOVE_ALL: ">\N{NO-BREAK SPACE}",
        }
        return signs[self.kind] + hertz(rounded_up(self.frequency)) if self.kind in signs else "unknown"


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


def frequencies(lowest: str, highest: str, points: int) -> tuple[float, ...]:
    """First frequencies [Hz] from the highest to the lowest, at even ratios. Raises InputError."""
    ends = []
    for option, given in (("--lowest", lowest), ("--highest", highest)):
        try:
            ends.append(HERTZ.parse(parse_value(given)))
        except ValueError as error:
            raise InputError(option, given, str(error)) from None
    if not ends[0] < ends[1]:
        raise InputError("--lowest", lowest, f'it must be below --highest, "{highest}"')
    return tuple(np.geomspace(ends[1], ends[0], points).tolist())


def reaches(samples: Sequence[Sample], levels: Sequence[float]) -> tuple[Reach, ...]:
    """The lowest frequency for each level; samples from stiff to soft."""
    return tuple(lowest_frequency(samples, level) for level in levels)


def lowest_frequency(samples: Sequence[Sample], level: float) -> Reach:
    """Down to which first frequency the difference is at most the level; samples from stiff to soft.

    Between two points that passed, next to each other, differences and errors follow powers of the frequency; the level
    is crossed by the difference with its error on top.
    """
    last: int | None = None
    for number, sample in enumerate(samples):
        if not sample.passed:
            continue
        if not math.isfinite(sample.error):
            return Reach(level, UNKNOWN, sample.frequency)
        if sample.bound > level:
            return _crossing(samples, last, number, level)
        last = number
    if last is None:
        return Reach(level, UNKNOWN, math.nan)
    return Reach(level, NOT_REACHED, samples[last].frequency)


def _crossing(samples: Sequence[Sample], last: int | None, number: int, level: float) -> Reach:
    """The level between the last point below it, if any, and this one above it."""
    soft, floor = samples[number], float(np.finfo(float).eps)
    if last is None:
        known = soft.error < KNOWN_FRACTION * soft.difference
        return Reach(level, ABOVE_ALL if known else UNKNOWN, soft.frequency)
    stiff = samples[last]
    low = max(stiff.bound, floor)  # the logarithm of nothing is none
    part = math.log(level / low) / math.log(soft.bound / low)
    error = max(stiff.error, floor) ** (1.0 - part) * max(soft.error, floor) ** part
    if number != last + 1 or not error < KNOWN_FRACTION * level:
        return Reach(level, UNKNOWN, soft.frequency)
    return Reach(level, CROSSED, stiff.frequency * (soft.frequency / stiff.frequency) ** part)


def jointly(levels: Sequence[Reach]) -> Reach:
    """Level that holds for each of several series of points, by what is known of it in each."""
    for kind in (ABOVE_ALL, UNKNOWN):
        found = [level.frequency for level in levels if level.kind == kind]
        if found:
            return Reach(levels[0].level, kind, max(filter(math.isfinite, found), default=math.nan))
    return max(levels, key=lambda level: (level.frequency, level.kind == CROSSED))


def power_law(samples: Sequence[Sample]) -> PowerLaw | None:
    """The law that most points from the stiff end on follow; None where no four do. samples from stiff to soft."""
    known = [s for s in samples if s.passed and s.error < KNOWN_FRACTION * s.difference]
    for count in range(len(known), MIN_FITTED - 1, -1):
        x, y = (np.log([getattr(s, name) for s in known[:count]]) for name in ("frequency", "difference"))
        exponent, offset = np.polyfit(x, y, 1)
        if np.abs(np.expm1(y - exponent * x - offset)).max() <= STRAIGHT:
            ends = (known[0].frequency, known[count - 1].frequency)
            return PowerLaw(float(exponent), math.exp(offset), *ends)
    return None
