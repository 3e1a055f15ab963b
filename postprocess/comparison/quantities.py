"""FE results beside the exact rigid-body solution and the paper's values.

They are compared at the tail-slap: t [s], v_gx [m/s], v_gy [m/s], omega [rad/s], slide [m]; v_gy is negative, towards
the wall.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


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


PAPER_SOURCE = "B. Chuong and R. B. Malla, Infrastructures 2025, 10(11), 307, Table 3"

# The paper prints the magnitude of v_GY; here it is negative, towards the wall.
PAPER_TABLE_3: Mapping[str, Mapping[str, float]] = {
    "analytical": {"t": 0.383, "v_gx": 23.270, "v_gy": -3.274, "omega": 0.65, "slide": 9.420},
    "abaqus": {"t": 0.37, "v_gx": 23.305, "v_gy": -3.289, "omega": 0.66, "slide": 8.915},
}

QUANTITIES = by_key(
    ComparedQuantity("t", "Time to the tail-slap", "t", "s"),
    ComparedQuantity("v_gx", "Velocity of G along the wall", "v_GX", "m/s"),
    ComparedQuantity("v_gy", "Velocity of G across the wall", "v_GY", "m/s"),
    ComparedQuantity("omega", "Angular velocity", "ω", "rad/s"),
    ComparedQuantity("slide", "Slide of the corner along the wall", "s", "m"),
)
KEYS = tuple(QUANTITIES)

FORCE = by_key(ComparedQuantity("peak_force", "Peak lateral force", "F", "N"))
TAIL_SLAP = Compared(FORCE | QUANTITIES, "peak_force", "at the tail-slap")
"""Quantities of the constrained corner: the force of Stage 3, and the five that determine it."""

OF_STRIKES = by_key(
    ComparedQuantity("strike_1.mean_50ms", "First strike's peak, 50 ms mean", "F₁, 50 ms", "N"),
    ComparedQuantity("strike_1.impulse", "First strike's impulse", "J₁", "N s"),
    ComparedQuantity("strike_2.mean_50ms", "Second strike's peak, 50 ms mean", "F₂, 50 ms", "N"),
    ComparedQuantity("strike_2.impulse", "Second strike's impulse", "J₂", "N s"),
    ComparedQuantity("strike_2.duration", "Second strike's duration", "Δt₂", "s"),
)
STRIKES = Compared(OF_STRIKES, "strike_2.mean_50ms", "of both strikes")
"""Quantities of a whole impact."""

LARGEST = by_key(
    ComparedQuantity("peaks.mean_50ms", "Largest 50 ms mean of the lateral force", "F, 50 ms", "N")
)
IN_SPACE = Compared(LARGEST, "peaks.mean_50ms", "in space")
"""Quantities of a whole impact in space alone."""


def relative_difference(
    fe: Mapping[str, float], rigid: Mapping[str, float], keys: Sequence[str] = KEYS
) -> dict[str, float]:
    """Return fe/rigid - 1 for each key, dimensionless.

    Where the rigid value is zero, the difference is 0 if the FE value is zero as well, and infinite if not. An
    infinite difference exceeds every limit.
    """
    return {key: _relative(float(fe[key]), float(rigid[key])) for key in keys}


def largest(differences: Mapping[str, float]) -> float:
    """Return the size of the largest difference.

    It is NaN without differences, or if one is not finite.
    """
    sizes = [abs(value) for value in differences.values()]
    return max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan


def largest_relative(values: Mapping[str, float], reference: Mapping[str, float]) -> float:
    """Return the size of the largest relative difference.

    Of the five quantities; NaN without results, or if one is not finite.
    """
    return largest(relative_difference(values, reference)) if values and reference else math.nan


def comparison_rows(
    fe: Mapping[str, float], rigid: Mapping[str, float], has_paper: bool = False
) -> list[dict[str, Any]]:
    """Return the rows of the comparison table, SI.

    Each has quantity, fe, rigid and difference, fe/rigid - 1; with has_paper also the values of the paper.
    """
    difference, columns = relative_difference(fe, rigid), PAPER_TABLE_3 if has_paper else {}
    return [
        {
            "quantity": quantity,
            "fe": float(fe[key]),
            "rigid": float(rigid[key]),
            "difference": difference[key],
        }
        | {f"paper_{name}": values[key] for name, values in columns.items()}
        for key, quantity in QUANTITIES.items()
    ]


def _relative(fe: float, rigid: float) -> float:
    if rigid != 0.0:
        return fe / rigid - 1.0
    return 0.0 if fe == 0.0 else math.copysign(math.inf, fe)
