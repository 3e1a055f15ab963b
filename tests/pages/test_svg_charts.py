"""Verify that charts are XML with round ticks and correct numbers."""

import itertools
import math
import re
from dataclasses import replace
from unittest.mock import Mock
from xml.etree import ElementTree

import numpy as np
import pytest
from browser.charts import points_of
from chart_samples import SVG, boxes, columns, path_of, shown, texts

from postprocess.figures import studies
from postprocess.figures.plates import VERDICTS, MapAxis, draw_map, draw_meanings
from postprocess.svg.areas import Boxes, Layer, Span
from postprocess.svg.chart import FULL, Axis, Chart, Plot, framed
from postprocess.svg.marks import PALETTE, Level, Line, Swatch, Words, text_width
from postprocess.svg.scales import Scale, Shades, cells_about, fitted, round_ticks
from postprocess.units import SI, measure
from tailslap.scene.read import read_scene
from tailslap.studies.stability.cell_verdicts import MAP_KINDS as KINDS
from tailslap.studies.stability.stability_axes import axes_of

X = np.linspace(0.0, 2.0, 5)


@pytest.mark.parametrize("low", [-3.7e-9, 0.0, 12.3, -5.0e7])
@pytest.mark.parametrize("span", [1e-12, 0.38, 4.0, 99.0, 6.1e8])
def test_ticks_are_round_and_in_range(low, span):
    """Two to six multiples of 1, 2 or 5 powers of ten."""
    if span < 1e-6 * abs(low):
        low = 0.0
    ticks = round_ticks(low, low + span, 6)
    step = np.diff(ticks)
    assert float(f"{step[0]:.3e}".split("e")[0]) in (1.0, 2.0, 5.0)
    np.testing.assert_allclose(step, step[0], rtol=1e-6)
    np.testing.assert_allclose(np.array(ticks) / step[0], np.round(np.array(ticks) / step[0]), atol=1e-5)
    assert 2 <= len(ticks) <= 7
    assert low - 1e-6 * span <= ticks[0] <= ticks[-1] <= low + (1.0 + 1e-6) * span


def test_logarithmic_scales():
    """Decades are equally spaced, with ticks at 1, 2, 5 within one."""
    scale = Scale(1e-4, 1e2, 0.0, 600.0, is_log=True)
    np.testing.assert_allclose(scale.at([1e-4, 1e-3, 1.0, 1e2]), [0.0, 100.0, 400.0, 600.0])
    assert scale.ticks(6) == pytest.approx([1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0])
    assert Scale(1.0, 10.0, is_log=True).ticks(6) == [1.0, 2.0, 5.0, 10.0]
    assert Scale(3.0, 4.0, is_log=True).ticks(6) == pytest.approx([3.0, 3.2, 3.4, 3.6, 3.8, 4.0])


def test_ranges():
    assert fitted(0.0, 1.0, 0.05) == pytest.approx((-0.05, 1.05))
    assert (fitted(7.0, 7.0), fitted(0.0, 0.0)) == (pytest.approx((6.3, 7.7)), (-1.0, 1.0))
    assert fitted(np.inf, -np.inf) == (0.0, 1.0)


def drawn(*marks):
    return Chart("name", 'a "caption" < b', (Plot(marks, Axis("v_GX [m/s]")),), Axis("t [s]")).svg


def test_points_are_where_their_values_are():
    """Positions lie between the ends of both axes and the ticks."""
    svg = drawn(Line("FE", X, X**2))
    root = ElementTree.fromstring(svg)
    (plot,) = [element for element in root.iter() if element.get("class") == "plot"]
    x_min, top, right, bottom = map(float, plot.get("data-box", "").split())
    low, high = map(float, root.findall(".//*[@class='x-axis']")[0].get("data-ends", "").split())
    points = points_of(path_of(svg, "FE"))
    np.testing.assert_allclose(low + (points[:, 0] - x_min) / (right - x_min) * (high - low), X, atol=1e-4)
    assert (points[:, 1].min() > top, points[:, 1].max() < bottom) == (True, True)
    ends = [element for element in root.iter(SVG + "text") if element.get("text-anchor") == "end"]
    tick = {"".join(element.itertext()): float(element.get("y", "nan")) - 4.0 for element in ends}
    assert points[[-1, 0], 1] == pytest.approx([tick["4"], tick["0"]], abs=0.02)


def test_words_are_escaped_and_subscripts_set():
    svg = drawn(Line("a < b & c", X, X), Words("v_GY", 1.0, 1.0))
    root = ElementTree.fromstring(svg)
    assert root.get("aria-label") == 'a "caption" < b'
    assert "a < b & c" in texts(svg)
    assert {"GX", "GY"} <= {element.text for element in root.iter(SVG + "tspan")}


def test_gaps_are_gaps():
    line = Line("FE", X, np.array([0.0, 1.0, np.nan, 2.0, 3.0]))
    assert path_of(drawn(line), "FE").count("M") == 2
    assert shown(Chart("n", "", (Plot((line,)),), Axis("t [s]"))) == {"FE": ["0", "1", "2", "3"]}


def boxes_of_words(root):
    """Return text, ends and height of the words in a plot [pixels]."""
    plot = next(group for group in root.iter(SVG + "g") if group.get("data-box"))
    named = [group for group in plot.iter(SVG + "g") if group.get("class") in ("marks", "beside")]
    boxes = []
    for text in (element for group in named for element in group.iter(SVG + "text")):
        x, y = (float(text.get(name, "nan")) for name in "xy")
        wide = text_width(text.text or "", 11.0)
        start = x - {"middle": 0.5, "end": 1.0}.get(text.get("text-anchor", ""), 0.0) * wide
        boxes.append((text.text, start, start + wide, y))
    return boxes


@pytest.mark.parametrize(("failed", "plate"), [((9.6, 10.0), 9.0), ((9.0, 9.8), 9.4), ((0.0, 0.5), 10.0)])
def test_names_of_spans_and_levels_cover_no_other_and_stay_in_the_plot(failed, plate):
    """Spans at the right end, where names of levels stand."""
    marks = (
        Span("failed", *failed),
        Span("the scene's plate", plate, plate),
        *(Level("design", value) for value in (9.8, 9.9, 10.0)),
    )
    line = Line("FE", np.array([0.0, 10.0]), np.array([0.0, 10.0]))
    chart = Chart("name", "caption", (Plot((line, *marks), Axis("size [%]")),), Axis(margin=0.0))
    boxes = boxes_of_words(ElementTree.fromstring(chart.svg))
    assert len(boxes) == 5
    assert all(0.0 < start < end <= chart.width for _, start, end, _ in boxes)
    for (_, start, end, y), (_, other_start, other_end, other_y) in itertools.combinations(boxes, 2):
        assert end < other_start or other_end < start or abs(y - other_y) >= 11.0


def test_names_of_levels_stand_at_their_lines():
    """Above them, or below where there is no room."""
    marks = [Level("", value) for value in (0.1, 1.0, 5.0, 10.0)]
    y = Axis("size [%]", low=1e-6, high=20.0, is_log=True)
    root = ElementTree.fromstring(Chart("name", "caption", (Plot(tuple(marks), y),), Axis()).svg)
    frame = next(box for element in root.iter() if (box := element.get("data-box"))).split()
    top, bottom = float(frame[1]), float(frame[3])
    groups = [group for group in root.iter(SVG + "g") if group.get("data-at")]
    for group, value in zip(groups, (10.0, 5.0, 1.0, 0.1), strict=True):
        line = top + (bottom - top) * math.log10(20.0 / value) / math.log10(20.0 / 1e-6)
        name = next(group.iter(SVG + "text"))
        assert name.text == f"{value:g} %"
        assert float(group.get("data-at", "nan")) == pytest.approx(line, abs=0.01)
        assert float(name.get("y", "nan")) - line in (
            pytest.approx(-3.0, abs=0.02),
            pytest.approx(11.0, abs=0.02),
        )


PARTS = ("plot", "key", "marks", "ticks", "beside", "x-axis", "y-axis", "moving")
"""Classes by which pages find the parts of a chart."""


def test_the_legend_names_what_is_drawn_once():
    marks = Span("front", 0.0, 1.0), Layer("strain", X, 0.0 * X, X), Line("FE", X, X)
    svg = drawn(*marks, Swatch("60 kN", "#123456"))
    root, words = ElementTree.fromstring(svg), texts(svg)
    assert [words.count(label) for label in ("front", "strain", "FE", "60 kN")] == [1] * 4
    assert {element.get("class") for element in root.iter(SVG + "g")} - {None, *PARTS} <= set(PALETTE)


def test_a_long_legend_takes_rows():
    """Keys stay within the width, and push the plot down."""
    few, many = (drawn(*(Line(f"a long name {i}", X, X) for i in range(n))) for n in (1, 9))
    lower, higher = (float(ElementTree.fromstring(svg).get("height", "nan")) for svg in (few, many))
    assert higher > lower + 30.0
    shifts = re.findall(r"translate\(([\d.]+) ", many)
    assert max(map(float, shifts)) + 100.0 < 400.0


def test_boxes_are_where_their_ends_are():
    ends = np.array([[0.0, 1.0], [1.0, 3.0]]), np.array([[0.0, 2.0], [0.0, 4.0]])
    plot = Plot((Boxes("share", *ends, "green", [2.0, 4.0]),), Axis(low=0.0, high=4.0))
    svg = Chart("n", "", (plot,), Axis(margin=0.0)).svg
    first, second = boxes(svg, "green")
    (box,) = re.findall('data-box="([^"]*)"', svg)
    x_min, top, right, bottom = map(float, box.split())
    third = (right - x_min) / 3.0
    assert first == pytest.approx([x_min, 0.5 * (top + bottom), x_min + third, bottom], abs=0.5)
    assert second == pytest.approx([x_min + third, top, right, bottom], abs=0.5)
    centres = re.findall(r"M(\S+) (\S+?)Z", svg.split('data-label="share"')[2])
    assert [float(x) for x, _ in centres] == pytest.approx(
        [x_min + 0.5 * third, x_min + 2.0 * third], abs=0.02
    )


def test_a_span_without_width_is_a_line():
    plot = Plot((Span("here", 2.0, 2.0), Span("", 0.0, 1.0)))
    svg = Chart("n", "", (plot,), Axis(low=0.0, high=4.0)).svg
    assert (svg.count('fill-opacity="0.1"'), svg.count('stroke-dasharray="2 2"')) == (1, 1)


def test_colours_of_numbers():
    """A constant field has one colour, the range viridis."""
    shades = Shades.of(np.array([1.0, np.nan, 100.0]), is_log=True)
    assert shades.colours(np.array([1.0, 10.0, 100.0])) == ["#440154", "#21918c", "#fde725"]
    labels = [SI.rendered(label) for label, _ in shades.keys("kN")]
    assert labels == [f"{n} kN" for n in (1, 2, 5, 10, 20, 50, 100)]
    assert set(Shades.of(np.array([5.0, 5.0 + 1e-5])).colours(np.array([5.0, 5.0 + 1e-5]))) == {"#21918c"}


def test_a_histogram_says_each_share():
    edges, counts = np.array([0.0, 1e5, 2e5]), np.array([1, 3])
    chart = studies.draw_histogram(edges, counts, [(5, 2e4), (95, 1.8e5)], 1.5e5)
    assert shown(chart) == {"fraction": ["25", "75"]}
    words = {"5 %", "95 %", "the scene's own values", "peak force [kN]", "fraction [%]"}
    assert words <= set(texts(chart.svg))
    low, high = boxes(chart.svg, "steel")
    assert high[3] - high[1] == pytest.approx(3.0 * (low[3] - low[1]), rel=0.02)


def test_sensitivity_is_a_row_an_input():
    parts = ("first_order", 1, 1), ("total", 2, 2), ("first_order_interval", 1, 1), ("total_interval", 1, 3)
    inputs = [
        {"key": key} | {name: [a * s, b * s] if "_interval" in name else a * s for name, a, b in parts}
        for key, s in (("a.x", 0.4), ("b.y", 0.1))
    ]
    chart = studies.draw_sensitivity(inputs)
    assert shown(chart) == {"alone": ["0.4", "0.1"], "with interactions": ["0.8", "0.2"]}
    assert [at for _, at, _ in columns(chart).values()] == [["a.x", "b.y"]] * 2
    first, second = boxes(chart.svg, "fe")
    assert first[1] < second[1], "the first on top"
    assert first[2] - first[0] == pytest.approx(4.0 * (second[2] - second[0]), rel=0.05)


def test_a_sweep_runs_from_stiff_to_soft_in_per_cent():
    axis = studies.SweepAxis([100.0, 10.0, 1.0], [True, True, False], 30.0)
    fe = studies.SweepLine("FE", [1e-4, 1e-2, 0.5], [1e-5, 0.0, math.nan])
    other = studies.SweepLine("other", [1e-4] * 3, passed=[True] * 3)
    chart = studies.draw_sweep("s", axis, [fe, other], "size", "", (0.01,))
    expected = {
        "FE": ["0.01", "1"], "failed a check": ["50"], "numerical error": ["0.001"], "other": ["0.01"] * 3,
    }  # fmt: skip
    assert shown(chart) == expected
    assert {"size [%]", "1 %", "numerical error", "the scene's plate", "failed"} <= set(texts(chart.svg))
    xs = [float(x) for x in re.findall(r"M([\d.]+) [\d.]+Z", chart.svg.split('data-label="other"')[1])]
    assert xs == sorted(xs)


def test_bands_say_their_ends():
    ends = 400.0, 500.0, 700.0
    chart = studies.draw_bands([studies.BandBar(f"raw, strike {k}", k, ends, 450.0) for k in (1, 2)])
    titles = shown(chart)
    assert titles["first strike"] == titles["second strike"] == ["400 to 700 kN, median 500 kN"]
    assert {"raw, strike 1", "peak lateral force [kN]"} <= set(texts(chart.svg))
    first, second = boxes(chart.svg, "fe")[0], boxes(chart.svg, "rigid")[0]
    assert first[[0, 2]] == pytest.approx(second[[0, 2]])
    assert first[3] < second[1]


def crowded(lines=9):
    """Lines that end within a tenth of a decade, with one failure."""
    series = []
    for n in range(lines):
        errors = [1e-2 * (n + 1), 1e-4 * (n + 1), 1e-5 * (1.0 + 0.02 * n)]
        times, passed, meshes = (
            [1e-3, 1e-2, 0.9 + 0.01 * n], [True, n != 3, True], ["10 x 3", "20 x 6", "40 x 12"],
        )  # fmt: skip
        series.append(studies.Series(f"line {n}", times, errors, passed, meshes))
    front = "Pareto front", [(1e-3, 1e-2), (1e-2, 1e-4), (0.9, 1e-5)]
    return studies.draw_precision("test", "(a) crowded", series, "error", front, ("the truth is known", 3e-6))


def test_a_diagram_has_a_line_a_method_front_and_floor():
    """A point names its mesh, and colour and dashes identify a line."""
    (diagram,) = crowded()
    by_label = columns(diagram)
    assert (diagram.name, diagram.width) == ("test", FULL)
    lines = [f"line {n}" for n in range(9)]
    assert [*by_label] == ["the truth is known", "Pareto front", *lines[:4], "failed a check", *lines[4:]]
    assert by_label["the truth is known"][2] == ["3e-06", "3e-06"]
    assert by_label["Pareto front"][2][:3] == ["0.01", "0.01", "0.0001"]
    for n, line in enumerate(lines):
        assert by_label[line][1] == ["10 x 3", "20 x 6", "40 x 12"]
        np.testing.assert_allclose(float(by_label[line][2][0]), 1e-2 * (n + 1), rtol=1e-5)
    assert by_label["failed a check"][2] == ["0.0004"]
    assert diagram.svg.count("<title>20 x 6</title>") == 9
    marks = [mark for mark in diagram.plots[0].marks if mark.label in lines and isinstance(mark, Line)]
    assert len({(mark.colour, mark.dashes) for mark in marks}) == 9


def test_names_at_the_ends_of_lines_do_not_overlap():
    """Nine names are in rows of 12 pixels within the frame."""
    (diagram,) = crowded()
    every = ElementTree.fromstring(diagram.svg).iter(SVG + "text")
    texts = [text for text in every if text.get("class") == "halo"]
    assert sorted("".join(text.itertext()) for text in texts) == [f"line {n}" for n in range(9)]
    heights = sorted(float(text.get("y", "nan")) for text in texts)
    assert min(np.diff(heights)) > 9.0
    assert all(0.0 < float(text.get("x", "nan")) < diagram.width for text in texts)


def test_a_diagram_without_points_is_none():
    """A scene may refuse every setting of a panel."""
    empty = [studies.Series("quad4", [], [], [])]
    assert studies.draw_precision("empty", "(b)", empty, "error", ("Pareto front", []), ("", math.nan)) == []


AXES = {axis.name: axis for axis in axes_of(read_scene("paper-table-3")[0], 10)}


ROUND = [
    *(("stiffness", ["10⁻⁴", "0.01", "1", "100", "10⁴"]), ("penalty", ["0.01", "1", "100", "10⁴"])),
    *(("friction", ["0.0", "0.5", "1.0", "1.5", "2.0"]), ("speed", ["0.01", "0.1", "1", "10"])),
    *(("angle", ["1", "10", "100"]), ("slenderness", ["0.01", "0.1", "1"])),
    *(("time step", ["0.6", "0.8", "1.0", "1.2"]), ("damping", ["0", "0.01", "0.1", "1"])),
]


@pytest.mark.parametrize(("name", "texts"), ROUND)
def test_ticks_of_the_study_are_round(name, texts):
    assert [text for _, text in MapAxis("", AXES[name].values).axis.named or ()] == texts


def test_cells_are_of_equal_size_on_the_axis_own_scale():
    """0 stands one ratio below the next value."""
    axis = MapAxis("", [0.0, 0.01, 0.1, 1.0]).axis
    assert (axis.low, axis.high) == pytest.approx((10.0**-3.5, 10.0**0.5))
    assert (axis.named or ())[0] == (pytest.approx(1e-3), "0")
    assert MapAxis("", [1.0, 2.0, 3.0]).axis.is_log is False
    assert cells_about(np.array([1.0, 4.0, 2.0]), False).tolist() == [[0.5, 1.5], [3.0, 5.0], [1.5, 3.0]]
    assert cells_about(np.array([1.0, 100.0, 1e4]), True)[:, 0] == pytest.approx([0.1, 10.0, 1e3])
    assert cells_about(np.array([0.0, 1.0]), False)[0].tolist() == [0.0, 0.5], "no friction below zero"


def small_map(points, across, up):
    map_axes = axes_of(read_scene("paper-table-3")[0], points)
    axes = {axis.name: MapAxis(axis.meaning, axis.values) for axis in map_axes}
    return draw_map("m", axes[across], axes[up], [["right"] * points] * points, "")


def test_each_cell_says_its_values_and_its_verdict():
    across, up = MapAxis("a", [0.0, 0.01, 0.1]), MapAxis("b", [1.0, 2.0])
    chart = draw_map("m", across, up, [["right", "caught", "right"], ["wrong", "right", "right"]], "")
    svg = chart.svg
    where, at, verdicts = columns(chart)["verdict"]
    assert verdicts == ["right", "caught", "right", "wrong", "right", "right"]
    assert (where, at[-1]) == ("a; b", "0.1; 2")
    red, *other_paths = re.findall(r'<g class="red"[^>]*><path d="([^"]*)"', svg)
    assert (red.count("M"), other_paths) == (1, [])
    x_min, top = map(float, re.findall(r"M([\d.]+) ([\d.]+)", red)[0])
    places = [tuple(map(float, p)) for p in re.findall(r"M([\d.]+) ([\d.]+)Z", svg)]
    assert (x_min, top) < places[3], "the fourth cell, the first of the upper row"
    assert places[3][0] == places[0][0]
    assert places[3][1] < places[0][1]


@pytest.mark.parametrize("points", [2, 3, 4, 10, 40])
def test_tick_labels_do_not_overlap(points):
    for across, up in itertools.pairwise([*AXES, next(iter(AXES))]):
        root = ElementTree.fromstring(small_map(points, across, up).svg)
        words = [("".join(text.itertext()), text) for text in root.iter(SVG + "text")]
        middle = {"text-anchor": "middle", "font-size": "11"}.items()
        centred = [(said, text) for said, text in words if middle <= text.attrib.items()]
        below = [(float(text.get("x", "0")), text_width(said, 11.0)) for said, text in centred]
        beside = [float(text.get("y", "0")) for _, text in words if text.get("text-anchor") == "end"]
        for (x, wide), (next_x, next_wide) in itertools.pairwise(sorted(below)):
            assert next_x - x > 0.5 * (wide + next_wide)
        assert all(after - before > 11.0 for before, after in itertools.pairwise(sorted(beside)))


def test_legend_says_what_every_colour_means():
    assert list(KINDS) == list(VERDICTS)
    chart = draw_meanings(KINDS, "what the colours mean")
    for kind, meaning in KINDS.items():
        assert f">{kind}: {meaning}<" in chart.svg
        assert f'class="{VERDICTS[kind]}"' in chart.svg
        assert text_width(f"{kind}: {meaning}", 11.0) + 24.0 <= chart.width


@pytest.mark.parametrize("row", [0, 2])
def test_curves_stay_below_the_names_of_spans(row):
    """The largest value is below the last row of names."""
    line = Line("force", np.array([0.0, 1.0, 2.0]), np.array([0.0, 5.0, 1.0]))
    spans = (Span("front", 0.5, 1.5, row=row),)
    (free,) = framed([Plot((line,), Axis("force"))], Axis("t"), 520.0, 0.0)
    (named,) = framed([Plot((*spans, line), Axis("force"))], Axis("t"), 520.0, 0.0)
    assert named.y.low == free.y.low
    gap = free.y.at(5.0) - free.y.end
    assert named.y.at(5.0) - named.y.end >= gap + 11.0 * (row + 1) * 0.9
    assert free.y.high < named.y.high < 2.0 * free.y.high


def test_marks_are_drawn_once_for_file_and_page(monkeypatch):
    """A chart without measures in its caption is itself in SI."""
    draw = Mock(side_effect=Line.draw)
    monkeypatch.setattr(Line, "draw", lambda *given: draw(*given))
    chart = Chart("c", "Caption", (Plot((Line("y", np.arange(2.0), np.arange(2.0)),)),), Axis("x [m]"))
    assert chart.svg
    assert chart.in_units(SI).on_page
    draw.assert_called_once()
    assert replace(chart, caption=measure(2.0, "m")).in_units(SI).caption == "2 m"
