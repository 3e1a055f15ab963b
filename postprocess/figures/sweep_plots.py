"""Charts of a sweep: results against a key, maps over two keys, and all keys side by side.

The rigid solution of each row stands beside its FE result. A row without a result is left out of the curves.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.quantities import TAIL_SLAP, Compared
from postprocess.figures.parallels import Scaled, draw_lines, scaled
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Boxes, Line, Mark, Shades, Swatch, cells_about

Values = NDArray[Any]

STATUS_COLOURS = {"passed": "green", "failed": "red", "refused": "grey", "error": "ink"}
MAX_DRAWN = 1500
"""Rows above which not all are drawn, or shown on pages: both would be too large."""


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


def draw_sweep(rows: SweepRows) -> tuple[Chart, ...]:
    """All plots that these rows allow: of keys that are numbers, those against each; two make maps, three parallels."""
    if not rows.some:
        return ()
    numbers = [item for item in rows.varied if item.numeric]
    curves = [curve for item in numbers for curve in draw_against(rows, item)]
    if len(numbers) == len(rows.varied) == 2:
        curves += draw_maps(rows, numbers[0], numbers[1])
    if len(rows.varied) > 2:
        curves.append(draw_parallels(rows))
    return tuple(curves)


def draw_against(rows: SweepRows, item: Varied) -> list[Chart]:
    """Each result, and the largest difference, against one key; lines where it is the only one."""
    order = _drawn_rows(rows, item)
    x, group = item.values[order], f"Against {item.key}"
    lowest, room = float(x.min()), 0.03 * float(np.ptp(x))
    low = 0.0 if 0.0 <= lowest < room and not item.logarithmic else None  # a friction is never negative
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
            (Plot(tuple(marks), up, 170.0, nearest="xy" if len(rows.varied) > 1 else "x"),),
            axis,
            group,
            360.0,
        )
        for key, (up, title, marks) in plots.items()
    ]


def _drawn_rows(rows: SweepRows, item: Varied) -> Values:
    """Numbers of the rows in order of the key; of very many those that failed a check, and others at even steps."""
    order = np.argsort(item.values, kind="stable")
    every = -(-len(order) // MAX_DRAWN)
    failed = np.flatnonzero(rows.status[order] == "failed")[:MAX_DRAWN]
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


def draw_maps(rows: SweepRows, across: Varied, up: Varied) -> list[Chart]:
    """One of the results, the largest difference and the status over two keys; without the second, of one model."""
    shown, model = rows.compared.quantities[rows.compared.mapped], "FE" if rows.fe else "the rigid vehicle"
    worst = np.where(rows.worst > 0.0, rows.worst, np.nan)
    maps = [_shaded("result", f"{shown.title} by {model}", rows.best[shown.key], shown.unit)]
    if rows.fe:
        maps.append(_shaded("worst", "Largest difference FE/rigid - 1", worst, "", is_log=True))
    keys = [Swatch(status, STATUS_COLOURS[status]) for status in dict.fromkeys(rows.status)]
    colours = np.array([STATUS_COLOURS[status] for status in rows.status])
    maps.append(_Map("status", "What became of each run", colours, rows.status, keys))
    return [_draw_map(each, across, up) for each in maps]


@dataclass(frozen=True)
class _Map:
    """What a map shows: a colour and words for each row, colours "" where there is nothing, and its keys."""

    name: str
    title: str
    colours: Values
    said: Values
    keys: Sequence[Swatch]


def _shaded(name: str, title: str, values: Values, unit: str, is_log: bool = False) -> _Map:
    known, colours = np.isfinite(values), np.full(values.shape, "", dtype=object)
    if not known.any():
        return _Map(name, title, colours, colours, [])
    shades = Shades.of(values, is_log)
    colours[known] = shades.colours(values[known])
    said = np.array([f"{value:.5g} {unit}".rstrip() for value in values], dtype=object)
    return _Map(name, title, colours, said, shades.keys(unit))


def _draw_map(of: _Map, across: Varied, up: Varied) -> Chart:
    """Cells of a complete grid in the values' colours, or small boxes; the keys stand above."""
    x, y, shown = across.values, up.values, of.colours != ""
    is_grid = (
        np.unique(x).size * np.unique(y).size == x.size and min(np.unique(x).size, np.unique(y).size) > 1
    )
    places = [f"{a:.4g}; {b:.4g}" for a, b in zip(x[shown], y[shown], strict=True)]
    said, at = (of.said[shown].tolist(), places) if shown.sum() <= MAX_DRAWN else ((), ())
    left, low = (_ends(item, is_grid)[shown] for item in (across, up))
    cells = Boxes(of.title, left, low, of.colours[shown].tolist(), said, at)
    along, upwards = (Axis(item.label, is_log=item.logarithmic, margin=0.0) for item in (across, up))
    plot = Plot((*of.keys, cells), upwards, 230.0, nearest="xy", has_grid=False)
    return draw_chart(f"map-{of.name}", of.title, (plot,), along, "Maps", 360.0)


def _ends(item: Varied, is_grid: bool) -> Values:
    """Ends of the cell about each value, or where runs make no grid, of a box of a fortieth of the range."""
    if is_grid:
        return cells_about(item.values, item.logarithmic)
    values = np.log(item.values) if item.logarithmic else item.values
    ends = values[:, None] + np.ptp(values) / 80.0 * np.array([-1.0, 1.0])
    return np.exp(ends) if item.logarithmic else ends


def draw_parallels(rows: SweepRows) -> Chart:
    """Each row a line across its inputs, its FE results and its largest difference, which colours it."""
    caption = (
        "Each line is a row: its inputs, what FE gives, and the largest difference from the rigid solution of the same "
        "row, which colours the line (dark: small); red: a check failed. Behind it, in orange, that rigid solution"
    )
    if not rows.fe:
        caption = "Each line is a row: its inputs, and what the rigid vehicle gives; the last scale colours the line"
    inputs = [scaled(item.label, item.values, item.logarithmic) for item in rows.varied]
    both = [
        scaled(quantity.label, np.concatenate((rows.best[key], rows.rigid[key])), False)
        for key, quantity in rows.compared.quantities.items()
    ]
    count = len(rows.status)
    fe, rigid = ([each.rows(part) for each in both] for part in (slice(count), slice(count, None)))
    worst = scaled("difference", np.where(rows.worst > 0.0, rows.worst, np.nan), True)
    last = worst if rows.fe else fe[list(rows.compared.quantities).index(rows.compared.mapped)]
    scales: list[Scaled] = [*inputs, *fe, last]
    chosen = _drawn_rows(rows, rows.varied[0])
    return draw_lines(caption, scales, rigid if rows.fe else [], chosen, rows.status == "failed")
