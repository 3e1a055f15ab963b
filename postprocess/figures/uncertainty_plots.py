"""Charts of an uncertainty study: histogram, sensitivity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from postprocess.figures.rows import bars, heights, intervals, row_plot
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.drawing import Floats
from postprocess.svg.marks import Boxes, Line, Mark, Span, key

WIDTH, BAR = 400.0, 0.36
INDICES = (("first_order", "alone", 0.19, "fe"), ("total", "with interactions", -0.19, "steel"))
"""Of the indices: name, label, place in a row, colour."""


def draw_histogram(
    edges: Floats, counts: Floats, percentiles: Sequence[tuple[int, float]], scene_value: float
) -> Chart:
    """The distribution of the peak force, in kN: counts between edges [N], percentiles and the scene's own value."""
    caption = "Peak force of the combinations: share of them in each bar"
    share, own, top = 100.0 * counts / counts.sum(), np.full(2, scene_value / 1e3), 1.12
    bars = np.stack([edges[:-1], edges[1:]], axis=-1) / 1e3
    ends = np.array([0.0, top * float(share.max())])
    marks: list[Mark] = [
        Boxes("share", bars, np.stack([0.0 * share, share], axis=-1), "steel", share.tolist(), strength=0.6),
        *(Span(f"{percent} %", force / 1e3, force / 1e3, "fe") for percent, force in percentiles),
        Line("", own, ends, "rigid", 2.0),
        key("the scene's own values", "rigid", 2.0),
    ]
    plot = Plot(tuple(marks), Axis("share [%]", *ends.tolist()), 220.0)
    return draw_chart(
        "histogram", caption, (plot,), Axis("peak force [kN]", margin=0.0), "Distribution", WIDTH
    )


def draw_sensitivity(inputs: Sequence[Any], of: str = "the peak force") -> Chart:
    """Bars of the first-order and total indices of inputs, the first on top, with their intervals.

    Each input has `key`, `first_order`, `total`, and their intervals, `first_order_interval` and `total_interval`.
    """
    caption = f"Share of the variance of {of} that comes from each input, and its 95 % interval"
    names, marks = [item.key for item in inputs], list[Mark]()
    for index, label, shift, colour in INDICES:
        values = np.array([getattr(item, index) for item in inputs])
        ends, rows = np.array([getattr(item, f"{index}_interval") for item in inputs]), heights(names) + shift
        zero = np.stack([0.0 * values, values], axis=-1)
        marks += [bars(label, rows, zero, colour, values.tolist(), names, BAR), intervals(rows, ends)]
    plot = row_plot(names, marks)
    return draw_chart("sensitivity", caption, (plot,), Axis("Sobol index"), "Sensitivity", WIDTH)
