"""Verification: ticks of the maps are round, lie where their values lie, and the legend names every colour."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from postprocess.figures.map_plots import COLOURS, PLACE, SIZE, MapAxis, draw_cells, draw_legend
from postprocess.figures.map_ticks import places, round_ticks, tick_texts
from tailslap.scene.files import read_scene
from tailslap.studies.stability.against_rigid import KINDS
from tailslap.studies.stability.axes import stability_axes

pytestmark = pytest.mark.verification

AXES = {axis.name: axis for axis in stability_axes(read_scene("paper-table-3")[0], 10)}


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("stiffness", ["10⁻⁴", "10⁻²", "1", "10²", "10⁴"]),
        ("penalty", ["10⁻²", "1", "10²", "10⁴"]),
        ("friction", ["0", "0.5", "1", "1.5", "2"]),
        ("speed", ["0.01", "0.1", "1", "10"]),
        ("angle", ["1", "3", "10", "30"]),
        ("slenderness", ["0.01", "0.03", "0.1", "0.3", "1"]),
        ("time step", ["0.6", "0.8", "1", "1.2"]),
        ("damping", ["0", "0.01", "0.1", "1"]),
    ],
)
def test_ticks_of_the_study_are_round(name: str, texts: list[str]) -> None:
    assert tick_texts(round_ticks(AXES[name].values)) == texts


def test_ticks_lie_between_cells_on_the_axis_own_scale() -> None:
    ratios = np.geomspace(1e-4, 1e4, 9).tolist()
    assert places([1e-4, 1.0, 10.0, 10.0**0.5], ratios) == pytest.approx([0.5, 4.5, 5.5, 5.0])
    assert places([0.0, 0.5, 2.0], np.linspace(0.0, 2.0, 5).tolist()) == pytest.approx([0.5, 1.5, 4.5])
    assert places([0.0, 0.1, 1.0], [0.0, 0.01, 0.1, 1.0]) == pytest.approx([0.5, 2.5, 3.5])


@pytest.mark.parametrize("points", [2, 3, 4, 10, 40])
def test_tick_labels_do_not_overlap(points: int) -> None:
    axes = [MapAxis(a.meaning, a.values) for a in stability_axes(read_scene("paper-table-3")[0], points)]
    for across, up in itertools.pairwise([*axes, axes[0]]):
        figure = Figure(figsize=SIZE)
        FigureCanvasAgg(figure)
        panel = figure.add_axes(PLACE)
        draw_cells(panel, across, up, [["right"] * points] * points)
        figure.canvas.draw()
        for labels in (panel.get_xticklabels(), panel.get_yticklabels()):
            boxes = [label.get_window_extent() for label in labels]
            assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


def test_legend_says_what_every_colour_means() -> None:
    assert list(KINDS) == list(COLOURS)
    svg = draw_legend(KINDS, "what the colours mean").svg
    for kind, meaning in KINDS.items():
        assert f">{kind}<" in svg
        assert meaning in svg
        assert COLOURS[kind] in svg
