"""Read the samples of a chart, which pages offer as a table."""

from itertools import compress
from typing import NamedTuple

import numpy as np

from postprocess.svg.areas import Boxes, Layer, Outline
from postprocess.svg.marks import Line
from postprocess.units import SI


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
