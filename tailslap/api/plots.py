"""Plots of a result's histories."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from tailslap.api.columns import Columns
from tailslap.errors import InputError, Missing, Verbatim

if TYPE_CHECKING:
    from postprocess.figures.histories import HistoryPlot

FIRST = ("force_normal", "v_gx", "v_gy", "omega", "reaction_normal")
"""What is drawn unless the caller says otherwise, where it is there."""

MOST = 4


def plot_histories(histories: Mapping[str, Columns], names: Sequence[str]) -> HistoryPlot:
    """Panels of these columns over time, one line a history. Raises InputError."""
    from postprocess.figures.histories import Curve, plot_overlays

    drawn = {label: columns for label, columns in histories.items() if "t" in columns}
    if not drawn:
        raise InputError("plot", Missing, "this result has no history over time")
    known = list(dict.fromkeys(name for columns in drawn.values() for name in columns))
    chosen = names or [name for name in FIRST if name in known][:MOST] or known[1 : MOST + 1]
    for name in chosen:
        if name not in known:
            raise InputError("plot", Verbatim(name), f"allowed are {', '.join(known)}")
    panels = {}
    for name in chosen:
        having = {label: columns for label, columns in drawn.items() if name in columns}
        unit = next(columns.units.get(name, "") for columns in having.values())
        curves = [Curve(label, columns["t"], columns[name]) for label, columns in having.items()]
        panels[f"{name} [{unit}]" if unit else name] = curves
    return plot_overlays(panels)
