"""Verification: ticks of the maps are round, cells lie where their values lie, and the legend names every colour."""

import itertools
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from postprocess.figures.plates import COLOURS, MapAxis, draw_map, draw_meanings
from postprocess.svg.chart import Chart
from postprocess.svg.drawing import text_width
from postprocess.svg.marks import cells_about
from tailslap.scene.read import read_scene
from tailslap.studies.stability.compute import MAP_KINDS as KINDS
from tailslap.studies.stability.compute import axes_of

AXES = {axis.name: axis for axis in axes_of(read_scene("paper-table-3")[0], 10)}
SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("stiffness", ["10⁻⁴", "0.01", "1", "100", "10⁴"]),
        ("penalty", ["0.01", "1", "100", "10⁴"]),
        ("friction", ["0.0", "0.5", "1.0", "1.5", "2.0"]),
        ("speed", ["0.01", "0.1", "1", "10"]),
        ("angle", ["1", "10", "100"]),
        ("slenderness", ["0.01", "0.1", "1"]),
        ("time step", ["0.6", "0.8", "1.0", "1.2"]),
        ("damping", ["0", "0.01", "0.1", "1"]),
    ],
)
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


def small_map(points: int, across: str, up: str) -> Chart:
    axes = {
        axis.name: MapAxis(axis.meaning, axis.values)
        for axis in axes_of(read_scene("paper-table-3")[0], points)
    }
    return draw_map("m", axes[across], axes[up], [["right"] * points] * points, "")


def test_each_cell_says_its_values_and_its_verdict():
    across, up = MapAxis("a", [0.0, 0.01, 0.1]), MapAxis("b", [1.0, 2.0])
    svg = draw_map("m", across, up, [["right", "caught", "right"], ["wrong", "right", "right"]], "").svg
    (said,) = re.findall(r'data-values="([^"]*)" data-at="([^"]*)"', svg)
    assert said[0].split(" ") == ["right", "caught", "right", "wrong", "right", "right"]
    assert said[1].replace("\N{NO-BREAK SPACE}", " ").split(" ")[-2:] == ["0.1;", "2"]
    red, *others = re.findall(r'<g class="red"[^>]*><path d="([^"]*)"', svg)
    assert (red.count("M"), others) == (1, [])
    left, top = map(float, re.findall(r"M([\d.]+) ([\d.]+)", red)[0])
    places = [tuple(map(float, p)) for p in re.findall(r"M([\d.]+) ([\d.]+)Z", svg)]
    assert (left, top) < places[3], "the fourth cell, the first of the upper row"
    assert places[3][0] == places[0][0]
    assert places[3][1] < places[0][1]


@pytest.mark.parametrize("points", [2, 3, 4, 10, 40])
def test_tick_labels_do_not_overlap(points):
    for across, up in itertools.pairwise([*AXES, next(iter(AXES))]):
        root = ElementTree.fromstring(small_map(points, across, up).svg)
        words = [("".join(text.itertext()), text) for text in root.iter(SVG + "text")]
        below = [
            (float(text.get("x", "0")), text_width(said, 11.0))
            for said, text in words
            if text.get("text-anchor") == "middle" and text.get("font-size") == "11"
        ]
        beside = [float(text.get("y", "0")) for _, text in words if text.get("text-anchor") == "end"]
        for (x, wide), (other, more) in itertools.pairwise(sorted(below)):
            assert other - x > 0.5 * (wide + more)
        assert all(after - before > 11.0 for before, after in itertools.pairwise(sorted(beside)))


def test_legend_says_what_every_colour_means():
    assert list(KINDS) == list(COLOURS)
    chart = draw_meanings(KINDS, "what the colours mean")
    for kind, meaning in KINDS.items():
        assert f">{kind}: {meaning}<" in chart.svg
        assert f'class="{COLOURS[kind]}"' in chart.svg
        assert text_width(f"{kind}: {meaning}", 11.0) + 24.0 <= chart.width
