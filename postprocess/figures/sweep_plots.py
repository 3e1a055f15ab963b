"""Plots of a sweep, as SVG text: results against a key, maps over two keys, and all keys side by side.

The rigid solution of each row stands beside its FE result. A row without a result is left out of the curves.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.comparison import TAIL_SLAP, Compared
from postprocess.figures.style import RIGID, Curve, drawn, style
from postprocess.figures.svg.chart import Axis, Plot, draw_chart
from postprocess.figures.svg.marks import Line, Mark
from postprocess.figures.svg.scale import log_ticks, power_text, round_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Values = NDArray[Any]

STATUS_COLOURS = {"passed": "#4f9d69", "failed": "#c4312f", "refused": "#9aa3ad", "error": "#1b1f24"}
FAILED = STATUS_COLOURS["failed"]
MAX_VECTOR = 1500
"""Rows above which points and lines are drawn as a picture inside the SVG, which would be too large otherwise."""
WIDTH = 9.6


@dataclass(frozen=True)
class Varied:
    """A key that varies: its values by row, numbers [unit] or words, and whether they are in equal ratios."""

    key: str
    unit: str
    values: Values
    logarithmic: bool

    @property
    def numeric(self) -> bool:
        """Whether the values are numbers."""
        return bool(np.issubdtype(self.values.dtype, np.number))

    @property
    def label(self) -> str:
        """The key with its unit."""
        return f"{self.key} [{self.unit}]" if self.unit else self.key


@dataclass(frozen=True)
class SweepRows:
    """All rows: keys, statuses and, by the names of what is compared, both solutions and their differences; those of
    the rigid vehicle alone have neither FE values nor differences."""

    varied: tuple[Varied, ...]
    status: Values
    fe: Mapping[str, Values]
    rigid: Mapping[str, Values]
    difference: Mapping[str, Values]
    compared: Compared = TAIL_SLAP

    @property
    def worst(self) -> Values:
        """Largest of the differences, shape (rows,); NaN where there are none."""
        if not self.difference:
            return np.full(self.status.shape, np.nan)
        return np.asarray(np.max(np.abs([self.difference[key] for key in self.compared.quantities]), axis=0))

    @property
    def best(self) -> Mapping[str, Values]:
        """What the best of the models gives: FE, or the rigid vehicle where it is alone."""
        return self.fe or self.rigid

    @property
    def some(self) -> bool:
        """Whether any row has a result to draw."""
        known = self.worst if self.fe else self.rigid[self.compared.mapped]
        return bool(np.isfinite(known).any())


def draw_sweep(rows: SweepRows) -> tuple[Curve, ...]:
    """All plots that these rows allow: of keys that are numbers, those against each; two make maps, three parallels."""
    if not rows.some:
        return ()
    numbers = [item for item in rows.varied if item.numeric]
    curves = [curve for item in numbers for curve in draw_against(rows, item)]
    if len(numbers) == len(rows.varied) == 2:
        curves.append(draw_maps(rows, numbers[0], numbers[1]))
    if len(rows.varied) > 2:
        curves.append(draw_parallels(rows))
    return tuple(curves)


def draw_against(rows: SweepRows, item: Varied) -> list[Curve]:
    """Each result, and the largest difference, against one key; lines where it is the only one."""
    order = _drawn_rows(rows, item)
    x, group = item.values[order], f"Against {item.key}"
    lowest, room = float(x.min()), 0.03 * float(np.ptp(x))
    low = 0.0 if 0.0 <= lowest < room else None  # a friction is never negative
    axis = Axis(item.label, low=low, is_log=item.logarithmic, margin=0.03)
    plots = {
        key: (Axis(quantity.label), quantity.title, _marks_against(rows, key, order, x))
        for key, quantity in rows.compared.quantities.items()
    }
    apart = _differences_against(rows, order, x)
    if apart:
        plots["difference"] = (Axis("largest difference", is_log=True), "Largest difference", apart)
    return [
        draw_chart(
            "-".join(("against", *re.split(r"[._]", item.key), key.replace(".", "-"))),
            f"{title} against {item.key}",
            (Plot(tuple(marks), up, 170.0, nearest=len(rows.varied) > 1),),
            axis,
            group,
            360.0,
        )
        for key, (up, title, marks) in plots.items()
    ]


def _drawn_rows(rows: SweepRows, item: Varied) -> Values:
    """Numbers of the rows in order of the key; of very many those that failed a check, and others at even steps."""
    order = np.argsort(item.values, kind="stable")
    every = -(-len(order) // MAX_VECTOR)
    failed = np.flatnonzero(rows.status[order] == "failed")[:MAX_VECTOR]
    return order[np.union1d(np.arange(0, len(order), every), failed)]


def _differences_against(rows: SweepRows, order: Values, x: Values) -> list[Mark]:
    """The largest difference of each row, apart for those that passed and those that failed."""
    worst, status = rows.worst[order], rows.status[order]
    marks: list[Mark] = []
    for label, colour in (("passed", "fe"), ("failed", "red")):
        chosen = (worst > 0.0) & (status == label)
        marks += [Line(label, x[chosen], worst[chosen], colour, 0.0, dots=1.8)] if chosen.any() else []
    return marks


def _marks_against(rows: SweepRows, key: str, order: Values, x: Values) -> list[Mark]:
    """The rigid vehicle, FE over it, and what failed over both."""
    alone = len(rows.varied) == 1
    marks: list[Mark] = [Line("rigid, exact", x, rows.rigid[key][order], "rigid", 3.0 * alone, dots=3.2)]
    if rows.fe:
        fe, failed = rows.fe[key][order], rows.status[order] == "failed"
        marks.append(Line("FE", x, fe, "fe", 1.0 * alone, dots=1.6))
        marks += (
            [Line("FE, a check failed", x[failed], fe[failed], "red", 0.0, dots=1.6)] if failed.any() else []
        )
    return marks


def draw_maps(rows: SweepRows, across: Varied, up: Varied) -> Curve:
    """One of the results, the largest difference and the status over two keys; without the second, of one model."""
    from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm

    shown, model = rows.compared.quantities[rows.compared.mapped], "FE" if rows.fe else "rigid"
    between = "largest difference FE/rigid - 1, " if rows.fe else ""
    keys = f"{across.key} and {up.key}"
    caption = f"Over {keys}: {shown.symbol} by {model}, {between}and what became of each run"
    worst = np.where(rows.worst > 0.0, rows.worst, np.nan)
    status = np.array([list(STATUS_COLOURS).index(one) for one in rows.status], dtype=float)
    colours = {
        "cmap": ListedColormap(list(STATUS_COLOURS.values())),
        "norm": BoundaryNorm(np.arange(5) - 0.5, 4),
    }
    with style():
        figure, panels = _panels(1, 3 if rows.fe else 2, 3.3)
        covers: dict[str, tuple[Values, dict[str, Any]]]
        covers = {f"{shown.symbol}, {model} [{shown.unit}]": (rows.best[shown.key], {"cmap": "viridis"})}
        if rows.fe:
            covers["largest difference"] = (worst, {"cmap": "viridis", "norm": LogNorm()})
        covers["status"] = (status, colours)
        for axes, (title, (values, coloured)) in zip(panels, covers.items(), strict=True):
            bar = figure.colorbar(_cover(axes, across, up, values, **coloured), ax=axes)
            axes.set_title(title, fontsize=9.0)
            axes.set_xscale("log" if across.logarithmic else "linear")
            axes.set_yscale("log" if up.logarithmic else "linear")
            axes.grid(visible=False)
            axes.set_xlabel(across.label)
        bar.set_ticks(range(4), labels=list(STATUS_COLOURS))
        panels[0].set_ylabel(up.label)
        return drawn(figure, "maps", caption, "Maps")


def draw_parallels(rows: SweepRows) -> Curve:
    """Each row a line across its inputs, its FE results and its largest difference, which colours it."""
    from matplotlib import colormaps
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgba

    caption = (
        "Each line is a row: its inputs, what FE gives, and the largest difference from the rigid solution of the same "
        "row, which colours the line (dark: small); red: a check failed. Behind it, in orange, that rigid solution"
    )
    if not rows.fe:
        caption = "Each line is a row: its inputs, and what the rigid vehicle gives; the last scale colours the line"
    inputs = [_scale(item.label, item.values, item.logarithmic) for item in rows.varied]
    both = [
        _scale(quantity.label, np.concatenate((rows.best[key], rows.rigid[key])), False)
        for key, quantity in rows.compared.quantities.items()
    ]
    worst = _scale("difference", np.where(rows.worst > 0.0, rows.worst, np.nan), True)
    if not rows.fe:
        worst = both[list(rows.compared.quantities).index(rows.compared.mapped)]
        worst = _Scale(worst.label, worst.heights[: len(rows.status)], worst.ticks)
    fe, rigid = np.split(np.array([scale.heights for scale in both]), 2, axis=1)
    heights = np.vstack([[scale.heights for scale in inputs], fe, worst.heights])
    known, scales = np.isfinite(heights).all(axis=0), (*inputs, *both, worst)
    colours = colormaps["viridis"](heights[-1, known])
    colours[rows.status[known] == "failed"] = to_rgba(FAILED)
    more: dict[str, Any] = {"alpha": 0.6, "rasterized": known.sum() > MAX_VECTOR // 5}
    with style():
        figure, (axes,) = _panels(1, 1, 4.2)
        places = np.arange(len(scales))
        behind = _paths(places[len(inputs) : -1], rigid[:, known])
        axes.add_collection(LineCollection(behind, colors=RIGID, linewidths=2.2, zorder=1, **more))
        axes.add_collection(
            LineCollection(_paths(places, heights[:, known]), colors=colours, linewidths=0.9, **more)
        )
        _mark(axes, scales)
        return drawn(figure, "parallels", caption, "All keys side by side")


def _paths(places: Values, heights: Values) -> list[Values]:
    """Points of each row's line, shape (places, 2); heights: shape (places, rows)."""
    return list(np.stack(np.broadcast_arrays(places, heights.T), axis=-1))


def _mark(axes: "Axes", scales: Sequence["_Scale"]) -> None:
    """The scales side by side: a line, marks and a label each."""
    halo = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
    offset: dict[str, Any] = {"xytext": (3, 0), "textcoords": "offset points", "va": "center"}
    for place, scale in enumerate(scales):
        axes.axvline(place, color="#8a929b", linewidth=0.8)
        for height, text in scale.ticks:
            axes.annotate(text, (place, height), fontsize=7.0, bbox=halo, **offset)
    labels = [scale.label.replace(".", ".\n").replace(" [", "\n[") for scale in scales]
    axes.set_xticks(range(len(scales)), labels, fontsize=7.5)
    axes.tick_params(axis="x", length=0)
    axes.set(yticks=[], xlim=(-0.1, len(scales) - 0.5), ylim=(-0.04, 1.04))
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)


@dataclass(frozen=True)
class _Scale:
    """An axis of the parallel plot: label, heights of the rows from 0 to 1, and marks with their heights."""

    label: str
    heights: Values
    ticks: Sequence[tuple[float, str]]


def _scale(label: str, values: Values, logarithmic: bool) -> _Scale:
    if not np.issubdtype(values.dtype, np.number):
        names = list(dict.fromkeys(values.tolist()))
        places = {word: (i + 0.5) / len(names) for i, word in enumerate(names)}
        return _Scale(label, np.array([places[word] for word in values]), [(p, w) for w, p in places.items()])
    numbers = np.log10(values) if logarithmic else values.astype(float)
    known = np.unique(numbers[np.isfinite(numbers)])
    if known.size < 2:
        return _Scale(label, 0.5 + 0.0 * numbers, [(0.5, _text(mark, logarithmic)) for mark in known])
    low, size = known[0], known[-1] - known[0]
    marks = [mark for mark in _marks(low, low + size, logarithmic) if low <= mark <= low + size]
    ticks = [((mark - low) / size, _text(mark, logarithmic)) for mark in marks]
    return _Scale(label, (numbers - low) / size, ticks)


def _marks(low: float, high: float, logarithmic: bool) -> Values:
    """Round numbers between these, or the logarithms of such."""
    if not logarithmic:
        return np.array(round_ticks(low, high, 4))
    return np.log10(log_ticks(10.0**low, 10.0**high, 4))


def _text(mark: float, logarithmic: bool) -> str:
    return power_text(10.0**mark) if logarithmic else f"{mark:.6g}".replace("-", "−")


def _panels(down: int, across: int, height: float) -> tuple["Figure", list["Axes"]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height))
    figure.set_layout_engine("constrained", w_pad=0.1)
    panels = [figure.add_subplot(down, across, i + 1) for i in range(down * across)]
    for axes in panels:
        axes.tick_params(length=2.5)
    return figure, panels


def _cover(axes: "Axes", across: Varied, up: Varied, values: Values, **colours: Any) -> Any:
    """Cells of a complete grid in the values' colours, or points."""
    x, column = np.unique(across.values, return_inverse=True)
    y, row = np.unique(up.values, return_inverse=True)
    many = len(values) > MAX_VECTOR
    if len(x) * len(y) != len(values) or min(len(x), len(y)) < 2:
        return axes.scatter(across.values, up.values, c=values, s=14.0, rasterized=many, **colours)
    table = np.full((len(y), len(x)), np.nan)
    table[row, column] = values
    edges = _edges(x, across.logarithmic), _edges(y, up.logarithmic)
    return axes.pcolormesh(*edges, table, rasterized=True, **colours)


def _edges(centres: Values, logarithmic: bool) -> Values:
    """Edges of cells about these centres; none below zero where no centre is."""
    c = np.log(centres) if logarithmic else centres.astype(float)
    middle = 0.5 * (c[1:] + c[:-1])
    edges = np.concatenate([[2.0 * c[0] - middle[0]], middle, [2.0 * c[-1] - middle[-1]]])
    if logarithmic:
        return np.asarray(np.exp(edges))
    return np.maximum(edges, 0.0) if c[0] >= 0.0 else edges
