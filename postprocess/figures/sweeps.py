"""Charts of a sweep.

Results against a key, maps over two keys, and all keys as parallel scales. The rigid solution of each row is drawn
beside its FE result. Curves omit rows without a result.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison import quantities
from postprocess.comparison.records import Compared
from postprocess.svg.areas import Boxes
from postprocess.svg.chart import FULL, PART, Axis, Chart, Plot
from postprocess.svg.marks import Line, Mark, Swatch, Words
from postprocess.svg.scales import Scale, Shades, cells_about, power_text
from postprocess.units import measure

Values = NDArray[Any]

STATUS_COLOURS = {"passed": "green", "failed": "red", "refused": "grey", "error": "ink"}
MAX_DRAWN = 1500
"""Largest number of rows drawn, or shown on pages, which limits their size."""
TICKS = 4
"""Ticks of a scale."""


@dataclass(frozen=True)
class Varied:
    """Key that varies.

    values: by row, numbers [unit] or words; logarithmic: whether they have equal ratios.
    """

    key: str
    unit: str
    values: Values
    logarithmic: bool

    @property
    def numeric(self) -> bool:
        """True if the values are numbers."""
        return bool(np.issubdtype(self.values.dtype, np.number))

    @property
    def label(self) -> str:
        """Key with its unit."""
        return f"{self.key} [{self.unit}]" if self.unit else self.key


@dataclass(frozen=True)
class SweepRows:
    """All rows of a sweep.

    Keys, statuses, both solutions and their differences by quantity. Sweeps of the rigid vehicle alone have neither
    FE values nor differences.
    """

    varied: tuple[Varied, ...]
    status: Values
    fe: Mapping[str, Values]
    rigid: Mapping[str, Values]
    difference: Mapping[str, Values]
    compared: Compared = quantities.TAIL_SLAP

    @property
    def worst(self) -> Values:
        """Largest of the differences, shape (rows,).

        It is NaN without any.
        """
        if not self.difference:
            return np.full(self.status.shape, np.nan)
        return np.asarray(np.max(np.abs([self.difference[key] for key in self.compared.quantities]), axis=0))

    @property
    def best(self) -> Mapping[str, Values]:
        """Values of FE, or of the rigid vehicle if it is alone."""
        return self.fe or self.rigid


def draw_sweep(rows: SweepRows) -> tuple[Chart, ...]:
    """Draw all charts that these rows allow.

    Results against each numerical key, maps of two keys, parallel scales of three or more.
    """
    results = rows.worst if rows.fe else rows.rigid[rows.compared.mapped]
    if not np.isfinite(results).any():
        return ()
    numbers = [item for item in rows.varied if item.numeric]
    charts = [chart for item in numbers for chart in draw_against(rows, item)]
    if len(numbers) == len(rows.varied) == 2:
        charts += draw_maps(rows, numbers[0], numbers[1])
    if len(rows.varied) > 2:
        charts.append(draw_parallels(rows))
    return tuple(charts)


def draw_against(rows: SweepRows, item: Varied) -> list[Chart]:
    """Draw results and largest difference against one key.

    The main result comes first. Points are connected if the key is the only one.
    """
    order = _drawn_rows(rows, item)
    x, group = item.values[order], f"Against {item.key}"
    lowest, room = float(x.min()), 0.03 * float(np.ptp(x))
    low = 0.0 if 0.0 <= lowest < room and not item.logarithmic else None  # a friction is never negative
    axis = Axis(item.label, low=low, is_log=item.logarithmic, margin=0.03)
    plots = {
        key: (Axis(quantity.label), quantity.title, _marks_against(rows, key, order, x))
        for key, quantity in rows.compared.quantities.items()
    }
    main, worst, status = rows.compared.mapped, rows.worst[order], rows.status[order]
    plots = {main: plots[main]} | plots
    apart = [
        Line(label, x[chosen], worst[chosen], colour, 0.0, dots=1.8)
        for label, colour in (("passed", "fe"), ("failed", "red"))
        if (chosen := (worst > 0.0) & (status == label)).any()
    ]
    if apart:
        plots["difference"] = (Axis("largest difference", is_log=True), "Largest difference", apart)
    return [
        Chart(
            "-".join(("against", *re.split(r"[._]", item.key), key.replace(".", "-"))),
            f"{title} against {item.key}",
            (
                Plot(
                    tuple(marks),
                    up,
                    250.0 if key == main else 170.0,
                    nearest="xy" if len(rows.varied) > 1 else "x",
                ),
            ),
            axis,
            group,
            FULL if key == main else PART,
        )
        for key, (up, title, marks) in plots.items()
    ]


def _drawn_rows(rows: SweepRows, item: Varied) -> Values:
    """Return the drawn rows, sorted by the key.

    Of very many those that failed a check, and others at even steps.
    """
    order = np.argsort(item.values, kind="stable")
    stride = -(-len(order) // MAX_DRAWN)
    failed = np.flatnonzero(rows.status[order] == "failed")[:MAX_DRAWN]
    return order[np.union1d(np.arange(0, len(order), stride), failed)]


def _marks_against(rows: SweepRows, key: str, order: Values, x: Values) -> list[Line]:
    """Return the rigid vehicle, FE above it, and failed runs on top."""
    alone = len(rows.varied) == 1
    marks = [Line("rigid, exact", x, rows.rigid[key][order], "rigid", 3.0 * alone, dots=3.2)]
    if rows.fe:
        fe, failed = rows.fe[key][order], rows.status[order] == "failed"
        marks.append(Line("FE", x, fe, "fe", 1.0 * alone, dots=1.6))
        if failed.any():
            marks.append(Line("FE, a check failed", x[failed], fe[failed], "red", 0.0, dots=1.6))
    return marks


def draw_maps(rows: SweepRows, across: Varied, up: Varied) -> list[Chart]:
    """Draw a result, the largest difference and the status over two keys."""
    quantity, model = rows.compared.quantities[rows.compared.mapped], "FE" if rows.fe else "the rigid vehicle"
    title = f"{quantity.title} by {model}"
    maps = [_draw_map("result", title, *_shaded(rows.best[quantity.key], quantity.unit), across, up)]
    if rows.fe:
        worst = np.where(rows.worst > 0.0, rows.worst, np.nan)
        title = "Largest difference FE/rigid - 1"
        maps.append(_draw_map("worst", title, *_shaded(worst, "", is_log=True), across, up))
    keys = [Swatch(status, STATUS_COLOURS[status]) for status in dict.fromkeys(rows.status)]
    colours = np.array([STATUS_COLOURS[status] for status in rows.status])
    title = "What became of each run"
    return [*maps, _draw_map("status", title, colours, rows.status, keys, across, up)]


def _shaded(values: Values, unit: str, is_log: bool = False) -> tuple[Values, Values, Sequence[Swatch]]:
    """Return colours and texts of values, and legend.

    Values that are not finite have empty texts.
    """
    finite, colours = np.isfinite(values), np.full(values.shape, "", dtype=object)
    if not finite.any():
        return colours, colours, []
    shades = Shades.of(values, is_log)
    colours[finite] = shades.colours(values[finite])
    value_texts = np.array([measure(value, unit, ".5g", named=bool(unit)) for value in values], dtype=object)
    return colours, value_texts, [Swatch(*colour_key) for colour_key in shades.keys(unit)]


def _draw_map(
    name: str,
    title: str,
    colours: Values,
    value_texts: Values,
    keys: Sequence[Swatch],
    across: Varied,
    up: Varied,
) -> Chart:
    """Draw cells of a complete grid, or boxes."""
    x, y, coloured = across.values, up.values, colours != ""
    counts = np.unique(x).size, np.unique(y).size
    is_grid = counts[0] * counts[1] == x.size and min(counts) > 1
    places = [f"{a:.4g}; {b:.4g}" for a, b in zip(x[coloured], y[coloured], strict=True)]
    texts, at = (value_texts[coloured].tolist(), places) if coloured.sum() <= MAX_DRAWN else ((), ())
    ends_x, ends_y = (_ends(item, is_grid)[coloured] for item in (across, up))
    cells = Boxes(title, ends_x, ends_y, colours[coloured].tolist(), texts, at)
    along, upwards = (Axis(item.label, is_log=item.logarithmic, margin=0.0) for item in (across, up))
    plot = Plot((*keys, cells), upwards, 230.0, nearest="xy", has_grid=False)
    return Chart(f"map-{name}", title, (plot,), along, "Maps")


def _ends(item: Varied, is_grid: bool) -> Values:
    """Return the ends of cells about values.

    Runs that make no grid have boxes of a fortieth of the range.
    """
    if is_grid:
        return cells_about(item.values, item.logarithmic)
    values = np.log(item.values) if item.logarithmic else item.values
    ends = values[:, None] + np.ptp(values) / 80.0 * np.array([-1.0, 1.0])
    return np.exp(ends) if item.logarithmic else ends


class Scaled(NamedTuple):
    """One of several parallel scales.

    Values of the rows, their heights from 0 to 1, and ticks with their heights.
    """

    label: str
    values: Values
    heights: Values
    ticks: Sequence[tuple[float, str]]


def scaled(label: str, values: Values, is_log: bool) -> Scaled:
    """Return the scale of numbers, or of words at even heights."""
    if not np.issubdtype(values.dtype, np.number):
        names = list(dict.fromkeys(values.tolist()))
        places = {word: (i + 0.5) / len(names) for i, word in enumerate(names)}
        heights = np.array([places[word] for word in values])
        return Scaled(label, values, heights, [(place, word) for word, place in places.items()])
    numbers = np.unique(values[np.isfinite(values)]).astype(float)
    if numbers.size < 2:
        return Scaled(label, values, 0.5 + 0.0 * values, [(0.5, power_text(value)) for value in numbers])
    scale = Scale(float(numbers[0]), float(numbers[-1]), is_log=is_log)
    ticks = [(float(scale.at(tick)), power_text(tick)) for tick in scale.ticks(TICKS)]
    return Scaled(label, values, np.asarray(scale.at(values)), ticks)


def draw_parallels(rows: SweepRows) -> Chart:
    """Draw rows as lines across parallel scales.

    The scales are its inputs, its FE results and its largest difference, which colours it; failed rows are red. The
    rigid solution is drawn below these lines.
    """
    caption = (
        "Each line is a row: its inputs, FE results, and the largest difference from the rigid solution of the same "
        "row, which colours the line (dark: small); red: a check failed. Behind it, in orange, that rigid solution"
    )
    if not rows.fe:
        caption = "Each line is a row: its inputs, and results of the rigid vehicle; the last scale colours the line"
    inputs = [scaled(item.label, item.values, item.logarithmic) for item in rows.varied]
    count, results, rigid = len(rows.status), [], []
    for key, quantity in rows.compared.quantities.items():
        combined = scaled(quantity.label, np.concatenate((rows.best[key], rows.rigid[key])), False)
        results.append(combined._replace(values=combined.values[:count], heights=combined.heights[:count]))
        rigid.append(combined.heights[count:])
    worst = scaled("difference", np.where(rows.worst > 0.0, rows.worst, np.nan), True)
    last = worst if rows.fe else results[list(rows.compared.quantities).index(rows.compared.mapped)]
    scales = [*inputs, *results, last]
    heights = np.array([scale.heights for scale in scales])
    chosen = _drawn_rows(rows, rows.varied[0])
    complete = chosen[np.isfinite(heights[:, chosen]).all(axis=0)]
    lines = _lines(heights[:, complete], rows.status[complete] == "failed")
    if rows.fe:
        places = np.arange(len(inputs), len(scales) - 1)
        lines.insert(0, _across(places, np.array(rigid)[:, complete], "rigid", 2.2))
    axes: list[Mark] = []
    for place, scale in enumerate(scales):
        axes.append(Line("", np.full(2, float(place)), np.array([0.0, 1.0]), "grey", 0.8))
        axes += [Words(text, place, height, (4.0, 3.5)) for height, text in scale.ticks]
    labels = [scale.label.replace(".", ".\n").replace(" [", "\n[") for scale in scales]
    x = Axis(low=-0.15, high=len(scales) - 0.4, named=tuple(enumerate(labels)))
    y = Axis(low=-0.04, high=1.04, named=())
    marks = (*lines, *axes, _points(scales, complete))
    plot = Plot(marks, y, 330.0, nearest="xy", has_grid=False, has_legend=False)
    return Chart("parallels", caption, (plot,), x, "All keys side by side", FULL)


def _lines(heights: Values, failed: Values) -> list[Mark]:
    """Return the lines of rows in the colour of their last value.

    heights: shape (scales, rows).
    """
    colours = np.where(failed, "red", Shades(0.0, 1.0).colours(heights[-1]))
    places = np.arange(len(heights))
    return [_across(places, heights[:, colours == one], one, 0.9) for one in dict.fromkeys(colours.tolist())]


def _across(places: Values, heights: Values, colour: str, width: float) -> Line:
    """Return lines through heights, shape (places, rows)."""
    gap = np.full((1, heights.shape[1]), np.nan)
    x = np.tile(np.append(places, np.nan), heights.shape[1])
    return Line("", x, np.concatenate([heights, gap]).T.ravel(), colour, width)


def _points(scales: Sequence[Scaled], selected: Values) -> Line:
    """Return the values that pages show where rows meet a scale."""
    places, heights, texts, at = [], [], [], []
    for place, scale in enumerate(scales):
        places += [float(place)] * len(selected)
        heights += scale.heights[selected].tolist()
        texts += [value if isinstance(value, str) else f"{value:.5g}" for value in scale.values[selected]]
        at += [f"run {row}, {scale.label}" for row in selected]
    return Line("value", np.array(places), np.array(heights), width=0.0, values=texts, at=at)
