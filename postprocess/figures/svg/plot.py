"""What a chart is made of: axes with labels, ends and ticks, and plots of marks in a frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from postprocess.figures.svg.marks import Mark
from postprocess.figures.svg.scale import Scale, fitted, tick_texts

SIZE, SMALL = 12.0, 11.0
"""Letters of labels, and of ticks."""


@dataclass(frozen=True)
class Axis:
    """An axis: its label with unit, its ends where they are not those of what is drawn, and its own ticks, which may be
    none."""

    label: str = ""
    low: float | None = None
    high: float | None = None
    is_log: bool = False
    margin: float = 0.05
    named: tuple[tuple[float, str], ...] | None = None

    def scale(self, found: tuple[float, float]) -> Scale:
        """A scale for what is drawn, without its places."""
        low, high = fitted(*found, self.margin, self.is_log)
        low = low if self.low is None else self.low
        high = high if self.high is None else self.high
        return Scale(low, high if high != low else low + 1.0, is_log=self.is_log)

    @property
    def unit(self) -> str:
        """What stands in brackets behind the label."""
        return self.label.partition("[")[2].rstrip("]")

    def named_as(self, label: str) -> Axis:
        """The same with a label."""
        return replace(self, label=label)

    def scaled(self, factor: float, unit: str) -> Axis:
        """The axis of values so many times as large, in another unit."""
        low, high = (None if end is None else factor * end for end in (self.low, self.high))
        named = self.named and tuple((factor * value, text) for value, text in self.named)
        return replace(
            self, label=self.label.replace(f"[{self.unit}]", f"[{unit}]"), low=low, high=high, named=named
        )

    def ticks(self, scale: Scale, room: float) -> list[tuple[float, str]]:
        """Values and their texts; room: for one of them."""
        if self.named is not None:
            return [
                (value, text)
                for value, text in self.named
                if min(scale.low, scale.high) <= value <= max(scale.low, scale.high)
            ]
        values = scale.ticks(max(2, int(abs(scale.end - scale.start) / room)))
        return list(zip(values, tick_texts(values, self.is_log), strict=True))


@dataclass(frozen=True)
class Plot:
    """Marks in a frame, if there are ticks. height: of the frame, None for equal scales of both axes; nearest: along
    which axes points are near whose values are shown."""

    marks: tuple[Mark, ...]
    y: Axis = Axis()
    height: float | None = 190.0
    nearest: Literal["x", "y", "xy"] = "x"
    has_grid: bool = True
    has_legend: bool = True
