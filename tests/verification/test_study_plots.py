"""Verification: charts of studies show the numbers that they are given, where they belong, and say what they are."""

import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from postprocess.figures.loglog import RINGS, SweepAxis, SweepLine, draw_plates, draw_sweep
from postprocess.figures.plates import draw_mode
from postprocess.figures.rows import (
    BandBar,
    InputPanel,
    draw_bands,
    draw_histogram,
    draw_inputs,
    draw_sensitivity,
)
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Boxes, Shades, Span
from postprocess.units import SI

SVG = "{http://www.w3.org/2000/svg}"


def words(chart: Chart) -> list[str]:
    return ["".join(text.itertext()) for text in ElementTree.fromstring(chart.svg).iter(SVG + "text")]


def said(chart: Chart) -> dict[str, list[str]]:
    """What pages show, by label."""
    found = re.findall('data-label="([^"]+)" data-values="([^"]*)"', chart.svg)
    return {label: values.replace("\N{NO-BREAK SPACE}", "_").split(" ") for label, values in found}


def boxes(svg: str, colour: str) -> np.ndarray:
    """Left, top, right and bottom of the boxes of a colour."""
    (path,) = re.findall(rf'<g class="{colour}"[^>]*><path d="(M[^"]*H[^"]*)"', svg)
    return np.array(re.findall(r"M(\S+) (\S+)H(\S+)V(\S+?)H", path), float)


def test_boxes_are_where_their_ends_are():
    ends = np.array([[0.0, 1.0], [1.0, 3.0]]), np.array([[0.0, 2.0], [0.0, 4.0]])
    plot = Plot((Boxes("share", *ends, "green", [2.0, 4.0]),), Axis(low=0.0, high=4.0))
    svg = draw_chart("n", "", (plot,), Axis(margin=0.0)).svg
    first, second = boxes(svg, "green")
    (box,) = re.findall('data-box="([^"]*)"', svg)
    left, top, right, bottom = map(float, box.split())
    third = (right - left) / 3.0
    assert first == pytest.approx([left, 0.5 * (top + bottom), left + third, bottom], abs=0.5)
    assert second == pytest.approx([left + third, top, right, bottom], abs=0.5)
    centres = re.findall(r"M(\S+) (\S+?)Z", svg.split("data-values")[1])
    assert [float(x) for x, _ in centres] == pytest.approx([left + 0.5 * third, left + 2.0 * third], abs=0.02)


def test_a_span_without_width_is_a_line():
    svg = draw_chart(
        "n", "", (Plot((Span("here", 2.0, 2.0), Span("", 0.0, 1.0))),), Axis(low=0.0, high=4.0)
    ).svg
    assert (svg.count('fill-opacity="0.1"'), svg.count('stroke-dasharray="2 2"')) == (1, 1)


def test_colours_of_numbers():
    """Ends and middle of viridis; next to no variation is drawn in next to one colour."""
    shades = Shades.of(np.array([1.0, np.nan, 100.0]), is_log=True)
    assert shades.colours(np.array([1.0, 10.0, 100.0])) == ["#440154", "#21918c", "#fde725"]
    assert [SI.rendered(key.label) for key in shades.keys("kN")] == [
        "1 kN",
        "2 kN",
        "5 kN",
        "10 kN",
        "20 kN",
        "50 kN",
        "100 kN",
    ]
    assert set(Shades.of(np.array([5.0, 5.0 + 1e-5])).colours(np.array([5.0, 5.0 + 1e-5]))) == {"#21918c"}


def test_a_histogram_says_each_share():
    chart = draw_histogram(np.array([0.0, 1e5, 2e5]), np.array([1, 3]), [(5, 2e4), (95, 1.8e5)], 1.5e5)
    assert said(chart) == {"fraction": ["25", "75"]}
    assert {"5 %", "95 %", "the scene's own values", "peak force [kN]", "fraction [%]"} <= set(words(chart))
    low, high = boxes(chart.svg, "steel")
    assert high[3] - high[1] == pytest.approx(3.0 * (low[3] - low[1]), rel=0.02)


def test_sensitivity_is_a_row_an_input():
    inputs = [
        {"key": key, "first_order": s, "total": 2 * s}
        | {"first_order_interval": [s, s], "total_interval": [s, 3 * s]}
        for key, s in (("a.x", 0.4), ("b.y", 0.1))
    ]
    chart = draw_sensitivity(inputs)
    assert said(chart) == {"alone": ["0.4", "0.1"], "with interactions": ["0.8", "0.2"]}
    assert chart.svg.count('data-at="a.x b.y"') == 2
    first, second = boxes(chart.svg, "fe")
    assert first[1] < second[1], "the first on top"
    assert first[2] - first[0] == pytest.approx(4.0 * (second[2] - second[0]), rel=0.05)


def test_a_sweep_runs_from_stiff_to_soft_in_per_cent():
    axis = SweepAxis([100.0, 10.0, 1.0], [True, True, False], 30.0)
    lines = [
        SweepLine("FE", [1e-4, 1e-2, 0.5], [1e-5, 0.0, math.nan]),
        SweepLine("ring", [1e-4] * 3, form=RINGS),
    ]
    chart = draw_sweep("s", axis, lines, "size", "", (0.01,))
    assert said(chart) == {"FE": ["0.01", "1"], "failed a check": ["50"], "ring": ["0.01"] * 3}
    assert {"size [%]", "1 %", "numerical error", "the scene's plate", "failed"} <= set(words(chart))
    xs = [float(x) for x in re.findall(r"M([\d.]+) [\d.]+Z", chart.svg.split('data-label="ring"')[1])]
    assert xs == sorted(xs)


def bar(strike: int, dots: tuple[tuple[str, float, bool], ...] = ()) -> BandBar:
    return BandBar(f"raw, strike {strike}", strike, (400.0, 500.0, 700.0), 450.0, dots)


def test_bands_say_their_ends_and_the_rows_of_the_paper():
    chart = draw_bands([bar(1), bar(2, (("a", 600.0, False), ("b", 650.0, True)))])
    found = said(chart)
    assert found["first strike"] == found["second strike"] == ["400_to_700_kN,_median_500_kN"]
    assert (found["measured"], found["projected by the authors"]) == (["600_kN"], ["650_kN"])
    assert {"a", "b", "raw, strike 1", "peak lateral force [kN]"} <= set(words(chart))
    first, second = boxes(chart.svg, "fe")[0], boxes(chart.svg, "rigid")[0]
    assert first[[0, 2]] == pytest.approx(second[[0, 2]])
    assert first[3] < second[1]


def test_inputs_have_a_chart_each_and_one_legend():
    x = np.linspace(0.5, 5.0, 4)
    lines = {
        "peak [kN]": {1: {"raw": x, "50 ms": 2 * x}, 2: {"raw": 3 * x}},
        "duration [ms]": {1: {"duration": x}},
    }
    panels = [InputPanel(f"against-{n}", f"input {n} [m]", x, 2.0, n == 1, lines) for n in (0, 1)]
    legend, *charts = draw_inputs("Against", panels)
    assert [chart.name for chart in charts] == ["against-0", "against-1"]
    assert words(legend) == [
        "first strike, raw",
        "first strike, 50 ms",
        "second strike, raw",
        "the scene's own",
    ]
    assert said(legend) == {}
    assert "first strike, raw" not in words(charts[0])
    assert said(charts[0])["second strike, raw"] == ["1.5", "6", "10.5", "15"]
    assert {"0.5", "1", "2", "5"} <= set(words(charts[1])), "round ticks of a logarithmic axis"
    assert charts[0].caption == "Against input 0"


def test_plates_that_are_not_to_be_relied_on_are_red():
    panels = {"peak [kN]": {1: ([9.0, 5.0, 4.0], 4.0)}}
    chart = draw_plates([2.0, 4.0, 8.0], [False, True, True], panels)
    assert said(chart) == {"first strike": ["5", "4"], "not to be relied on": ["9"]}


def test_a_mode_says_how_far_its_outline_moves():
    places = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    chart = draw_mode(
        "m", "a mode", places, np.array([[0, 1, 2, 3]]), np.array([[0, 1.0], [0, 0], [0, 0], [0.5, 0]])
    )
    assert said(chart) == {"displacement": ["1", "0", "0", "0.5"]}
    assert 'data-at="0\xa0m;\xa00\xa0m 2\xa0m;\xa00\xa0m ' in chart.svg
    assert words(chart) == [], "no axes"
    assert chart.svg.count("<rect") == 1, "the paper, and no frame"
