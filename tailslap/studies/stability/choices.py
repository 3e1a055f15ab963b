"""The choices of a random cell, which its machine code depends on: drawn together, as one of COMBINATIONS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

COMBINATIONS = 97
"""Combinations of choices in a campaign: nearly any two choices meet in one of them. Prime, so that what goes by the
number of a cell, like its start, is not the same in all cells of a combination."""

ELEMENTS = ("quad4", "quad4-reduced", "quad9", "tri3", "tri6")
OPEN = 0.3
"""Share of the cells that leave a choice to the program."""


class Dice:
    """Random numbers of one draw."""

    def __init__(self, *seeds: int) -> None:
        self._random = np.random.default_rng(seeds)

    def even(self, low: float, high: float) -> float:
        return float(self._random.uniform(low, high))

    def ratio(self, low: float, high: float) -> float:
        return math.exp(self.even(math.log(low), math.log(high)))

    def happens(self, share: float) -> bool:
        return self.even(0.0, 1.0) < share

    def one_of(self, values: Sequence[str], shares: Sequence[float] | None = None) -> str:
        return values[int(self._random.choice(len(values), p=shares))]


@dataclass(frozen=True)
class Choices:
    """What the machine code of a run depends on; "open" is left to the program."""

    reaction: str
    frictionless: bool
    element: str
    row_sum: bool
    distorted: bool
    constraint: str
    patch: bool
    damping: str
    neo_hookean: bool


def choices_of(seed: int, combination: int, attempt: int) -> Choices:
    """The choices of a combination; attempt: counts those before it that were not possible."""
    dice = Dice(seed, combination, attempt)
    return Choices(
        reaction=dice.one_of(("drag", "none", "signed"), (0.6, 0.2, 0.2)),
        frictionless=dice.happens(0.1),
        element="open" if dice.happens(OPEN) else dice.one_of(ELEMENTS),
        row_sum=dice.happens(0.1),
        distorted=dice.happens(0.3),
        constraint=dice.one_of(("open", "penalty", "exact", "dashpot"), (0.4, 0.2, 0.2, 0.2)),
        patch=dice.happens(0.5),
        damping=dice.one_of(("open", "ratio", "bulk", "none"), (0.6, 0.15, 0.1, 0.15)),
        neo_hookean=dice.happens(0.5),
    )
