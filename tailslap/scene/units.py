"""Quantities of a scene: plain numbers are SI, strings carry their unit."""

from __future__ import annotations

import functools
import math
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import platformdirs

NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)?")


@functools.cache
def registry() -> Any:
    """Pint's units; read from its cache on disk where there can be one, for the parsing takes 0.1 s."""
    with _hidden("dask"):
        import pint

    try:
        return pint.UnitRegistry(cache_folder=str(platformdirs.user_cache_path("tailslap") / "units"))
    except OSError:
        return pint.UnitRegistry()


@contextmanager
def _hidden(module: str) -> Iterator[None]:
    """Import as if this module were not there: Pint loads Dask where it finds it, in a quarter of a second."""
    if module in sys.modules:
        yield
        return
    sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[module]


@dataclass(frozen=True)
class Quantity:
    """Marks a number of a scene: what it is, its SI unit, its bounds. Used as `Annotated[float, Quantity(...)]`.

    The bounds above and below are not reached, least and most may be. unit "" is a plain number.
    """

    what: str
    unit: str
    example: str
    above: float = -math.inf
    least: float = -math.inf
    below: float = math.inf
    most: float = math.inf

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self.parse)

    def parse(self, given: object) -> float:
        """The value in SI; ValueError, saying what is allowed, for anything else."""
        value = self._from_text(given) if isinstance(given, str) else self._from_number(given)
        inside = self.above < value < self.below and self.least <= value <= self.most
        if not (math.isfinite(value) and inside):
            raise ValueError(self.allowed)
        return value

    @property
    def allowed(self) -> str:
        """What is allowed, in words."""
        limits = [
            f"{word} {self._limit(bound)}"
            for word, bound in (
                ("above", self.above),
                ("at least", self.least),
                ("below", self.below),
                ("at most", self.most),
            )
            if math.isfinite(bound)
        ]
        number = f"a number in {self.unit} or a string with its unit" if self.unit else "a plain number"
        return f"allowed is {self.what} {' and '.join(limits)}, {number}, like {self.example}".replace(
            " ,", ","
        )

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
        match = NUMBER.fullmatch(given)
        if not match or bool(match[2]) != bool(self.unit):
            raise ValueError(self.allowed)
        if not self.unit:
            return float(match[1])
        try:
            unit = registry().parse_units(match[2])
            # Roots keep radians apart: to Pint a hertz is a radian a second, and a radian is nothing.
            if registry().get_root_units(unit)[1] != registry().get_root_units(self.unit)[1]:
                raise ValueError
            return float(registry().Quantity(float(match[1]), unit).to(self.unit).magnitude)
        except Exception:  # Pint and the tokenizer under it raise a dozen kinds for text that is no unit
            raise ValueError(f"{self.allowed} (the unit does not fit)") from None
