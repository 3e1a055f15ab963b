"""Sweeps from stiff to soft as SVG text: sizes over the first frequency, logarithmic, stiff plates on the left."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.figures.style import Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE, PLACE = (7.4, 4.6), (0.1, 0.115, 0.62, 0.86)
SMALL_SIZE, SMALL_PLACE = (4.6, 3.5), (0.16, 0.15, 0.81, 0.82)
LINE, RINGS, DOTS = "line", "rings", "dots"
COLOURS = ("#14467c", "#dd8a1d", "#2a9d63", "#e2574c", "#8d6bb5", "#5b6570")
MARKS = "os^Dvp"
FAILED, TEXT = "#c4161c", "#30363d"
X_LABEL = "first frequency of the plate [Hz], rigid to soft"


@dataclass(frozen=True)
class SweepLine:
    """A quantity's size at each frequency, and its error, drawn thin and dashed, where it has one.

    NaN is not drawn. form: LINE with marks; RINGS around the marks of another line; DOTS for what is no measurement.
    passed: which of its runs did, where that is not what the axis says.
    """

    label: str
    values: Sequence[float]
    errors: Sequence[float] = ()
    form: str = LINE
    passed: Sequence[bool] = ()


@dataclass(frozen=True)
class SweepAxis:
    """First frequencies [Hz] from stiff to soft, which of the runs passed, and the scene's own frequency."""

    frequencies: Sequence[float]
    passed: Sequence[bool]
    own: float


def draw_sweep(
    name: str, axis: SweepAxis, lines: Sequence[SweepLine], label: str, caption: str, levels: Sequence[float]
) -> Curve:
    """The lines; crosses where a run failed its checks; levels: sizes that are marked, in per cent.

    One line alone makes a small figure, with its legend inside.
    """
    from matplotlib.figure import Figure

    small = len(lines) == 1
    with style():
        figure = Figure(figsize=SMALL_SIZE if small else SIZE)
        axes = figure.add_axes(SMALL_PLACE if small else PLACE)
        axes.set(xscale="log", yscale="log", xlabel=X_LABEL, ylabel=label)
        for line, colour, mark in zip(lines, cycle(COLOURS), cycle(MARKS), strict=False):
            _draw(axes, axis, line, colour, mark)
        _explain(axes, axis, any(line.errors for line in lines))
        place: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.06, 0.5)}
        axes.legend(**({"loc": "upper left"} if small else place), fontsize=8, frameon=small)
        axes.set_xlim(axis.frequencies[0] * 1.15, axis.frequencies[-1] / 1.15)
        axes.xaxis.set_major_formatter("{x:g}")
        _mark(axes, axis, levels)
        return drawn(figure, name, caption, "Sweeps")


def _draw(axes: "Axes", axis: SweepAxis, line: SweepLine, colour: str, mark: str) -> None:
    x, values, passed = axis.frequencies, _drawable(line.values), np.array(line.passed or axis.passed)
    if line.form == DOTS:
        axes.plot(x, values, color=colour, linewidth=1.2, linestyle=":", label=line.label)
        return
    form: dict[str, Any] = {"marker": mark, "markersize": 4, "linewidth": 1.3}
    if line.form == RINGS:
        form = {"marker": "o", "markersize": 9, "linewidth": 0, "markerfacecolor": "none"}
    good, bad = np.where(passed, values, np.nan), np.where(passed, np.nan, values)
    axes.plot(x, good, color=colour, label=line.label, zorder=3, **form)
    axes.plot(x, bad, color=colour, marker="x", markersize=6, linestyle="none", zorder=3)
    if line.errors:
        errors = np.where(passed, _drawable(line.errors), np.nan)
        axes.plot(x, errors, color=colour, linewidth=0.7, linestyle="--", alpha=0.8)


def _drawable(values: Sequence[float]) -> np.ndarray:
    """The values that a logarithmic axis can show, NaN for the others."""
    found = np.array(values, dtype=float)
    return np.where(np.isfinite(found) & (found > 0.0), found, np.nan)


def _explain(axes: "Axes", axis: SweepAxis, errors: bool) -> None:
    """Entries of the legend that are no line's own."""
    if errors:
        axes.plot([], [], color=TEXT, linewidth=0.7, linestyle="--", label="numerical error")
    if not all(axis.passed):
        axes.plot([], [], color=FAILED, linewidth=6, alpha=0.15, label="failed a check")
    if axis.frequencies[-1] <= axis.own <= axis.frequencies[0]:
        axes.axvline(axis.own, color=TEXT, linewidth=1.0, linestyle=(0, (1, 2)), label="the scene's plate")


def _mark(axes: "Axes", axis: SweepAxis, levels: Sequence[float]) -> None:
    """Failed frequencies shaded half-way to their neighbours; levels as lines with their per cent."""
    logs = np.log(np.array(axis.frequencies))
    half = 0.5 * abs(logs[1] - logs[0])
    for place, passed in zip(logs, axis.passed, strict=True):
        if not passed:
            ends = np.exp([place - half, place + half])
            axes.axvspan(*ends, color=FAILED, alpha=0.1, linewidth=0, zorder=0)
    right: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    for level in levels:
        axes.axhline(level, color="#8a929b", linewidth=0.8, zorder=1)
        text = f"{100.0 * level:g} %"
        axes.annotate(text, (1.0, level), (3, 0), va="center", fontsize=7, color="#5b6570", **right)
