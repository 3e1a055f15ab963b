"""The values that a key takes, read as the scene would read them: with its units, bounds and messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tailslap.errors import InputError
from tailslap.sweeps.values import Choices, Span

Read = Callable[[str], tuple[Any, str]]
"""From a value's text to the value that the scene has then, in SI or a word, and its unit. Raises InputError."""


@dataclass(frozen=True)
class Variation:
    """A key's values, as the scene has them: in SI, words, or tuples.

    In a grid each value is combined with those of the other keys; of samples the i-th belongs to run i.
    """

    key: str
    unit: str
    settings: tuple[Any, ...]
    logarithmic: bool

    @property
    def values(self) -> tuple[float | int | str, ...]:
        """The values as numbers and words."""
        return tuple(map(plain, self.settings))

    @property
    def numeric(self) -> bool:
        """Whether the values are numbers."""
        return all(isinstance(value, int | float) for value in self.settings)


def plain(value: Any) -> float | int | str:
    """A number or a word for a value: of a tuple, its members."""
    return value if isinstance(value, int | float | str) else " x ".join(map(str, value))


def grid_variation(key: str, given: Span | Choices, read: Read) -> Variation:
    """All values of a list, or those of a range: both ends, and the others evenly or in equal ratios between."""
    if isinstance(given, Choices):
        values, units = zip(*map(read, given.texts), strict=True)
        return Variation(key, units[0], values, False)
    (lower, upper), unit = _ends(key, given, read)
    assert given.count is not None
    space = np.geomspace if given.logarithmic else np.linspace
    between = space(lower, upper, given.count).tolist()
    if isinstance(lower, int) and isinstance(upper, int):
        between = _whole(key, given, between)
    return Variation(key, unit, tuple(between), given.logarithmic)


def sample_variation(key: str, given: Span | Choices, read: Read, shares: np.ndarray) -> Variation:
    """A value for each run, from its share of the range or list, shape (runs,), each in [0, 1)."""
    if isinstance(given, Choices):
        listed = grid_variation(key, given, read)
        chosen = (listed.settings[int(share * len(listed.settings))] for share in shares)
        return replace(listed, settings=tuple(chosen))
    (lower, upper), unit = _ends(key, given, read)
    if isinstance(lower, int):
        raise InputError(
            key, f"{given.lower}:{given.upper}", "whole numbers are sampled from a list v1,v2,v3"
        )
    between = lower * (upper / lower) ** shares if given.logarithmic else lower + (upper - lower) * shares
    return Variation(key, unit, tuple(between.tolist()), given.logarithmic)


def _ends(key: str, given: Span, read: Read) -> tuple[tuple[Any, Any], str]:
    """Both ends in SI, and the unit."""
    (lower, unit), (upper, _) = read(given.lower), read(given.upper)
    shown = f"{given.lower}:{given.upper}"
    if not (isinstance(lower, int | float) and isinstance(upper, int | float)):
        raise InputError(key, shown, "a range is of numbers; allowed here is a list v1,v2,v3")
    if lower == upper:
        raise InputError(key, shown, "the two ends of a range must differ")
    if given.logarithmic and not min(lower, upper) > 0.0:
        raise InputError(key, shown, "both ends of a range in equal ratios must be above 0")
    return (lower, upper), unit


def _whole(key: str, given: Span, values: list[float]) -> list[int]:
    """The values of a key that takes whole numbers."""
    if any(value != round(value) for value in values):
        shown = f"{given.lower}:{given.upper}:{given.count}"
        raise InputError(key, shown, f"not all of its values are whole numbers, like {values[1]:g}")
    return [round(value) for value in values]
