"""Convert quantities of a scene to SI.

Plain numbers are SI, strings carry their unit. A unit is a product of names, each with an integer power of up to 9:

    unit    = first { join factor }        first = factor | "1" join factor
    join    = "*" | "/" | blank            factor = name [ ("^" | "**") [ "-" ] digit ]

Pound, foot and pound-force are those of the international agreement of 1959 and of standard gravity.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from postprocess.units import FOOT, INCH, KIP, MPH, POUND, SYSTEMS
from tailslap.errors import nearest

if TYPE_CHECKING:
    from pydantic_core.core_schema import CoreSchema, ValidationInfo

COMMA = "the decimal separator is a point, not a comma"

Dimension = tuple[int, int, int, int]
"""Powers of metre, kilogram, second and radian."""

LENGTHS = {"m": 1.0, "mm": 0.001, "cm": 0.01, "km": 1000.0}
LENGTHS |= {"in": INCH, "ft": FOOT, "yd": 0.9144, "mi": 5280.0 * FOOT}
MASSES = {"kg": 1.0, "g": 0.001, "t": 1000.0, "lb": POUND, "klb": 1e3 * POUND, "slug": 1e-3 * KIP / FOOT}
TIMES = {"s": 1.0, "us": 1e-6, "ms": 0.001, "min": 60.0, "h": 3600.0}
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "GN": 1e9, "lbf": 1e-3 * KIP, "kip": KIP}
PRESSURES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "bar": 1e5}
PRESSURES |= {"psf": 1e-3 * KIP / FOOT**2, "psi": 1e-3 * KIP / INCH**2, "ksi": KIP / INCH**2}
KINDS: tuple[tuple[Dimension, dict[str, float]], ...] = (
    ((1, 0, 0, 0), LENGTHS),
    ((0, 1, 0, 0), MASSES),
    ((0, 0, 1, 0), TIMES),
    ((0, 0, 0, 1), {"rad": 1.0, "deg": math.pi / 180.0}),
    ((1, 0, -1, 0), {"mph": MPH, "kph": 1.0 / 3.6}),
    ((1, 1, -2, 0), FORCES),
    ((-1, 1, -2, 0), PRESSURES),
    ((2, 1, -2, 0), {"J": 1.0, "kJ": 1e3}),
    ((0, 0, -1, 0), {"Hz": 1.0, "kHz": 1e3}),
)
UNITS = {name: (factor, dimension) for dimension, factors in KINDS for name, factor in factors.items()}
"""Factor to SI and dimension, by name."""

MAX_UNIT, MAX_TEXT = 80, 200
"""Characters of a unit, and of a number with its unit."""

NAME = r"[A-Za-zµμΩÅ°%][A-Za-zµμΩÅ°_]{0,39}"
FACTOR = re.compile(rf"({NAME})(?:\s*(?:\^|\*\*)\s*(-?[1-9]))?")
JOIN = re.compile(r"\s*([*/])\s*(?!\*)|\s+")
RECIPROCAL = re.compile(r"1\s*(?=/)")
NUMBER = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(\S.*?)?\s*", re.DOTALL)


def unit_factors(text: str) -> tuple[tuple[str, int], ...]:
    """Split a unit into its factors, each a name and its power.

    Powers are 1 to 9 and -9 to -1. Raises ValueError for text that is not a unit.
    """
    if len(text) > MAX_UNIT:
        raise ValueError("too long")
    at, factors, sign = 0, list[tuple[str, int]](), 1
    if match := RECIPROCAL.match(text):
        at, sign = _join(text, match.end())
    while True:
        match = FACTOR.match(text, at)
        if not match:
            raise ValueError("it is not the name of a unit")
        factors.append((match[1], sign * int(match[2] or 1)))
        if match.end() == len(text):
            return tuple(factors)
        at, sign = _join(text, match.end())


def _join(text: str, at: int) -> tuple[int, int]:
    """Return the start of the next factor and its sign.

    The sign is that of the power.
    """
    match = JOIN.match(text, at)
    if not match:
        raise ValueError("it is not a product of units")
    return match.end(), -1 if match[1] == "/" else 1


@lru_cache(1024)
def to_si(text: str) -> tuple[float, Dimension]:
    """Return the factor to SI and the dimension of a unit.

    Raises ValueError for an unknown name or other text.
    """
    scale, powers = 1.0, (0, 0, 0, 0)
    for name, power in unit_factors(text):
        if name not in UNITS:
            raise ValueError(f'"{name}" is unknown{nearest(name, UNITS)}; allowed are {", ".join(UNITS)}')
        factor, dimension = UNITS[name]
        scale = scale * factor**power if power > 0 else scale / factor**-power
        length, mass, time, angle = (total + power * p for total, p in zip(powers, dimension, strict=True))
        powers = (length, mass, time, angle)
    return scale, powers


def converted(value: float, source_unit: str, unit: str) -> float:
    """Convert a value to another unit of the same dimension.

    Raises ValueError for another dimension.
    """
    source, target = to_si(source_unit), to_si(unit)
    if source[1] != target[1]:
        raise ValueError(f"its dimension differs from that of {unit}")
    return value * (source[0] / target[0])


@dataclass(frozen=True)
class Quantity:
    """Number of a scene with its SI unit and bounds.

    Used as `Annotated[float, Quantity(...)]`. Bounds least and most are inclusive, below is exclusive. unit "" is a
    plain number.
    """

    what: str
    unit: str
    example: str
    least: float
    below: float = math.inf
    most: float = math.inf

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> "CoreSchema":
        from pydantic_core import core_schema

        return core_schema.with_info_plain_validator_function(self.validated)

    def validated(self, entry: object, info: "ValidationInfo") -> Any:
        """Return the value of a key, see `parse`.

        info: the keys of its table that come first.
        """
        return self.parse(entry)

    def parse(self, entry: object) -> float:
        """Return the value in SI.

        Raises ValueError, with the allowed range in the unit of the text.
        """
        value, unit = (
            self._from_text(entry) if isinstance(entry, str) else (self._from_number(entry), self.unit)
        )
        if not (self.least <= value <= self.most and value < self.below):
            raise ValueError(self.allowed(unit))
        return value

    def limits(self, unit: str = "") -> str:
        """Return the allowed range in a unit, as text.

        Bounds that are not round in it are rounded inwards to three digits.
        """
        unit = unit or ("deg" if self.unit == "rad" else self.unit)
        factor = converted(1.0, self.unit, unit) if unit != self.unit else 1.0
        bounds = (factor * self.least, math.ceil), (factor * min(self.most, self.below), math.floor)
        least, most = (f"{_rounded(bound, inwards):g} {unit}".strip() for bound, inwards in bounds)
        return (
            f"from {least} to {most}" if self.most < self.below else f"of at least {least} and below {most}"
        )

    def allowed(self, unit: str = "") -> str:
        """Describe the allowed values.

        unit: of their range.
        """
        number = f"a number in {self.unit} or a string with its unit" if self.unit else "a plain number"
        return f"allowed is {self.what} {self.limits(unit)}, {number}, like {self.example}"

    def _from_number(self, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(self.allowed())
        try:
            return float(value)
        except OverflowError:
            raise ValueError(self.allowed()) from None

    def _from_text(self, text: str) -> tuple[float, str]:
        match = NUMBER.fullmatch(text) if len(text) <= MAX_TEXT else None
        if not (self.unit and match and match[2]):
            raise ValueError(self.allowed())
        try:
            return converted(float(match[1]), match[2], self.unit), match[2]
        except (ValueError, OverflowError) as error:
            why = COMMA if match[2].startswith(",") else f"the unit does not fit: {error}"
            raise ValueError(f"{self.allowed()} ({why})") from None


@dataclass(frozen=True)
class OfStrip(Quantity):
    """Number of a strip per length, and another quantity of a point.

    of_point: that quantity, of a strip that is a point in the plane.
    """

    of_point: Quantity = None  # type: ignore[assignment]  # fields with defaults precede it

    def validated(self, entry: object, info: "ValidationInfo") -> float:
        """Return the value in SI, see `parse`."""
        at = info.data.get("at", (0.0, 0.0))
        is_point = info.data.get("height") is None and at[0] == at[1]
        return (self.of_point if is_point else self).parse(entry)


@dataclass(frozen=True)
class Pair(Quantity):
    """Two numbers of a scene, or one that stands for both."""

    def validated(self, entry: object, info: "ValidationInfo") -> tuple[float, float]:
        """Return both values in SI.

        Raises ValueError, see `parse`, and for another number of values.
        """
        values = entry if isinstance(entry, list | tuple) else (entry, entry)
        if len(values) != 2:
            raise ValueError(f"allowed is {self.what}, or a list of two")
        return self.parse(values[0]), self.parse(values[1])


@dataclass(frozen=True)
class Levels(Quantity):
    """Number of a scene, or pairs of heights and numbers."""

    def validated(self, entry: object, info: "ValidationInfo") -> tuple[tuple[float, float], ...]:
        """Return heights [m] and values in SI.

        A single value is at height 0. Raises ValueError, see `parse`, and for other pairs.
        """
        if not isinstance(entry, list | tuple):
            return ((0.0, self.parse(entry)),)
        allowed = f"allowed is {self.what}, or a list of pairs [height, value] of rising heights from 0"
        if not all(isinstance(pair, list | tuple) and len(pair) == 2 for pair in entry):
            raise ValueError(allowed)
        height = Quantity("a height above the base", "m", '"0.2 m"', least=0.0, most=20.0)
        pairs = tuple((height.parse(at), self.parse(value)) for at, value in entry)
        if not pairs or pairs[0][0] != 0.0 or any(b <= a for (a, _), (b, _) in pairwise(pairs)):
            raise ValueError(allowed)
        return pairs


def _rounded(bound: float, inwards: Callable[[float], int]) -> float:
    """Round a bound inwards to three digits unless six digits are exact."""
    if float(f"{bound:g}") == bound:
        return bound
    step = 10.0 ** (math.floor(math.log10(abs(bound))) - 2)
    return inwards(round(bound / step, 6)) * step


def value_line(name: str, value: float, unit: str, system: str, digits: int = 7) -> str:
    """Return a line of a list of values, converted from SI."""
    return f"  {name:<18}{shown(value, unit, system, width=14, digits=digits)}"


def shown(value: float, unit: str, system: str = "si", width: int = 0, digits: int = 7) -> str:
    """Return the text of a value in a system of units.

    The value is in the SI unit. Digits are right-aligned in `width` columns. US speeds are in mph too.
    """
    factor, name = SYSTEMS[system].of(unit)
    also = f" ({value / MPH:.{digits}g} mph)" if (system, unit) == ("us", "m/s") else ""
    return f"{factor * value:>{width}.{digits}g} {name}{also}"
