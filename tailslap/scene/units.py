"""Quantities of a scene: plain numbers are SI, strings carry their unit."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass
from typing import Any

import platformdirs

from fem.unseen import unseen
from tailslap.scene.common_units import to_si
from tailslap.scene.unit_grammar import unit_factors

NUMBER = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(\S.*?)?\s*", re.DOTALL)
MAX_TEXT = 200
"""Characters of a number with its unit."""


@functools.cache
def registry() -> Any:
    """Pint's units; read from its cache on disk where there can be one, for the parsing takes 0.1 s."""
    with unseen("dask"):  # Pint loads Dask where it finds it, in a quarter of a second
        import pint

    try:
        return pint.UnitRegistry(cache_folder=str(platformdirs.user_cache_path("tailslap") / "units"))
    except OSError:
        return pint.UnitRegistry()


@dataclass(frozen=True)
class Quantity:
    """Marks a number of a scene: what it is, its SI unit, its bounds. Used as `Annotated[float, Quantity(...)]`.

    The bound below is not reached, least and most may be. unit "" is a plain number.
    """

    what: str
    unit: str
    example: str
    least: float
    below: float = math.inf
    most: float = math.inf

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self.parse)

    def parse(self, given: object) -> float:
        """The value in SI; ValueError, saying what is allowed, for anything else."""
        value = self._from_text(given) if isinstance(given, str) else self._from_number(given)
        if not (self.least <= value <= self.most and value < self.below):
            raise ValueError(self.allowed)
        return value

    @property
    def allowed(self) -> str:
        """What is allowed, in words."""
        least, most = self._limit(self.least), self._limit(min(self.most, self.below))
        limits = f"from {least} to {most}" if self.most < self.below else f"at least {least} and below {most}"
        number = f"a number in {self.unit} or a string with its unit" if self.unit else "a plain number"
        return f"allowed is {self.what} {limits}, {number}, like {self.example}"

    def _limit(self, bound: float) -> str:
        if self.unit == "rad":
            return f"{math.degrees(bound):g} deg"
        return f"{bound:g} {self.unit}".strip()

    def _from_number(self, given: object) -> float:
        if isinstance(given, bool) or not isinstance(given, int | float):
            raise ValueError(self.allowed)
        try:
            return float(given)
        except OverflowError:
            raise ValueError(self.allowed) from None

    def _from_text(self, given: str) -> float:
        match = NUMBER.fullmatch(given) if len(given) <= MAX_TEXT else None
        if not (self.unit and match and match[2]):
            raise ValueError(self.allowed)
        try:
            return converted(float(match[1]), match[2], self.unit)
        except Exception:  # Pint raises half a dozen kinds for names that are no units
            raise ValueError(f"{self.allowed} (the unit does not fit)") from None


def converted(value: float, given: str, unit: str) -> float:
    """The value in another unit of the same dimension; raises ValueError, or what Pint raises, where it has none."""
    source, target = to_si(unit_factors(given)), to_si(unit_factors(unit))
    if source is None or target is None:
        return _converted_by_pint(value, given, unit)
    if source[1] != target[1]:
        raise ValueError("another dimension")
    return value * (source[0] / target[0])


def _converted_by_pint(value: float, given: str, unit: str) -> float:
    units, product = registry(), 1
    for factor in unit_factors(given):
        product = product * units.parse_units(factor.name) ** factor.power
    # Roots keep radians apart: to Pint a hertz is a radian a second, and a radian is nothing.
    if units.get_root_units(product)[1] != units.get_root_units(unit)[1]:
        raise ValueError("another dimension")
    return float(units.Quantity(value, product).to(unit).magnitude)
