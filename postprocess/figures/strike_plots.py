"""Plots of a study of strikes, as SVG text: both strikes against each input, as bands, and against flexibility."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.style import FE, RIGID, Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

COLOURS = {1: FE, 2: RIGID}
"""Of the first and the second strike."""

NAMES = {1: "first strike", 2: "second strike"}
LOOKS: tuple[dict[str, Any], ...] = (
    {"linewidth": 2.0},
    {"linewidth": 1.0, "linestyle": "--"},
    {"linewidth": 1.0, "linestyle": ":"},
)
"""Of the quantities of one panel, in their order."""

WIDTH, COLUMNS = 9.6, 4
MEASURED, PROJECTED = "#2a9d63", "#8d6bb5"


@dataclass(frozen=True)
class InputPanel:
    """Both strikes against one input, its values and the scene's own as shown.

    lines: strike -> name of the quantity -> values, shape (n,).
    """

    label: str
    values: Floats
    own: float
    logarithmic: bool
    lines: Mapping[int, Mapping[str, Floats]]


@dataclass(frozen=True)
class BandBar:
    """A spread: label, strike, 5, 50 and 95 %, and the scene's own value; dots: what was measured, by row."""

    label: str
    strike: int
    ends: tuple[float, float, float]
    own: float
    dots: Sequence[tuple[str, float, bool]] = ()


@dataclass(frozen=True)
class PlatePanel:
    """A quantity of both strikes over the frequencies, with the rigid vehicle's and what is not to be relied on."""

    label: str
    values: Mapping[int, Sequence[float]]
    rigid: Mapping[int, float]


def draw_inputs(name: str, caption: str, label: str, panels: Sequence[InputPanel]) -> Curve:
    """A panel an input; the scene's own value is a vertical line."""
    with style():
        figure, axes = _panels(len(panels) + 1)
        for place, panel in zip(axes, panels, strict=False):
            _draw_panel(place, panel)
        for place in axes[::COLUMNS]:
            place.set_ylabel(label)
        _legend(axes[len(panels)], [(NAMES[s], name) for s, own in panels[0].lines.items() for name in own])
        return drawn(figure, name, caption)


def _draw_panel(axes: "Axes", panel: InputPanel) -> None:
    for strike, quantities in panel.lines.items():
        for values, look in zip(quantities.values(), LOOKS, strict=False):
            axes.plot(panel.values, values, color=COLOURS[strike], **look)
    axes.axvline(panel.own, color="#8a929b", linewidth=1.0)
    axes.set_xscale("log" if panel.logarithmic else "linear")
    if panel.logarithmic:
        axes.set_xticks([0.3, 1.0, 3.0], ["0.3", "1", "3"])
        axes.minorticks_off()
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(panel.label)


def _legend(axes: "Axes", entries: Sequence[tuple[str, str]]) -> None:
    """What each line is, in an empty panel."""
    axes.axis("off")
    looks = dict(zip(dict.fromkeys(name for _, name in entries), LOOKS, strict=False))
    strikes = {text: COLOURS[strike] for strike, text in NAMES.items()}
    for strike, name in entries:
        axes.plot([], [], color=strikes[strike], label=f"{strike}, {name}", **looks[name])
    axes.axvline(np.nan, color="#8a929b", linewidth=1.0, label="the scene's own")
    axes.legend(loc="center left", frameon=False, fontsize=8.0)


def draw_bands(bars: Sequence[BandBar]) -> Curve:
    """A bar from 5 to 95 % a peak, its median, the scene's own value, and measured forces as dots with their row."""
    from matplotlib.figure import Figure

    caption = (
        "Peak lateral force: 5 to 95 %, median, the scene's own (diamond); dots: measured, rows of the paper"
    )
    with style():
        figure = Figure(figsize=(WIDTH, 0.8 + 0.58 * len(bars)))
        axes = figure.add_axes((0.2, 0.17, 0.78, 0.75))
        for place, bar in zip(range(len(bars))[::-1], bars, strict=True):
            _draw_bar(axes, place, bar)
        axes.set_yticks(range(len(bars)), [bar.label for bar in bars][::-1])
        axes.set(ylim=(-0.6, len(bars) - 0.4), xlabel="peak lateral force [kN]")
        axes.grid(axis="y", visible=False)
        axes.margins(x=0.03)
        words = (("━ first strike", COLOURS[1]), ("━ second strike", COLOURS[2]), ("● measured", MEASURED))
        for place, (text, colour) in enumerate((*words, ("● projected by the authors", PROJECTED))):
            figure.text(0.2 + 0.19 * place, 0.94, text, color=colour, fontweight="bold")
        return drawn(figure, "bands", caption)


def _draw_bar(axes: "Axes", place: float, bar: BandBar) -> None:
    low, middle, high = bar.ends
    axes.barh(place, high - low, left=low, height=0.34, color=COLOURS[bar.strike], alpha=0.35)
    axes.plot([middle, middle], [place - 0.17, place + 0.17], color=COLOURS[bar.strike], linewidth=2.2)
    axes.plot([bar.own], [place], "D", color=COLOURS[bar.strike], markersize=4.5)
    heights: list[float] = []
    for number, (row, value, projected) in enumerate(sorted(bar.dots, key=lambda dot: dot[1])):
        colour = PROJECTED if projected else MEASURED
        axes.plot([value], [place - 0.28], "o", color=colour, markersize=5.0)
        heights.append(2.0 if number % 2 else -9.0)
        axes.annotate(row, (value, place - 0.28), (4, heights[-1]), textcoords="offset points", color=colour)


def draw_plates(frequencies: Sequence[float], passed: Sequence[bool], panels: Sequence[PlatePanel]) -> Curve:
    """A panel a quantity; lines across: the rigid vehicle; crosses: plates that are not to be relied on."""
    from matplotlib.figure import Figure

    caption = "Both strikes against the plate's first frequency; dashed: rigid; crosses: not to be relied on"
    good, f = np.array(passed), np.array(frequencies)
    with style():
        figure = Figure(figsize=(WIDTH, 3.4))
        figure.set_layout_engine("constrained", w_pad=0.1)
        for number, panel in enumerate(panels, 1):
            axes = figure.add_subplot(1, len(panels), number)
            for strike, values in panel.values.items():
                shown, colour = np.array(values, dtype=float), COLOURS[strike]
                axes.plot(f[good], shown[good], color=colour, marker="o", markersize=4.0, label=NAMES[strike])
                axes.plot(f[~good], shown[~good], "x", color=colour)
                axes.axhline(panel.rigid[strike], color=colour, linewidth=1.0, linestyle="--")
            axes.set_xscale("log")
            axes.set_xticks(f, [f"{each:g}" for each in f])
            axes.minorticks_off()
            axes.set(xlabel="first frequency [Hz]", ylabel=panel.label, ylim=(0.0, None))
            axes.margins(x=0.06)
        axes.legend(frameon=False, fontsize=8.0, loc="best")
        return drawn(figure, "plates", caption)


def _panels(count: int) -> tuple["Figure", list["Axes"]]:
    from matplotlib.figure import Figure

    down = -(-count // COLUMNS)
    figure = Figure(figsize=(WIDTH, 2.45 * down))
    figure.set_layout_engine("constrained", w_pad=0.06, h_pad=0.06)
    panels = [figure.add_subplot(down, COLUMNS, i + 1) for i in range(count)]
    for axes in panels:
        axes.tick_params(length=2.5)
    return figure, panels
