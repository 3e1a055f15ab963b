"""Records of compared quantities."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class ComparedQuantity:
    """Compared quantity with its key, title, symbol and SI unit."""

    key: str
    title: str
    symbol: str
    unit: str

    @property
    def label(self) -> str:
        """Symbol with unit."""
        return f"{self.symbol} [{self.unit}]"


@dataclass(frozen=True)
class Compared:
    """Quantities compared between FE and rigid vehicle.

    mapped: the one that a map shows; where: instant of both.
    """

    quantities: Mapping[str, ComparedQuantity]
    mapped: str
    where: str


def by_key(*quantities: ComparedQuantity) -> dict[str, ComparedQuantity]:
    """Return the quantities by their keys."""
    return {quantity.key: quantity for quantity in quantities}
