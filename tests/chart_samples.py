"""Read samples, words and marks of a chart."""

import re
from itertools import compress
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from postprocess.svg.areas import Boxes, Layer, Outline
from postprocess.svg.marks import Line
from postprocess.units import SI

SVG = "{http://www.w3.org/2000/svg}"


class Samples(NamedTuple):
    """Texts of the places and values of a mark, with their headings."""

    label: str
    where: str
    heading: str
    at: list[str]
    values: list[str]


def samples(chart):
    """Samples of all marks with a label that have any."""
    return [
        Samples(mark.label, _where(chart, plot, at), _heading(plot, mark, at), _texts(at), _texts(values))
        for plot in chart.plots
        for mark in plot.marks
        for at, values in [_of(mark, chart.x.is_log, plot.y.is_log)]
        if mark.label and len(at)
    ]


def _where(chart, plot, at):
    labels = (chart.x.label, plot.y.label) if isinstance(at[0], str) else (chart.x.label,)
    return "; ".join(filter(None, labels))


def _heading(plot, mark, at):
    return mark.label if isinstance(at[0], str) or not plot.y.label else f"{mark.label}: {plot.y.label}"


def _of(mark, log_x, log_y):
    if isinstance(mark, Layer):
        return mark.x, mark.high - mark.low
    if isinstance(mark, Boxes):
        return mark.at or np.mean(mark.x, axis=-1), mark.values
    if not isinstance(mark, Line | Outline):
        return (), ()
    axes = (mark.x, log_x), (mark.y, log_y)
    sound = np.logical_and.reduce([np.isfinite(v) & ((np.array(v) > 0.0) | (not log)) for v, log in axes])
    both = getattr(mark, "at", ()) or mark.x, getattr(mark, "values", ()) or mark.y
    return tuple(list(compress(column, sound)) for column in both)


def _texts(column):
    return [SI.rendered(text) if isinstance(text, str) else f"{text:.6g}" for text in column]


def columns(chart):
    """Samples of a chart by label.

    Each has the heading of the positions, the positions and the values.
    """
    return {row.label: (row.where, row.at, row.values) for row in samples(chart)}


def shown(chart):
    """What pages show, by label."""
    return {label: values for label, (_, _, values) in columns(chart).items()}


def texts(svg):
    """Words of a drawing."""
    elements = ElementTree.fromstring(svg).iter(SVG + "text")
    return ["".join(element.itertext()).replace("\u200b", "").strip() for element in elements]


def path_of(svg, label):
    """Steps of the path with a label."""
    paths = ElementTree.fromstring(svg).iter(SVG + "path")
    (path,) = [path for path in paths if path.get("data-label") == label]
    return path.get("d", "")


def boxes(svg, colour):
    """Left, top, right and bottom of the boxes of a colour."""
    (path,) = re.findall(rf'<g class="{colour}"[^>]*><path d="(M[^"]*H[^"]*)"', svg)
    return np.array(re.findall(r"M(\S+) (\S+)H(\S+)V(\S+?)H", path), float)
