"""Fields to be drawn, with their units, and their scales of colours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from postprocess.fields.series import COMPONENTS
from postprocess.figures.histories import power_of_ten
from postprocess.svg.scales import round_step
from postprocess.units import Units

STEPS = 7
"""Largest number of steps between labels of the scale."""

UNIFORM, WIDENING = 1e-4, 1e-2
"""Variation over the size of a field up to which it is uniform, and the range shown for it."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ContourField:
    """Field to be drawn.

    name: in file names ("v_gx"); title, unit; values in that unit, "nodal" or "element"; of_centre: value of the
    centre of mass, by default that of the field there.
    """

    name: str
    title: str
    unit: str
    values: Floats
    where: Literal["nodal", "element"] = "nodal"
    of_centre: float | None = None


def field_title(name: str) -> str:
    """Return the title of a field of `SCALARS`, followed by its component."""
    words = name.replace("_", " ").replace("stress von mises", "von Mises stress")
    return words[0].upper() + (f"{words[1:-1]}{words[-1].upper()}" if name in COMPONENTS else words[1:])


def shown_unit(field: ContourField, units: Units) -> tuple[float, str]:
    """Return the factor and unit for a field.

    Stresses have the prefix that suits the largest.
    """
    factor, unit = units.of(field.unit)
    power = power_of_ten(field.values)
    if unit != "Pa" or not 3 <= power <= 9:
        return factor, unit
    return 10.0**-power, {3: "kPa", 6: "MPa", 9: "GPa"}[power]


@dataclass(frozen=True)
class ColourScale:
    """Range of colours with labels, low to high.

    uniform: whether the field is almost constant.
    """

    low: float
    high: float
    labels: list[str]
    uniform: bool

    @property
    def bands(self) -> int:
        """Number of colours, two between labels.

        A uniform field has five.
        """
        return 5 if self.uniform else 2 * (len(self.labels) - 1)


def colour_scale(values: Floats) -> ColourScale:
    """Return the scale for values of any shape, with round labels.

    The range of a field that varies by less than 1e-4 of its size is widened to 1e-2 of its size about the mean (1e-2
    of the unit for zero), so that it has one colour and tiny variations are not exaggerated.
    """
    if not np.all(np.isfinite(values)):
        raise ValueError("a contour field has values that are not finite")
    low, high = float(np.min(values)), float(np.max(values))
    size = max(abs(low), abs(high))
    uniform = high - low <= UNIFORM * size or size == 0.0
    if uniform:
        middle, half, steps = 0.5 * (low + high), 0.5 * WIDENING * (size or 1.0), 2
        low, high = middle - half, middle + half
    else:
        step = round_step(high - low, STEPS)
        first, last = math.floor(low / step + 1e-6), math.ceil(high / step - 1e-6)
        low, high, steps = first * step, last * step, last - first
    return ColourScale(low, high, _labels(low, high, steps), uniform)


def _labels(low: float, high: float, steps: int) -> list[str]:
    """Return the texts of even values.

    Neighbours differ, the largest has two digits, the minus sign is a true one, and zero has no sign.
    """
    size = max(abs(low), abs(high))
    power = math.floor(math.log10(size))
    decimals = max(-math.floor(math.log10((high - low) / steps * (1.0 + 1e-9))), 1 - power)
    form = f".{max(decimals, 0)}f" if 1e-3 <= size < 1e6 else f".{decimals + power}e"
    texts = (format(value, form) for value in np.linspace(low, high, steps + 1))
    return [text.replace("-", "−", 1) if float(text) else text.lstrip("-") for text in texts]


def range_note(field: ContourField, scale: ColourScale) -> str:
    """Return the line below the title with the range of a field.

    It states whether the field is almost uniform.
    """
    low, high = float(np.min(field.values)), float(np.max(field.values))
    if scale.uniform:
        spread = (high - low) / (max(abs(low), abs(high)) or 1.0)
        at = "node" if field.where == "nodal" else "element"
        middle = f"{0.5 * (low + high):.5g}"
        widened = f"the colour range is widened to {100.0 * WIDENING:g} %"
        return f"uniform to {spread:.0e}: {middle} {field.unit} at every {at}; {widened}"
    ends = (end if abs(end) > 1e-5 * (high - low) else 0.0 for end in (low, high))
    least, most = (f"{end:.4g}" for end in ends)
    return f"{field.where} values from {least} to {most} {field.unit}"
