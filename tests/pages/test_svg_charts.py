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
from chart_samples import samples

from postprocess.figures import studies
from postprocess.figures.histories import Curve, draw_histories, draw_overlay, thinned
from postprocess.figures.impact import LINES, Forces, draw_forces
from postprocess.figures.plates import VERDICTS, MapAxis, draw_map, draw_meanings
from postprocess.svg.areas import Boxes, Layer, Span
from postprocess.svg.chart import FULL, Axis, Chart, Plot, framed
from postprocess.svg.marks import PALETTE, Level, Line, Swatch, Words, text_width
from postprocess.svg.scales import Scale, Shades, cells_about, fitted, round_ticks
from postprocess.units import SI, measure
from tailslap.scene.read import read_scene
from tailslap.studies.stability.cell_verdicts import MAP_KINDS as KINDS
from tailslap.studies.stability.stability_axes import axes_of

SVG = "{http://www.w3.org/2000/svg}"
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


def chart(*marks, **options):
    plot = Plot(marks, Axis("v_GX [m/s]"), **options)
    return ElementTree.fromstring(Chart("name", 'a "caption" < b', (plot,), Axis("t [s]")).svg)


def places(root, label):
    (path,) = [element for element in root.iter(SVG + "path") if element.get("data-label") == label]
    return points_of(path.get("d", ""))


def test_points_are_where_their_values_are():
    """Positions lie between the ends of both axes and the ticks."""
    root = chart(Line("FE", X, X**2))
    (plot,) = [element for element in root.iter() if element.get("class") == "plot"]
    x_min, top, right, bottom = map(float, plot.get("data-box", "").split())
    low, high = map(float, root.findall(".//*[@class='x-axis']")[0].get("data-ends", "").split())
    points = places(root, "FE")
    np.testing.assert_allclose(low + (points[:, 0] - x_min) / (right - x_min) * (high - low), X, atol=1e-4)
    assert (points[:, 1].min() > top, points[:, 1].max() < bottom) == (True, True)
    ends = [element for element in root.iter(SVG + "text") if element.get("text-anchor") == "end"]
    tick = {"".join(element.itertext()): float(element.get("y", "nan")) - 4.0 for element in ends}
    assert points[[-1, 0], 1] == pytest.approx([tick["4"], tick["0"]], abs=0.02)


def test_words_are_escaped_and_subscripts_set():
    root = chart(Line("a < b & c", X, X), Words("v_GY", 1.0, 1.0))
    assert root.get("aria-label") == 'a "caption" < b'
    assert "a < b & c" in ["".join(element.itertext()) for element in root.iter(SVG + "text")]
    assert sorted(element.text for element in root.iter(SVG + "tspan") if element.text in ("GX", "GY")) == [
        "GX",
        "GY",
    ]


def test_gaps_are_gaps():
    y = np.array([0.0, 1.0, np.nan, 2.0, 3.0])
    root = chart(Line("FE", X, y))
    (path,) = [element for element in root.iter(SVG + "path") if element.get("data-label") == "FE"]
    assert path.get("d", "").count("M") == 2
    drawn = Chart("n", "", (Plot((Line("FE", X, y),)),), Axis("t [s]"))
    assert shown(drawn) == {"FE": ["0", "1", "2", "3"]}


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
    drawn = Chart("name", "caption", (Plot((line, *marks), Axis("size [%]")),), Axis(margin=0.0))
    boxes = boxes_of_words(ElementTree.fromstring(drawn.svg))
    assert len(boxes) == 5
    assert all(0.0 < start < end <= drawn.width for _, start, end, _ in boxes)
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
    root = chart(*marks, Swatch("60 kN", "#123456"))
    words = ["".join(element.itertext()) for element in root.iter(SVG + "text")]
    assert [words.count(label) for label in ("front", "strain", "FE", "60 kN")] == [1] * 4
    assert {element.get("class") for element in root.iter(SVG + "g")} - {None, *PARTS} <= set(PALETTE)


def test_a_long_legend_takes_rows():
    """Keys stay within the width, and push the plot down."""
    few, many = (chart(*(Line(f"a long name {i}", X, X) for i in range(n))) for n in (1, 9))
    assert float(many.get("height", "nan")) > float(few.get("height", "nan")) + 30.0
    shifts = re.findall(r"translate\(([\d.]+) ", ElementTree.tostring(many).decode())
    assert max(map(float, shifts)) + 100.0 < 400.0


def drawn_in(chart):
    """Paths of a chart."""
    return ElementTree.fromstring(chart.svg).iter(SVG + "path")


def texts_of(chart):
    return ["".join(text.itertext()) for text in ElementTree.fromstring(chart.svg).iter(SVG + "text")]


def columns(chart):
    """Samples of a chart by label.

    Each has the heading of the positions, the positions and the values.
    """
    return {row.label: (row.where, row.at, row.values) for row in samples(chart)}


def shown(chart):
    """What pages show, by label."""
    return {label: values for label, (_, _, values) in columns(chart).items()}


def boxes(svg, colour):
    """Left, top, right and bottom of the boxes of a colour."""
    (path,) = re.findall(rf'<g class="{colour}"[^>]*><path d="(M[^"]*H[^"]*)"', svg)
    return np.array(re.findall(r"M(\S+) (\S+)H(\S+)V(\S+?)H", path), float)


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
    assert words <= set(texts_of(chart))
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
    assert {"size [%]", "1 %", "numerical error", "the scene's plate", "failed"} <= set(texts_of(chart))
    xs = [float(x) for x in re.findall(r"M([\d.]+) [\d.]+Z", chart.svg.split('data-label="other"')[1])]
    assert xs == sorted(xs)


def test_bands_say_their_ends():
    ends = 400.0, 500.0, 700.0
    chart = studies.draw_bands([studies.BandBar(f"raw, strike {k}", k, ends, 450.0) for k in (1, 2)])
    titles = shown(chart)
    assert titles["first strike"] == titles["second strike"] == ["400 to 700 kN, median 500 kN"]
    assert {"raw, strike 1", "peak lateral force [kN]"} <= set(texts_of(chart))
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


MOTION = ("v_gy", "v_gx", "theta", "omega", "slide")


def histories(n=2000):
    """A plate that rotates evenly, and the same with a ripple."""
    t = np.linspace(0.0, 0.38, n)
    theta = 0.26 - 0.684 * t
    phase = theta + 0.239
    columns = {"t": t, "theta": theta, "omega": np.full(n, 0.684), "slide": 25.0 * t}
    columns |= {"v_gx": 25.0 - 3.4 * np.sin(phase), "v_gy": -3.5 * np.cos(phase)}
    columns |= {"reaction_normal": -3000.0 + 4000.0 * t, "reaction_tangential": -1400.0 + 1900.0 * t}
    columns["kinetic_energy"] = 2.8e6 - 2.4e4 * t
    ripple = 1e-6 * np.sin(900.0 * t)
    fe = {name: values + ripple * (name != "t") for name, values in columns.items()}
    energies = {"strain_energy": 0.02 + 0 * t, "contact_energy": 0.05 - 0.1 * t}
    energies["vibration_energy"] = 1e-3 + 0 * t
    works = {"friction_work": -2.4e4 * t, "damping_work": -0.01 * t, "energy_error": 1e-5 * np.cos(50 * t)}
    return {**fe, **energies, **works}, columns


def texts(curve):
    root = ElementTree.fromstring(curve.svg)
    assert root.tag == SVG + "svg"
    elements = [element for element in root.iter() if element.tag == SVG + "text"]
    return ["".join(element.itertext()).replace("\u200b", "").strip() for element in elements]


@pytest.fixture(scope="module")
def curves():
    return {curve.name: curve for curve in draw_histories(*histories())}


def test_all_plots_are_there_in_order(curves):
    reaction = ("reaction_normal", "reaction_tangential")
    assert tuple(curves) == (*MOTION, *reaction, "energy_exchanged", "energy_stored", "energy_error")
    assert [curve.group for curve in curves.values()] == ["Motion"] * 5 + ["Reaction"] * 2 + ["Energy"] * 3


LABELS = [
    *(("theta", "θ [deg]"), ("omega", "ω [rad/s]"), ("v_gx", "vGX [m/s]"), ("v_gy", "vGY [m/s]")),
    *(("slide", "s [m]"), ("reaction_normal", "N [kN]"), ("reaction_tangential", "R [kN]")),
]


@pytest.mark.parametrize(("name", "label"), LABELS)
def test_plots_over_rigid_are_labelled(curves, name, label):
    """The power of ten of an angle is that of its degrees."""
    labels = texts(curves[name])
    for words in (label, "t [s]", "FE", "rigid, exact"):
        assert labels.count(words) == 1
    unit = label.split("[")[1].replace("kN", "N")
    power = "10⁻⁶" if name == "theta" else "10⁻⁹"
    assert f"FE − rigid [{power} {unit}" in labels


def test_energy_plots_are_labelled(curves):
    assert {"kinetic, change", "work of friction", "energy [kJ]"} <= {*texts(curves["energy_exchanged"])}
    stored = {*texts(curves["energy_stored"])}
    assert {"strain", "spring", "vibration", "damping", "energy [10⁻³ J]"} <= stored
    assert {"error", "energy [10⁻⁶ J]"} <= {*texts(curves["energy_error"])}


def test_kinetic_energy_is_shown_as_a_change(curves):
    numbers = [float(w.replace("−", "-")) for w in texts(curves["energy_exchanged"]) if w[-1].isdigit()]
    assert min(numbers) >= -10.0, "9.12 kJ are lost, of 2.8 MJ"
    assert max(numbers) <= 1.0


def test_the_ripple_is_drawn_at_its_size(curves):
    """The height of the difference is that of its scale."""
    assert {"−1000", "0", "1000"} <= {*texts(curves["slide"])}


def test_a_chart_has_no_ids_and_needs_nothing_beside_it(curves):
    """Charts on one page do not conflict, and each is a file."""
    for curve in curves.values():
        assert not re.search(r"\b(id|href)=|url\(", curve.svg)
        root = ElementTree.fromstring(curve.svg)
        assert root.get("aria-label") == curve.caption
        assert (float(root.get("width", "nan")), root.get("role")) == (curve.width, "img")


def test_values_are_those_of_the_history(curves):
    """Values at the pointer have five digits at all points."""
    fe, _ = histories()
    (path,) = [e for e in drawn_in(curves["slide"]) if e.get("data-label") == "FE"]
    where, at, values = columns(curves["slide"])["FE"]
    assert len(values) == len(points_of(path.get("d", "")))
    assert where == "t [s]"
    rows = np.abs(fe["t"] - np.array(at, float)[:, None]).argmin(axis=1)
    np.testing.assert_allclose(np.array(at, float), fe["t"][rows], rtol=1e-5)
    np.testing.assert_allclose(np.array(values, float), fe["slide"][rows], rtol=1e-5, atol=1e-12)


def test_only_what_the_histories_have_is_drawn():
    fe, rigid = histories(50)
    history = {k: fe[k] for k in ("t", "omega", "slide", "strain_energy")}
    few = draw_histories(history, {"t": rigid["t"], "omega": rigid["omega"]})
    assert [curve.name for curve in few] == ["omega", "energy_stored"]
    assert "spring" not in texts(few[1])


def test_rigid_history_at_other_instants():
    """Straight lines interpolate exactly, except rounding."""
    t, t_rigid = np.linspace(0.0, 1.0, 77), np.linspace(0.0, 1.0, 11)
    (curve,) = draw_histories({"t": t, "slide": 3.1 * t}, {"t": t_rigid, "slide": 3.1 * t_rigid})
    assert any("[10⁻¹⁵" in words or "[10⁻¹⁸" in words for words in texts(curve))


def test_a_run_that_went_wrong_is_still_drawn():
    """Other plots are unchanged, and the finite part is drawn."""
    fe, rigid = histories(900)
    good = {curve.name: curve for curve in draw_histories(fe, rigid)}
    for bad, points, label in ((np.nan, 100, ""), (np.inf, 100, ""), (1e300, 2, "10³⁰⁰")):
        broken = fe | {"omega": np.where(fe["t"] > 0.2, bad, fe["omega"])}
        curves = {curve.name: curve for curve in draw_histories(broken, rigid)}
        omega = curves["omega"]
        assert curves | {"omega": good["omega"]} == good
        assert points <= vertices(omega) <= vertices(good["omega"])
        for word in ("nan", "inf"):
            assert word not in omega.svg
        assert any(label in words for words in texts(omega))


def vertices(curve):
    """Of the line of the FE history."""
    (line,) = [e for e in drawn_in(curve) if e.get("data-label") == "FE"]
    return len(points_of(line.get("d", "")))


def many_lines():
    """Charts of four and more lines in one place."""
    t = np.linspace(0.0, 0.4, 9)
    fe, rigid = histories(50)
    curves = [Curve(f"result {k}", t, t) for k in range(7)]
    axis = studies.SweepAxis([100.0, 10.0, 1.0], [True] * 3, 30.0)
    lines = [studies.SweepLine(n, [1e-3] * 3) for n in "abcde"]
    return {
        "forces": draw_forces("", [Forces("f", t, dict.fromkeys(LINES, 1e3 * t))]),
        "results": draw_overlay("o", "F [kN]", curves, "", 340.0),
        "energies": next(c for c in draw_histories(fe, rigid) if c.name == "energy_stored"),
        "sweep": studies.draw_sweep("s", axis, lines, "size", "", ()),
    }


@pytest.mark.parametrize("name", many_lines())
def test_lines_differ_in_shape_and_hide_none_before(name):
    """Each line has dashes, or is narrower than those below it."""
    lines = [mark for mark in many_lines()[name].plots[0].marks if isinstance(mark, Line)]
    assert len(lines) > 3
    assert len({line.dashes for line in lines}) == len(lines)
    for number, line in enumerate(lines):
        assert line.dashes or all(line.width < earlier.width for earlier in lines[:number])


@pytest.mark.parametrize("name", many_lines())
def test_letters_are_nine_pixels_at_least(name):
    sizes = map(float, re.findall(r'font-size="([\d.]+)"', many_lines()[name].svg))
    assert min(sizes) >= 9.0


def test_thinning_keeps_ends_and_peaks():
    t = np.linspace(0.0, 1.0, 20_000)
    values = np.sin(5000.0 * t + 0.3)
    values[[7_001, 12_345]] = 9.0, -7.0
    kept_t, thin_values = thinned(t, values)
    assert len(thin_values) <= 322
    assert (thin_values.max(), thin_values.min()) == (9.0, -7.0)
    assert (kept_t[0], kept_t[-1], thin_values[0], thin_values[-1]) == (0.0, 1.0, values[0], values[-1])
    assert np.all(np.diff(kept_t) > 0)
    np.testing.assert_array_equal(thin_values, values[np.searchsorted(t, kept_t)])


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
