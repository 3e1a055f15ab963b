"""Verification: labels of lines neither overlap nor leave the picture; ticks are powers of ten."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text

from postprocess.figures.label_spots import Box
from postprocess.figures.precision_plots import Diagram, Series, draw_panel, draw_precision
from postprocess.figures.style import style

pytestmark = pytest.mark.verification


def crowded(lines: int = 9) -> Diagram:
    """Lines that all end within a tenth of a decade of each other, at the right edge; one point failed."""
    series = [
        Series(
            f"line with a long name {n}",
            [1e-3, 1e-2, 0.9 + 0.01 * n],
            [1e-2 * (n + 1), 1e-4 * (n + 1), 1e-5 * (1.0 + 0.02 * n)],
            [True, n != 3, True],
        )
        for n in range(lines)
    ]
    front = [(1e-3, 1e-2), (1e-2, 1e-4), (0.9, 1e-5)]
    return Diagram("test", "(a) crowded", series, front, "Pareto front", 3e-6, "the truth is known", "error")


@pytest.fixture(scope="module")
def figure() -> Figure:
    with style():
        figure = Figure(figsize=(7.4, 5.2))
        FigureCanvasAgg(figure)
        draw_panel(figure.add_axes((0.1, 0.1, 0.88, 0.83)), crowded())
    return figure


def boxes(figure: Figure) -> dict[str, Box]:
    """Of every text without its leader, and of the legend."""
    axes = figure.axes[0]
    figure.canvas.draw()  # moves the texts to their places
    texts = [text for text in axes.texts if isinstance(text, Annotation)]
    found = {text.get_text(): Box(*Text.get_window_extent(text).extents) for text in texts}
    legend = axes.get_legend()
    assert legend is not None
    return found | {"legend": Box(*legend.get_window_extent().extents)}


def test_labels_do_not_overlap_and_none_is_cut(figure: Figure) -> None:
    found = boxes(figure)
    assert len(found) == 9 + 1 + 1  # lines, floor, legend
    window = Box(*figure.axes[0].get_window_extent().extents)
    assert [name for name, box in found.items() if not box.inside(window)] == []
    for (one, first), (other, second) in itertools.combinations(found.items(), 2):
        assert not first.overlaps(second), f"{one} over {other}"


def test_ticks_are_powers_of_ten_within_the_axes(figure: Figure) -> None:
    axes = figure.axes[0]
    for ticks, limits in ((axes.get_xticks(), axes.get_xlim()), (axes.get_yticks(), axes.get_ylim())):
        assert len(ticks) >= 3
        assert np.log10(ticks) == pytest.approx(np.round(np.log10(ticks)))
        assert limits[0] <= ticks[0] < ticks[-1] <= limits[1]
    assert axes.get_xticklabels()[0].get_text() == "10⁻³"


def test_legend_names_front_and_checks_and_no_line(figure: Figure) -> None:
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["Pareto front", "passed", "failed a check"]


def test_a_diagram_without_points_is_drawn() -> None:
    """A scene may refuse every setting of a panel."""
    nothing = Diagram(
        "empty", "(b)", [Series("quad4", [], [], [])], [], "Pareto front", math.nan, "", "error"
    )
    assert draw_precision(nothing).svg.startswith("<svg")
