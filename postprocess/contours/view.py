"""Where the camera of a picture stands: straight above the X-Y plane, with pixel positions of its points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.svg.scale import round_ticks

SIDE, TOP, BOTTOM = 70, 190, 120


@dataclass(frozen=True)
class View:
    """Parallel view: centre [m], half the height of the picture [m], and size in pixels (width, height)."""

    center: tuple[float, float]
    half_height: float
    size: tuple[int, int]

    @property
    def pixel_length(self) -> float:
        """Length of one pixel [m]."""
        return 2.0 * self.half_height / self.size[1]

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Position in pixels, from the lower left corner of the picture, of the point (x, y) [m]."""
        column = 0.5 * self.size[0] + (x - self.center[0]) / self.pixel_length
        row = 0.5 * self.size[1] + (y - self.center[1]) / self.pixel_length
        return column, row

    def span(self) -> tuple[float, float]:
        """Smallest and largest X [m] in the picture."""
        half = 0.5 * self.size[0] * self.pixel_length
        return self.center[0] - half, self.center[0] + half


def view_of_plate(points: NDArray[np.float64], size: tuple[int, int]) -> View:
    """The view in which the plate (points (n, 2) [m]) and the wall line below it fill the picture.

    Bands are kept free at the top, for title and scalar bar, at the bottom, for the wall, and at the sides.
    """
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    low = min(low, 0.0)
    length = max((right - left) / (size[0] - 2 * SIDE), (high - low) / (size[1] - TOP - BOTTOM))
    row = BOTTOM + 0.5 * (size[1] - TOP - BOTTOM)
    center_y = 0.5 * (low + high) - (row - 0.5 * size[1]) * length
    return View((float(0.5 * (left + right)), float(center_y)), float(0.5 * size[1] * length), size)


def round_positions(low: float, high: float, most: int = 12) -> list[float]:
    """About `most` round numbers, multiples of 1, 2 or 5 times a power of ten, between low and high."""
    return round_ticks(low, high, most) if low < high else []
