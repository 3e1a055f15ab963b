"""Labels of lines, written where the lines end: each where it covers no other label and as little else as can be."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from postprocess.figures.label_spots import STRIDE, Box, Floats, Ground, Spot, leader_to, sampled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

DISTANCES = (5.0, 11.0, 18.0, 26.0, 36.0, 48.0, 62.0, 80.0, 100.0, 125.0)
"""Distances [points] from the end of a line that are tried."""

DIRECTIONS, PAD, NEAR = 16, 2.0, 12.0
"""Directions that are tried; margin round a label [points]; distance up to which a label needs no leader [points]."""

AWAY = 0.2
"""Cost of each point of distance."""

ROUNDS = 3
"""How often every label looks for a better place."""


@dataclass(frozen=True)
class Label:
    """Text and colour of a label, and the points in data that it may stand at: the ends of its line."""

    text: str
    colour: str
    ends: Sequence[tuple[float, float]]


def write_labels(
    axes: "Axes", labels: Sequence[Label], lines: Sequence[Floats], taken: Sequence[Box]
) -> None:
    """Write each label; in each round every one takes its best place beside the others.

    lines: what is drawn, in data, shape (n, 2) each; taken: boxes in pixels that are in use. The axes must have their
    final limits, and the figure a canvas with a renderer. A label for which there is no place is written at its point.
    """
    drawn = [sampled(axes.transData.transform(line)) for line in lines if len(line)]
    ground = Ground(Box(*axes.get_window_extent().extents), np.concatenate(drawn), list(taken))
    texts = [_annotation(axes, label) for label in labels]
    spots: dict[int, Spot] = {}
    for number in [*range(len(labels))] * ROUNDS:
        others = [spot for other, spot in spots.items() if other != number]
        spots[number] = _best(axes, labels[number], texts[number], ground, others)
    for number, spot in spots.items():
        _put(texts[number], spot, axes)


def _annotation(axes: "Axes", label: Label) -> "Annotation":
    return axes.annotate(
        label.text,
        label.ends[0],
        xytext=(0.0, 0.0),
        textcoords="offset points",
        ha="center",
        va="center",
        color=label.colour,
        fontsize=8,
        fontweight="bold",
        zorder=6,
        arrowprops={"arrowstyle": "-", "color": label.colour, "linewidth": 0.6, "shrinkA": 1, "shrinkB": 2},
    )


def _best(axes: "Axes", label: Label, text: "Annotation", ground: Ground, others: Sequence[Spot]) -> Spot:
    """The cheapest place beside the others; over its first end if there is none."""
    scale, extent = _scale(axes), text.get_window_extent()
    size = np.array([extent.width, extent.height]) + 2.0 * PAD * scale
    ends = [axes.transData.transform(end) for end in label.ends]
    found, least = _spot(ends[0], np.zeros(2), size, 0.0), math.inf
    for at in ends:
        for direction, away in _tried():
            spot = _spot(
                at, direction * (0.5 * size + away * scale), size, AWAY * away + 0.5 * (1.0 - direction[0])
            )
            cost = ground.cost(spot, others, least)
            if cost < least:
                found, least = spot, cost
    return found


def _spot(at: Floats, offset: Floats, size: Floats, cost: float) -> Spot:
    box = Box(*(at + offset - 0.5 * size), *(at + offset + 0.5 * size))
    return Spot(box, leader_to(box, at), at, cost)


def _put(text: "Annotation", spot: Spot, axes: "Axes") -> None:
    """Move the text to its place; near its point it needs no leader."""
    middle = np.array([spot.box.left + spot.box.right, spot.box.low + spot.box.high]) / 2.0
    text.xy = tuple(axes.transData.inverted().transform(spot.at))
    text.set_position(tuple((middle - spot.at) / _scale(axes)))
    if len(spot.leader) * STRIDE <= NEAR * _scale(axes):
        text.arrow_patch.set_visible(False)  # type: ignore[union-attr]


def _tried() -> Iterator[tuple[Floats, float]]:
    for away in DISTANCES:
        for number in range(DIRECTIONS):
            angle = 2.0 * math.pi * number / DIRECTIONS
            direction = np.array([math.cos(angle), math.sin(angle)])
            yield direction / np.abs(direction).max() if away == DISTANCES[0] else direction, away


def _scale(axes: "Axes") -> float:
    """Pixels in a point."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return figure.dpi / 72.0
