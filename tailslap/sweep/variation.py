"""The values that a key takes, read as the scene would read them: with its units, bounds and messages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tailslap.errors import InputError
from tailslap.scene.inputs import SceneInput
from tailslap.sweep.values import Choices, Span

Read = Callable[[str], SceneInput]
"""From a value's text to the key's row in the scene's table of inputs. Raises InputError."""


@dataclass(frozen=True)
class Variation:
    """A key's values: `texts` as they stand in a scene, `values` in SI or words, one for each text.

    In a grid each value is combined with those of the other keys; of samples the i-th belongs to run i.
    """

    key: str
    unit: str
    texts: tuple[str, ...]
    values: tuple[float | int | str, ...]
    logarithmic: bool

    @property
    def numeric(self) -> bool:
        """Whether the values are numbers."""
        return all(isinstance(value, int | float) for value in self.values)


def grid_variation(key: str, given: Span | Choices, read: Read) -> Variation:
    """All values of a list, or those of a range: both ends, and the others evenly or in equal ratios between."""
    if isinstance(given, Choices):
        rows = [read(text) for text in given.texts]
        return Variation(key, rows[0].unit, given.texts, tuple(_plain(row.value) for row in rows), False)
    (lower, upper), unit = _ends(key, given, read)
    assert given.count is not None
    space = np.geomspace if given.logarithmic else np.linspace
    values = space(lower, upper, given.count).tolist()
    if isinstance(lower, int) and isinstance(upper, int):
        values = _whole(key, given, values)
    return Variation(key, unit, tuple(map(repr, values)), tuple(values), given.logarithmic)


def sample_variation(key: str, given: Span | Choices, read: Read, shares: np.ndarray) -> Variation:
    """A value for each run, from its share of the range or list, shape (runs,), each in [0, 1)."""
    if isinstance(given, Choices):
        listed = grid_variation(key, given, read)
        chosen = [int(share * len(listed.texts)) for share in shares]
        texts, values = tuple(listed.texts[i] for i in chosen), tuple(listed.values[i] for i in chosen)
        return Variation(key, listed.unit, texts, values, False)
    (lower, upper), unit = _ends(key, given, read)
    if isinstance(lower, int):
        raise InputError(
            key, f"{given.lower}:{given.upper}", "whole numbers are sampled from a list v1,v2,v3"
        )
    between = lower * (upper / lower) ** shares if given.logarithmic else lower + (upper - lower) * shares
    numbers = between.tolist()
    return Variation(key, unit, tuple(map(repr, numbers)), tuple(numbers), given.logarithmic)


def _ends(key: str, given: Span, read: Read) -> tuple[tuple[Any, Any], str]:
    """Both ends in SI, and the unit."""
    rows, shown = (read(given.lower), read(given.upper)), f"{given.lower}:{given.upper}"
    lower, upper = (row.value for row in rows)
    if not (isinstance(lower, int | float) and isinstance(upper, int | float)):
        raise InputError(key, shown, "a range is of numbers; allowed here is a list v1,v2,v3")
    if lower == upper:
        raise InputError(key, shown, "the two ends of a range must differ")
    if given.logarithmic and not min(lower, upper) > 0.0:
        raise InputError(key, shown, "both ends of a range in equal ratios must be above 0")
    return (lower, upper), rows[0].unit


def _whole(key: str, given: Span, values: list[float]) -> list[int]:
    """The values of a key that takes whole numbers."""
    if any(value != round(value) for value in values):
        shown = f"{given.lower}:{given.upper}:{given.count}"
        raise InputError(key, shown, f"not all of its values are whole numbers, like {values[1]:g}")
    return [round(value) for value in values]


def _plain(value: object) -> float | int | str:
    return value if isinstance(value, int | float | str) else str(value)
