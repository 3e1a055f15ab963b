"""The study itself: curves, bands, the paper's rows beside them, plates."""

from __future__ import annotations

import importlib
import time
from collections.abc import Mapping
from dataclasses import dataclass

from tailslap.case.impact.case import ImpactCase
from tailslap.impact.rigid_text import rigid_impact
from tailslap.progress import progress_bar
from tailslap.studies.strike.bands import Bands, find_bands
from tailslap.studies.strike.impacts import demand_corners, measured
from tailslap.studies.strike.limits import InputCurve, band_ranges, curve_inputs
from tailslap.studies.strike.plates import PlatePoint, both_strikes, find_plates
from tailslap.studies.strike.quantities import Array
from tailslap.studies.strike.rows import RowBeside, find_rows
from tailslap.studies.study import Call
from tailslap.studies.uncertainty.ranges import Range


@dataclass(frozen=True)
class Curve:
    """One input varied alone: what was measured, by column, shape (n,)."""

    input: InputCurve
    columns: Mapping[str, Array]


@dataclass(frozen=True)
class StrikeResults:
    """The finished study of a plan; own: what the scene's own values give, by column [SI]."""

    plan: ImpactCase
    own: Mapping[str, float]
    curves: tuple[Curve, ...]
    bands: Bands
    rows: tuple[RowBeside, ...]
    plates: tuple[PlatePoint, ...]
    seconds: Mapping[str, float]


def study_strike(call: Call, samples: int, ranges: tuple[str, ...], fixed: tuple[str, ...]) -> StrikeResults:
    """The study as the command line asks for it."""
    demand_corners(call.plan)
    return find_strikes(call.plan, band_ranges(call.plan, ranges, fixed), samples)


def find_strikes(plan: ImpactCase, ranges: tuple[Range, ...], at_least: int) -> StrikeResults:
    """Run the study: at least so many impacts for the bands."""
    with progress_bar(f"{plan.scene.name}: impacts") as progress:
        for name in ("scipy.stats", "scipy.signal"):  # slow to import
            importlib.import_module(name)
        began = time.perf_counter()
        curves = find_curves(plan)
        bands = find_bands(plan, ranges, at_least, progress)
        rows = find_rows(plan, bands)
    rigid = time.perf_counter() - began
    with progress_bar(f"{plan.scene.name}: plates") as progress:
        plates = find_plates(plan, progress)
    seconds = {"rigid": rigid, "plates": time.perf_counter() - began - rigid}
    return StrikeResults(plan, both_strikes(rigid_impact(plan)), curves, bands, rows, plates, seconds)


def find_curves(plan: ImpactCase) -> tuple[Curve, ...]:
    """Each input alone, the others as in the scene."""
    return tuple(Curve(item, measured(plan, {item.key: item.values})) for item in curve_inputs(plan))
