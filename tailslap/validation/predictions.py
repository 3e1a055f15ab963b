"""Predict published forces, durations, speeds and outcomes blindly.

Predictions have bands of PERCENTILES. Vehicles, ranges and published values stand in parameters.toml and were fixed
before the first prediction. The band of a prediction is the spread of rigid impacts over these ranges; nothing is
adjusted to a published value. The plateau of the crush law is assumed and limits the force, so that each row states
which fraction of its variance the plateaus explain alone.
"""

import math
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.signals.filters import force_curves
from postprocess.signals.strike_duration import second_strike
from tailslap import progress
from tailslap.campaign import input_ranges, sampling, space_samples
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.units import to_si
from tailslap.scene.vary import Source, vary
from tailslap.validation import outcomes
from tailslap.validation.outcomes import OutcomeRow

Floats = NDArray[np.float64]

SAMPLES, BLOCK = 1024, 128
"""Impacts of each set of ranges, at least, and at a time on one core."""

INTERVAL, AFTER_SECOND, STRIKES = 5e-4, 0.1, 32
"""Time between rows of the forces [s], time after the second strike [s], and strikes with room at first."""

FORCES = ("mean_50ms", "cfc60")
QUANTITIES = {
    "mean_50ms": ("largest 50 ms mean", "kN", 1e-3),
    "cfc60": ("largest force, CFC 60", "kN", 1e-3),
    "duration": ("duration of the second strike", "ms", 1e3),
    "exit_speed": ("speed after the last strike", "m/s", 1.0),
    "space_mean_50ms": ("largest 50 ms mean, in space", "kN", 1e-3),
    "height": ("height of the resultant", "m", 1.0),
}
"""Label, shown unit and factor of each quantity."""

BY_THE_PLATEAU = 0.5
"""Fraction of the variance that the plateaus explain alone, from which on they decide a row."""


class Row(NamedTuple):
    """A published value beside its prediction [SI].

    predicted: median of the samples; lower, upper: ends of PERCENTILES; ratio: predicted over published; plateau:
    fraction of the variance that the plateaus explain alone, None where it is not determined.
    """

    case: str
    quantity: str
    predicted: float
    lower: float
    upper: float
    published: float
    ratio: float
    inside: bool
    plateau: float | None
    source: str


@dataclass(frozen=True)
class Validation:
    """Predictions beside published values.

    inputs: of each vehicle, with their sources; skipped: published tests that are not computed, and why.
    """

    rows: tuple[Row, ...]
    inputs: tuple[dict[str, Any], ...]
    impacts: int
    seconds: float
    outcomes: tuple[OutcomeRow, ...] = ()
    skipped: tuple[dict[str, str], ...] = ()

    @property
    def force_ratios(self) -> Floats:
        """Return predicted over published of the forces, shape (n,)."""
        return np.array([row.ratio for row in self.rows if row.quantity in FORCES])

    @property
    def geometric_mean(self) -> float:
        """Return the geometric mean of the forces' ratios."""
        return float(np.exp(np.log(self.force_ratios).mean()))

    @property
    def spread(self) -> float:
        """Return the geometric standard deviation of the forces' ratios."""
        return float(np.exp(np.log(self.force_ratios).std(ddof=1)))

    @property
    def independent(self) -> list[Row]:
        """Return the rows that the plateaus do not decide."""
        return [row for row in self.rows if row.plateau is not None and row.plateau < BY_THE_PLATEAU]


def validate() -> Validation:
    """Predict every published value of parameters.toml."""
    began, published = time.perf_counter(), parameters()
    rows, predicted = list[Row](), dict[str, tuple[tuple[input_ranges.Range, ...], Mapping[str, Floats]]]()
    impacts = 0
    with progress.progress_bar("validation: impacts") as show:
        for number, case in enumerate(published["cases"], 1):
            key = f"{case['vehicle']} {case.get('ranges', '')}"
            if key not in predicted:
                vehicle = published["vehicles"][case["vehicle"]]
                predicted[key] = _predict(vehicle["scene"], vehicle["ranges"] | case.get("ranges", {}))
                impacts += next(iter(predicted[key][1].values())).size
            rows += [compared(case, value, *predicted[key]) for value in case["published"]]
            show(number / len(published["cases"]))
    with progress.progress_bar("validation: motions in space") as show:
        for case in published["space_cases"]:
            table = outcomes.predicted_samples(case, published["space_vehicles"][case["vehicle"]])
            rows += [compared(case, value, (), table) for value in case["published"]]
            impacts += table["outcome"].size
        of_tests = outcomes.outcome_rows(published, show)
    impacts += len(of_tests) * outcomes.SAMPLES
    return Validation(
        tuple(rows), tuple(_inputs(published)), impacts, time.perf_counter() - began, of_tests,
        tuple(published["not_computed"]),
    )  # fmt: skip


def parameters() -> dict[str, Any]:
    """Return vehicles, ranges and published values."""
    return tomllib.loads(resources.files(__package__).joinpath("parameters.toml").read_text("utf-8"))


def _inputs(parameters: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the ranges of every vehicle as rows."""
    return [
        {"vehicle": f"{name}{ending}", "key": key, "lower": lower, "upper": upper, "source": source}
        for table, ending in (("vehicles", ""), ("space_vehicles", " in space"))
        for name, vehicle in parameters[table].items()
        for key, (lower, upper, source) in vehicle["ranges"].items()
    ]


def _predict(
    scene: Mapping[str, Any], limits: Mapping[str, Any]
) -> tuple[tuple[input_ranges.Range, ...], Mapping[str, Floats]]:
    """Return the ranges and, by quantity, a table as of `sampling.sampled`."""
    case = ImpactCase(*vary(Source(tables=dict(scene)), {}))
    ranges = space_samples.stated_ranges(case, limits)
    solve = partial(sampling.solved_in_blocks, partial(quantities, case), block=BLOCK)
    _, tables = sampling.sampled(ranges, SAMPLES, solve)
    return ranges, tables


def quantities(case: ImpactCase, inputs: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return the quantities of impacts, shape (n,) each.

    They are NaN without a second strike.
    """
    values = space_samples.expanded(case.scene, inputs)
    impacts = case.impacts(values, after_second=AFTER_SECOND, interval=INTERVAL, strikes=STRIKES)
    columns: dict[str, list[float]] = {name: [] for name in (*FORCES, "duration")}
    for force in impacts.mean_force.T:
        curves = force_curves(force, INTERVAL, FORCES)
        for name in FORCES:
            columns[name].append(float(curves[name].max()))
        try:
            columns["duration"].append(second_strike(curves["mean_50ms"], INTERVAL).duration)
        except ValueError:
            columns["duration"].append(math.nan)
    return {name: np.array(values) for name, values in columns.items()} | {"exit_speed": impacts.end_speed}


def compared(
    case: Mapping[str, Any],
    published: Mapping[str, str],
    ranges: tuple[input_ranges.Range, ...],
    tables: Mapping[str, Floats],
) -> Row:
    """Return the prediction of one published value beside it.

    Without ranges, tables are samples of shape (n,), and the fraction of the plateaus is not determined.
    """
    quantity, (number, unit) = published["quantity"], published["value"].split(" ", 1)
    value = float(number) * to_si(unit)[0]
    lower, median, upper = sampling.band_of(tables[quantity]).percentiles
    sources = sampling.index_rows(ranges, tables[quantity])[0] if ranges else []
    plateaus = [row["first_order"] for row in sources if row["key"].endswith("plateau_force")]
    return Row(
        case["name"], quantity, median, lower, upper, value, median / value, lower <= value <= upper,
        min(1.0, math.fsum(plateaus)) if sources else None, case["source"],
    )  # fmt: skip
