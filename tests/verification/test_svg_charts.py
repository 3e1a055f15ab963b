"""Verification: ticks of charts are round and in range, places are those of the values, and all of it is XML."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from postprocess.svg.chart import Axis, Plot, draw_chart
from postprocess.svg.drawing import PALETTE
from postprocess.svg.marks import Layer, Level, Line, Span, Swatch, Words
from postprocess.svg.scale import Scale, fitted, power_text, round_ticks, tick_texts

SVG = "{http://www.w3.org/2000/svg}"
X = np.linspace(0.0, 2.0, 5)


@pytest.mark.parametrize("low", [-3.7e-9, 0.0, 12.3, -5.0e7])
@pytest.mark.parametrize("span", [1e-12, 0.38, 4.0, 99.0, 6.1e8])
def test_ticks_are_round_and_in_range(low, span):
    """Multiples of 1, 2 or 5 times a power of ten, two to six of them."""
    if span < 1e-6 * abs(low):
        low = 0.0
    ticks = round_ticks(low, low + span, 6)
    step = np.diff(ticks)
    digits = float(f"{step[0]:.6g}".split("e")[0])
    while digits < 1.0:
        digits *= 10.0
    while digits >= 10.0:
        digits /= 10.0
    assert round(digits, 3) in (1.0, 2.0, 5.0)
    np.testing.assert_allclose(step, step[0], rtol=1e-6)
    np.testing.assert_allclose(np.array(ticks) / step[0], np.round(np.array(ticks) / step[0]), atol=1e-5)
    assert 2 <= len(ticks) <= 7
    assert low - 1e-6 * span <= ticks[0] <= ticks[-1] <= low + (1.0 + 1e-6) * span


@pytest.mark.parametrize(
    ("ticks", "texts"),
    [
        ([-0.5, 0.0, 0.5], ["−0.5", "0.0", "0.5"]),
        ([0.0, 200.0], ["0", "200"]),
        ([0.0, 2e-6, 4e-6], ["0", "2×10⁻⁶", "4×10⁻⁶"]),
        ([0.0, 1e6, 2e6], ["0", "10⁶", "2×10⁶"]),
        ([0.25], ["0.2"]),
        ([23.28, 23.30], ["23.28", "23.30"]),
    ],
)
def test_texts_of_ticks(ticks, texts):
    if len(ticks) > 1:
        assert tick_texts(ticks) == texts


@pytest.mark.parametrize(
    ("value", "text"),
    [(1e-7, "10⁻⁷"), (-1e-7, "−10⁻⁷"), (2.5e8, "2.5×10⁸"), (0.02, "0.02"), (-3.0, "−3"), (0.0, "0")],
)
def test_powers_of_ten(value, text):
    assert power_text(value) == text


def test_logarithmic_scales():
    """Decades are equally far apart; within one decade ticks stand at 1, 2 and 5, within less at round values."""
    scale = Scale(1e-4, 1e2, 0.0, 600.0, is_log=True)
    np.testing.assert_allclose(scale.at([1e-4, 1e-3, 1.0, 1e2]), [0.0, 100.0, 400.0, 600.0])
    assert scale.ticks(6) == pytest.approx([1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0])
    assert Scale(1.0, 10.0, is_log=True).ticks(6) == [1.0, 2.0, 5.0, 10.0]
    assert Scale(3.0, 4.0, is_log=True).ticks(6) == pytest.approx([3.0, 3.2, 3.4, 3.6, 3.8, 4.0])


def test_ranges():
    assert fitted(0.0, 1.0, 0.05) == pytest.approx((-0.05, 1.05))
    assert fitted(7.0, 7.0) == pytest.approx((6.3, 7.7))
    assert fitted(0.0, 0.0) == (-1.0, 1.0)
    assert fitted(np.inf, -np.inf) == (0.0, 1.0)


def chart(*marks: object, **options: object) -> ElementTree.Element:
    plot = Plot(marks, Axis("v_GX [m/s]"), **options)
    return ElementTree.fromstring(draw_chart("name", 'a "caption" < b', (plot,), Axis("t [s]")).svg)


def places(root: ElementTree.Element, label: str) -> np.ndarray:
    (path,) = [each for each in root.iter() if each.get("data-label") == label]
    return np.array(re.findall(r"[ML]([-\d.]+) ([-\d.]+)", path.get("d", "")), float)


def test_points_are_where_their_values_are():
    """Between the ends that `data-x` and the ticks tell, which is what shows values on pages."""
    root = chart(Line("FE", X, X**2))
    (plot,) = [each for each in root.iter() if each.get("class") == "plot"]
    left, top, right, bottom = map(float, plot.get("data-box", "").split())
    low, high = map(float, plot.get("data-x", "").split())
    found = places(root, "FE")
    np.testing.assert_allclose(low + (found[:, 0] - left) / (right - left) * (high - low), X, atol=1e-4)
    assert (found[:, 1].min() > top, found[:, 1].max() < bottom) == (True, True)
    tick = {
        "".join(each.itertext()): float(each.get("y", "nan")) - 4.0
        for each in root.iter(SVG + "text")
        if each.get("text-anchor") == "end"
    }
    assert found[-1, 1] == pytest.approx(tick["4"], abs=0.02)
    assert found[0, 1] == pytest.approx(tick["0"], abs=0.02)


def test_words_are_escaped_and_subscripts_set():
    root = chart(Line("a < b & c", X, X), Words("v_GY", 1.0, 1.0))
    assert root.get("aria-label") == 'a "caption" < b'
    said = ["".join(each.itertext()) for each in root.iter(SVG + "text")]
    assert "a < b & c" in said
    assert sum(each.text == "GX" for each in root.iter(SVG + "tspan")) == 1
    assert sum(each.text == "GY" for each in root.iter(SVG + "tspan")) == 1


def test_gaps_are_gaps():
    y = np.array([0.0, 1.0, np.nan, 2.0, 3.0])
    root = chart(Line("FE", X, y))
    (path,) = [each for each in root.iter() if each.get("data-label") == "FE"]
    assert path.get("d", "").count("M") == 2
    assert path.get("data-values") == "0 1 2 3"


def test_levels_stay_in_the_picture_and_clear_of_each_other():
    marks = [Level(f"name {number}", 10.0 + 0.01 * number) for number in range(5)]
    root = chart(Line("FE", X, 5.0 * X), *marks)
    names = [each for each in root.iter(SVG + "text") if (each.text or "").startswith("name")]
    heights = sorted(float(each.get("y", "nan")) for each in names)
    assert min(np.diff(heights)) >= 11.0
    assert min(heights) > 0.0
    width = float(root.get("width", "nan"))
    assert all(float(each.get("x", "nan")) + 6.0 * len(each.text or "") <= width for each in names)


def test_the_legend_names_what_is_drawn_once():
    root = chart(
        Span("front", 0.0, 1.0), Layer("strain", X, 0.0 * X, X), Line("FE", X, X), Swatch("60 kN", "#123456")
    )
    said = ["".join(each.itertext()) for each in root.iter(SVG + "text")]
    for label in ("front", "strain", "FE", "60 kN"):
        assert said.count(label) == 1
    assert {each.get("class") for each in root.iter(SVG + "g")} - {None, "plot"} <= set(PALETTE)


def test_a_long_legend_takes_rows():
    """Keys stay within the width, and push the plot down."""
    few, many = (chart(*(Line(f"a long name {i}", X, X) for i in range(n))) for n in (1, 9))
    assert float(many.get("height", "nan")) > float(few.get("height", "nan")) + 30.0
    shifts = re.findall(r"translate\(([\d.]+) ", ElementTree.tostring(many).decode())
    assert max(map(float, shifts)) + 100.0 < 400.0
