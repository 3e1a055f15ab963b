"""The figures of the study, from its records to what is drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from postprocess.figures.strike_plots import (
    BandBar,
    InputPanel,
    PlatePanel,
    draw_bands,
    draw_inputs,
    draw_plates,
)
from postprocess.svg.chart import Chart
from tailslap.studies.strike.campaign import Curve as Varied
from tailslap.studies.strike.campaign import StrikeResults
from tailslap.studies.strike.limits import LABELS
from tailslap.studies.strike.plates import PlatePoint
from tailslap.studies.strike.quantities import PEAKS, QUANTITIES, STRIKES, column
from tailslap.studies.strike.rows import TAKEN

UNITS = {quantity.name: quantity for quantity in QUANTITIES}
SHOWN = {
    "peak [kN]": ("mean_50ms", "raw", "cfc60"),
    "impulse [kN s]": ("impulse",),
    "duration [ms]": ("duration",),
}
"""Quantities by the label of their axis."""

PLATE_QUANTITIES = ("impulse", "raw", "mean_50ms", "duration")


def curve_figures(found: StrikeResults) -> list[Chart]:
    """Peaks, impulses and durations against each input alone."""
    return draw_inputs("Both strikes against", [_panel(each) for each in found.curves])


def _panel(curve: Varied) -> InputPanel:
    label, unit, scale = LABELS[curve.input.key]
    lines = {axis: {strike: _quantities(curve, strike, SHOWN[axis]) for strike in STRIKES} for axis in SHOWN}
    heading, key = f"{label} [{unit}]" if unit else label, curve.input.key
    values, own = curve.input.values / scale, curve.input.own / scale
    name = "against-" + key.replace(".", "-").replace("_", "-")
    return InputPanel(name, heading, values, own, key == "contact.stiffness", lines)


def _quantities(curve: Varied, strike: int, names: tuple[str, ...]) -> dict[str, Any]:
    scales = {name: UNITS[name].scale for name in names}
    return {UNITS[name].label: curve.columns[column(strike, name)] / scale for name, scale in scales.items()}


def band_figure(found: StrikeResults) -> Chart:
    """Bands of the peaks, with the paper's rows beside those of the second strike."""
    bars = []
    for name in PEAKS:
        for strike in STRIKES:
            key = column(strike, name)
            low, middle, high = (x / 1e3 for x in found.bands.band(key).percentiles)
            dots = _dots(found, name) if strike == 2 else ()
            label = f"{PEAKS[name]}, strike {strike}"
            bars.append(BandBar(label, strike, (low, middle, high), found.own[key] / 1e3, dots))
    return draw_bands(bars)


def _dots(found: StrikeResults, name: str) -> list[tuple[str, float, bool]]:
    kind = TAKEN[name][0] if name in TAKEN else ""
    return [(row.row, row.measured / 1e3, row.projected) for row in found.rows if row.kind == kind]


def plate_figures(found: StrikeResults) -> list[Chart]:
    """Both strikes against the first frequency; none without a plate."""
    soft = [point for point in found.plates if np.isfinite(point.frequency) and point.values]
    if not soft:
        return []
    panels = [_plate_panel(soft, found.plates[-1], name) for name in PLATE_QUANTITIES]
    return [draw_plates([point.frequency for point in soft], [point.passed for point in soft], panels)]


def _plate_panel(soft: list[PlatePoint], rigid: PlatePoint, name: str) -> PlatePanel:
    quantity = UNITS[name]

    def value(point: PlatePoint, strike: int) -> float:
        return point.values[column(strike, name)] / quantity.scale

    words = {"raw": "peak", "mean_50ms": "50 ms mean"}.get(name, quantity.label)
    lines = {strike: [value(point, strike) for point in soft] for strike in STRIKES}
    return PlatePanel(
        f"{words} [{quantity.unit}]", lines, {strike: value(rigid, strike) for strike in STRIKES}
    )
