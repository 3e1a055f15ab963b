"""Plots of a sweep, as SVG text: results against a key, maps over two keys, and all keys side by side.

The rigid solution of each row stands beside its FE result. A row without a result is left out of the curves.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.comparison import KEYS, QUANTITIES
from postprocess.figures.style import FE, RIGID, Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Values = NDArray[Any]

STATUS_COLOURS = {"passed": "#4f9d69", "failed": "#c4312f", "refused": "#9aa3ad", "error": "#1b1f24"}
FAILED = STATUS_COLOURS["failed"]
MANY = 1500
"""Rows above which points and lines are drawn as a picture inside the SVG, which would be too large otherwise."""
WIDE, LEFT = 9.6, 0.085


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
    """All rows: keys, statuses and, by the names of `comparison.KEYS`, both solutions and their differences."""

    varied: tuple[Varied, ...]
    status: Values
    fe: Mapping[str, Values]
    rigid: Mapping[str, Values]
    difference: Mapping[str, Values]

    @property
    def worst(self) -> Values:
        """Largest of the five differences, shape (rows,); NaN where there are none."""
        return np.asarray(np.max(np.abs([self.difference[key] for key in KEYS]), axis=0))


def draw_sweep(rows: SweepRows) -> tuple[Curve, ...]:
    """All plots that these rows allow: of keys that are numbers, those against each; two make maps, three parallels."""
    if not np.isfinite(rows.worst).any():
        return ()
    numbers = [item for item in rows.varied if item.numeric]
    curves = [draw_against(rows, item) for item in numbers]
    if len(numbers) == len(rows.varied) == 2:
        curves.append(draw_maps(rows, numbers[0], numbers[1]))
    if len(rows.varied) > 2:
        curves.append(draw_parallels(rows))
    return tuple(curves)


def draw_against(rows: SweepRows, item: Varied) -> Curve:
    """The five results and their largest difference against one key; a line where it is the only one."""
    caption = f"Results at the tail-slap against {item.key}: rigid solution and FE run of the same rows"
    name = "against-" + item.key.replace(".", "-").replace("_", "-")
    alone, many = len(rows.varied) == 1, len(item.values) > MANY
    order = np.argsort(item.values, kind="stable")
    x, failed = item.values[order], rows.status[order] == "failed"
    with style():
        figure, panels = _panels(2, 3, 5.2)
        for key, axes in zip(KEYS, panels, strict=False):
            rigid, fe = rows.rigid[key][order], rows.fe[key][order]
            lines: dict[str, Any] = {"marker": "o", "linestyle": "-" if alone else "none", "rasterized": many}
            axes.plot(x, rigid, color=RIGID, markersize=5.0, linewidth=3.0, **lines)
            axes.plot(x, fe, color=FE, markersize=2.2, linewidth=1.0, **lines)
            axes.plot(x[failed], fe[failed], "o", color=FAILED, markersize=2.2, rasterized=many)
            axes.set_ylabel(f"{QUANTITIES[key].symbol} [{QUANTITIES[key].unit}]")
        _worst(panels[5], rows, item)
        for axes in panels:
            axes.set_xscale("log" if item.logarithmic else "linear")
            axes.margins(x=0.03)
            axes.yaxis.set_label_coords(-0.23, 0.5)
        for axes in panels[3:]:
            axes.set_xlabel(item.label)
        legend = (("rigid, exact", RIGID), ("FE", FE), ("FE, a check failed", FAILED))
        _legend(figure, legend if failed.any() else legend[:2])
        return drawn(figure, name, caption, f"Against {item.key}")


def draw_maps(rows: SweepRows, across: Varied, up: Varied) -> Curve:
    """v_GY, the largest difference and the status over two keys."""
    from matplotlib.colors import LogNorm

    keys = f"{across.key} and {up.key}"
    caption = f"Over {keys}: v_GY by FE, largest difference FE/rigid - 1, and what became of each run"
    with style():
        figure, panels = _panels(1, 3, 3.5, wspace=0.42)
        worst = np.where(rows.worst > 0.0, rows.worst, np.nan)
        maps = (("v_GY, FE [m/s]", rows.fe["v_gy"], None), ("largest difference", worst, LogNorm()))
        for axes, (title, values, norm) in zip(panels, maps, strict=False):
            shown = _cover(axes, across, up, values, cmap="viridis", norm=norm)
            figure.colorbar(shown, ax=axes, pad=0.03)
            axes.set_title(title, fontsize=9.0)
        _statuses(panels[2], rows, across, up)
        for axes in panels:
            axes.set_xscale("log" if across.logarithmic else "linear")
            axes.set_yscale("log" if up.logarithmic else "linear")
            axes.grid(visible=False)
            axes.set_xlabel(across.label)
        panels[0].set_ylabel(up.label)
        return drawn(figure, "maps", caption, "Maps")


def draw_parallels(rows: SweepRows) -> Curve:
    """Each row a line across its inputs, its FE results and its largest difference, which colours it."""
    from matplotlib import colormaps

    caption = (
        "Each line is a row: its inputs, what FE gives, and the largest difference from the rigid solution of the same "
        "row, which colours the line (dark: small); red: a check failed. Behind it, in orange, that rigid solution"
    )
    scales = [_scale(item.label, item.values, item.logarithmic) for item in rows.varied]
    inputs, rigid = len(scales), []
    for key in KEYS:
        label, both = f"{QUANTITIES[key].symbol} [{QUANTITIES[key].unit}]", (rows.fe[key], rows.rigid[key])
        scale = _scale(label, np.concatenate(both), False)
        fe_heights, rigid_heights = np.split(scale.heights, 2)
        scales.append(replace(scale, heights=fe_heights))
        rigid.append(rigid_heights)
    scales.append(_scale("difference", np.where(rows.worst > 0.0, rows.worst, np.nan), True))
    heights = np.array([scale.heights for scale in scales])
    known = np.isfinite(heights).all(axis=0)
    with style():
        figure, (axes,) = _panels(1, 1, 4.2)
        for i in np.flatnonzero(known):
            failed = rows.status[i] == "failed"
            colour = FAILED if failed else colormaps["viridis"](heights[-1, i])
            line: dict[str, Any] = {"alpha": 0.6, "rasterized": known.sum() > MANY // 5}
            exact = [heights_of_one[i] for heights_of_one in rigid]
            axes.plot(range(inputs, inputs + len(KEYS)), exact, color=RIGID, linewidth=2.2, zorder=1, **line)
            axes.plot(heights[:, i], color=colour, linewidth=0.9, **line)
        halo = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6}
        for place, scale in enumerate(scales):
            axes.axvline(place, color="#8a929b", linewidth=0.8)
            for height, text in scale.ticks:
                axes.annotate(
                    text, (place, height), (3, 0), textcoords="offset points", fontsize=7.0, bbox=halo
                )
        axes.set_xticks(range(len(scales)), [scale.label.replace(" [", "\n[") for scale in scales])
        axes.tick_params(axis="x", labelsize=7.5, length=0)
        axes.set_yticks([])
        axes.set_xlim(-0.1, len(scales) - 0.5)
        axes.grid(visible=False)
        for side in axes.spines.values():
            side.set_visible(False)
        return drawn(figure, "parallels", caption, "All keys side by side")


@dataclass(frozen=True)
class _Scale:
    """An axis of the parallel plot: label, heights of the rows from 0 to 1, and marks with their heights."""

    label: str
    heights: Values
    ticks: Sequence[tuple[float, str]]


def _scale(label: str, values: Values, logarithmic: bool) -> _Scale:
    if not np.issubdtype(values.dtype, np.number):
        words = list(dict.fromkeys(values.tolist()))
        places = {word: (i + 0.5) / len(words) for i, word in enumerate(words)}
        return _Scale(label, np.array([places[word] for word in values]), [(p, w) for w, p in places.items()])
    numbers = np.log10(values) if logarithmic else values.astype(float)
    low, high = (
        (float(np.nanmin(numbers)), float(np.nanmax(numbers))) if np.isfinite(numbers).any() else (0, 0)
    )
    if low == high:
        low, high = low - 0.5, high + 0.5
    marks = np.linspace(low, high, 3)
    ticks = [(i / 2, f"{10.0**mark if logarithmic else mark:.3g}") for i, mark in enumerate(marks)]
    return _Scale(label, (numbers - low) / (high - low), ticks)


def _panels(down: int, across: int, height: float, wspace: float = 0.4) -> tuple["Figure", list["Axes"]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDE, height))
    room = {"left": LEFT, "right": 0.985, "bottom": 0.5 / height, "top": 1.0 - 0.35 / height}
    grid = figure.add_gridspec(down, across, **room, wspace=wspace, hspace=0.25)
    panels = [figure.add_subplot(grid[i]) for i in range(down * across)]
    for axes in panels:
        axes.tick_params(length=2.5)
    return figure, panels


def _legend(figure: "Figure", entries: Sequence[tuple[str, str]]) -> None:
    """The names of what is drawn, in their own colours above the plots."""
    x = LEFT
    for label, colour in entries:
        figure.text(x, 0.965, f"━ {label}", color=colour, fontweight="bold")
        x += 0.035 + 0.0085 * len(label)


def _worst(axes: "Axes", rows: SweepRows, item: Varied) -> None:
    """Largest difference of each row that has one; red where a check failed."""
    worst = rows.worst
    for status in ("passed", "failed"):
        chosen = (rows.status == status) & (worst > 0.0)
        colour = FE if status == "passed" else FAILED
        axes.plot(
            item.values[chosen],
            worst[chosen],
            "o",
            color=colour,
            markersize=2.5,
            rasterized=chosen.sum() > MANY,
        )
    axes.set_yscale("log")
    axes.tick_params(axis="y", which="minor", labelsize=7.0)
    axes.set_ylabel("largest difference")


def _statuses(axes: "Axes", rows: SweepRows, across: Varied, up: Varied) -> None:
    """The status of each run; what the colours mean stands above the map."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    names = list(STATUS_COLOURS)
    numbers = np.array([names.index(status) for status in rows.status], dtype=float)
    colours, norm = ListedColormap(list(STATUS_COLOURS.values())), BoundaryNorm(np.arange(5) - 0.5, 4)
    _cover(axes, across, up, numbers, cmap=colours, norm=norm)
    for place, name in enumerate(name for name in names if name in rows.status):
        axes.text(
            0.28 * place, 1.03, name, color=STATUS_COLOURS[name], weight="bold", transform=axes.transAxes
        )


def _cover(axes: "Axes", across: Varied, up: Varied, values: Values, **colours: Any) -> Any:
    """Cells of a complete grid in the values' colours, or points."""
    x, column = np.unique(across.values, return_inverse=True)
    y, row = np.unique(up.values, return_inverse=True)
    if len(x) * len(y) != len(values) or min(len(x), len(y)) < 2:
        return axes.scatter(
            across.values, up.values, c=values, s=14.0, rasterized=len(values) > MANY, **colours
        )
    table = np.full((len(y), len(x)), np.nan)
    table[row, column] = values
    return axes.pcolormesh(
        _edges(x, across.logarithmic), _edges(y, up.logarithmic), table, rasterized=True, **colours
    )


def _edges(centres: Values, logarithmic: bool) -> Values:
    """Edges of cells about these centres."""
    c = np.log(centres) if logarithmic else centres.astype(float)
    middle = 0.5 * (c[1:] + c[:-1])
    edges = np.concatenate([[2.0 * c[0] - middle[0]], middle, [2.0 * c[-1] - middle[-1]]])
    return np.asarray(np.exp(edges) if logarithmic else edges)
