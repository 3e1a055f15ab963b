"""Numbers as colours, from the smallest to the largest, and cells about values on a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postprocess.figures.svg.drawing import Floats, extent, viridis
from postprocess.figures.svg.marks import Swatch
from postprocess.figures.svg.scale import Scale, tick_texts

COUNT = 65
"""Colours of a scale."""

UNIFORM = 1e-3
"""Range of values, over their size, that has all colours at least: less would make much of next to nothing."""


@dataclass(frozen=True)
class Shades:
    """Colours of values between two ends; is_log: by their logarithms."""

    low: float
    high: float
    is_log: bool = False

    @classmethod
    def of(cls, values: Floats, is_log: bool = False) -> Shades:
        """Those of the finite values, one at least."""
        low, high = extent(values)
        if is_log:
            return cls(low, high if high > low else 10.0 * low, True)
        more = 0.5 * max(0.0, UNIFORM * max(abs(low), abs(high), 1e-300) - (high - low))
        return cls(low - more, high + more)

    def colours(self, values: Floats) -> list[str]:
        """As "#rrggbb", of finite values."""
        share = np.clip(Scale(self.low, self.high, 0.0, 1.0, self.is_log).at(values), 0.0, 1.0)
        table = [f"#{bytes(each).hex()}" for each in np.rint(255.0 * viridis(COUNT)).astype(np.uint8)]
        return [table[number] for number in np.rint((COUNT - 1) * share).astype(int)]

    def keys(self, unit: str) -> list[Swatch]:
        """Round values for the legend, in this unit."""
        ticks = Scale(self.low, self.high, is_log=self.is_log).ticks(6)
        texts = [f"{text} {unit}".rstrip() for text in tick_texts(ticks, self.is_log)]
        return [Swatch(*pair) for pair in zip(texts, self.colours(np.array(ticks)), strict=True)]


def cells_about(values: Floats, is_log: bool) -> Floats:
    """Ends of the cell about each value, half-way to its neighbours, by ratios if is_log: shape (n, 2) for values of
    shape (n,), two different ones at least. No cell reaches below zero where no value does."""
    centres, place = np.unique(np.log(values) if is_log else values, return_inverse=True)
    middle = 0.5 * (centres[1:] + centres[:-1])
    edges = np.concatenate([[2.0 * centres[0] - middle[0]], middle, [2.0 * centres[-1] - middle[-1]]])
    edges = np.exp(edges) if is_log else np.maximum(edges, 0.0) if centres[0] >= 0.0 else edges
    return np.stack([edges[:-1], edges[1:]], axis=-1)[place]
