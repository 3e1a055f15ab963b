"""Verification: each line of error against time has a plot of its own over the same axes; failed points are marked."""

import math
import re

from postprocess.figures.loglog import Series, draw_precision
from postprocess.svg.chart import Chart


def crowded(lines: int = 9) -> list[Chart]:
    """Lines that all end within a tenth of a decade of each other; one point failed."""
    series = [
        Series(
            f"line {n}",
            [1e-3, 1e-2, 0.9 + 0.01 * n],
            [1e-2 * (n + 1), 1e-4 * (n + 1), 1e-5 * (1.0 + 0.02 * n)],
            [True, n != 3, True],
        )
        for n in range(lines)
    ]
    front = "Pareto front", [(1e-3, 1e-2), (1e-2, 1e-4), (0.9, 1e-5)]
    return draw_precision("test", "(a) crowded", series, "error", front, ("the truth is known", 3e-6))


def test_each_line_has_a_plot_over_the_same_axes():
    charts = crowded()
    assert [chart.name for chart in charts] == [f"test-{n}" for n in range(1, 10)]
    for number, chart in enumerate(charts):
        named = re.findall('data-label="([^"]+)" data-values="([^"]*)"', chart.svg)
        assert [name for name, _ in named][:3] == ["the truth is known", "Pareto front", f"line {number}"]
        assert len(dict(named)[f"line {number}"].split()) == 3
        assert ("failed a check" in dict(named)) == (number == 3)
        behind = re.findall(r'<g class="steel"[^>]*><path d="[^"]+" fill="none"[^>]+/><circle', chart.svg)
        assert len(behind) == 9, "all lines behind it, which say nothing"
    assert len({re.findall('data-x="[^"]+"', chart.svg)[0] for chart in charts}) == 1


def test_ticks_are_powers_of_ten():
    first, *_ = crowded()
    said = [re.sub("<[^>]+>", "", text) for text in re.findall("<text.*?</text>", first.svg)]
    assert {"10⁻³", "10⁻²", "10⁻⁵", "10⁻⁴"} & set(said)
    assert not [word for word in said if re.fullmatch(r"\d+e-?\d+", word)]


def test_a_diagram_without_points_is_none():
    """A scene may refuse every setting of a panel."""
    empty = [Series("quad4", [], [], [])]
    assert draw_precision("empty", "(b)", empty, "error", ("Pareto front", []), ("", math.nan)) == []
