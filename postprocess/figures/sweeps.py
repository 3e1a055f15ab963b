"""Charts of a sweep.

Results against a key, and maps over two keys. The rigid solution of each row is drawn beside its FE result. Curves
omit rows without a result.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.quantities import TAIL_SLAP, Compared
from postprocess.svg.areas import Boxes
from postprocess.svg.chart import FULL, PART, Axis, Chart, Plot
from postprocess.svg.marks import Line, Swatch
from postprocess.svg.scales import Shades, cells_about
from postprocess.units import measure

Values = NDArray[Any]

STATUS_COLOURS = {"passed": "green", "failed": "red", "refused": "grey", "error": "ink"}
MAX_DRAWN = 1500
"""Largest number of rows drawn, or shown on pages, which limits their size."""


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
    compared: Compared = TAIL_SLAP

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

    Results against each numerical key, and maps of two keys.
    """
    results = rows.worst if rows.fe else rows.rigid[rows.compared.mapped]
    if not np.isfinite(results).any():
        return ()
    numbers = [item for item in rows.varied if item.numeric]
    charts = [chart for item in numbers for chart in draw_against(rows, item)]
    if len(numbers) == len(rows.varied) == 2:
        charts += draw_maps(rows, numbers[0], numbers[1])
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
    charts, name = list[Chart](), "-".join(("against", *re.split(r"[._]", item.key)))
    for key, (up, title, marks) in plots.items():
        height, width = (250.0, FULL) if key == main else (170.0, PART)
        plot = Plot(tuple(marks), up, height, "xy" if len(rows.varied) > 1 else "x")
        caption = f"{title} against {item.key}"
        charts.append(Chart(f"{name}-{key.replace('.', '-')}", caption, (plot,), axis, group, width))
    return charts


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
