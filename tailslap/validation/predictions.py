"""Predict published forces, durations, speeds and outcomes.

Predictions have bands of PERCENTILES, the spread of rigid impacts over a set of ranges; nothing is adjusted to a
published value. A published force is compared with the same quantity, the force on the wall or the inertial estimate of
a sensor. The plateau of the crush law is assumed and limits the force, so that each row states which fraction of its
variance the plateaus explain alone.
"""

import math
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tailslap import progress
from tailslap.campaign import sampling
from tailslap.campaign.band_samples import variance_fractions
from tailslap.case.force_band import Calibration
from tailslap.scene.units import to_si
from tailslap.validation import conformal, outcomes
from tailslap.validation.outcomes import OutcomeRow
from tailslap.validation.samples import Floats, Samples, samples_of
from tailslap.validation.tables import parameters

SAMPLES, SAMPLES_IN_SPACE = 1024, 512
"""Motions of each set of ranges, in the plane and in space."""

ON_THE_WALL, INERTIAL = "force on the wall", "inertial"
KINDS = {"mean_50ms": ON_THE_WALL, "cfc60": ON_THE_WALL, "inertial_50ms": INERTIAL, "ratio": ON_THE_WALL}
"""What a published force is, by quantity; the ratio is one of two forces."""

FORCES = ("mean_50ms", "cfc60", "inertial_50ms")
QUANTITIES = {
    "mean_50ms": ("largest 50 ms mean", "kN", 1e-3),
    "inertial_50ms": ("largest 50 ms mean", "kN", 1e-3),
    "cfc60": ("largest force, CFC 60", "kN", 1e-3),
    "ratio": ("ratio of largest 50 ms means", "", 1.0),
    "duration": ("duration of strike 2, 50 ms mean", "ms", 1e3),
    "exit_speed": ("speed after the last strike", "m/s", 1.0),
    "height": ("height of the resultant", "m", 1.0),
}
"""Label, shown unit and factor of each quantity."""

BY_THE_PLATEAU = 0.5
"""Fraction of the variance that the plateaus explain alone, from which on they decide a row."""


class Row(NamedTuple):
    """A published value beside its prediction [SI].

    kind: of `KINDS`, or ""; space: True of a prediction in space; predicted: median of the samples; lower, upper: ends
    of PERCENTILES; ratio: predicted over published; plateau: fraction of the variance that the plateaus explain alone;
    study: that published the value.
    """

    case: str
    quantity: str
    kind: str
    space: bool
    predicted: float
    lower: float
    upper: float
    published: float
    ratio: float
    inside: bool
    plateau: float
    vehicle: str
    study: str
    source: str


@dataclass(frozen=True)
class Validation:
    """Predictions beside published values.

    name: of the set of ranges; inputs: of each vehicle, with their sources; skipped: published tests that are not
    computed, and why; former: predictions of the rows by the first set, if this is another one; calibrations: of
    each class of vehicles.
    """

    name: str
    rows: tuple[Row, ...]
    inputs: tuple[dict[str, Any], ...]
    impacts: int
    seconds: float
    outcomes: tuple[OutcomeRow, ...] = ()
    skipped: tuple[dict[str, str], ...] = ()
    former: tuple[Row, ...] = ()
    calibrations: tuple[Calibration, ...] = ()

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
        return [row for row in self.rows if row.plateau < BY_THE_PLATEAU]

    @property
    def worse(self) -> list[Row]:
        """Return the rows that the first set predicts better.

        It has them in its band and this one has not; a row outside both is worse where its ratio is further from 1.
        """
        pairs = zip(self.rows, self.former, strict=False)
        return [
            row for row, before in pairs if not row.inside and (before.inside or _miss(before) < _miss(row))
        ]


def _miss(row: Row) -> float:
    """Return the distance of a ratio from 1 in logarithms."""
    return abs(math.log(row.ratio))


def validate(name: str) -> Validation:
    """Predict every published value by a set of ranges."""
    began, tables = time.perf_counter(), parameters(name)
    with progress.progress_bar("validation: impacts") as show:
        rows, impacts = predicted_rows(tables, show)
        former = () if name == "first" else predicted_rows(parameters("first"), show)[0]
    with progress.progress_bar("validation: motions in space") as show:
        of_tests = outcomes.outcome_rows(tables, show)
    impacts += len(of_tests) * outcomes.SAMPLES
    return Validation(
        name, rows, tuple(_inputs(tables)), impacts, time.perf_counter() - began, of_tests,
        tuple(tables["not_computed"]), former, calibrations_of(rows, tables),
    )  # fmt: skip


def calibrations_of(rows: Sequence[Row], tables: Mapping[str, Any]) -> tuple[Calibration, ...]:
    """Return the calibration of each class by the rows of its forces."""
    calibrations = []
    for one in tables["classes"]:
        of_class = forces_of(rows, one)
        bands = [(row.lower, row.predicted, row.upper) for row in of_class]
        published, studies = [row.published for row in of_class], [row.study for row in of_class]
        calibrations.append(conformal.calibration_of(one["name"], published, bands, studies))
    return tuple(calibrations)


def forces_of(rows: Sequence[Row], one: Mapping[str, Any]) -> list[Row]:
    """Return the rows of the forces of a class of vehicles."""
    return [row for row in rows if row.vehicle in one["vehicles"] and row.quantity in FORCES]


def predicted_rows(
    tables: Mapping[str, Any], show: Callable[[float], None], of: Collection[str] = tuple(QUANTITIES)
) -> tuple[tuple[Row, ...], int]:
    """Return a row for every published value, and the number of impacts.

    of: quantities of the values.
    """
    rows, known = list[Row](), dict[str, Samples]()

    def samples(case: Mapping[str, Any], wall: Mapping[str, Any] | None) -> Samples:
        key = f"{case['vehicle']} {wall} {case.get('ranges', '')}"
        if key not in known:
            known[key] = samples_of(tables, case, wall, SAMPLES_IN_SPACE if wall else SAMPLES)
        return known[key]

    for number, case in enumerate(tables["cases"], 1):
        for value in (value for value in case["published"] if value["quantity"] in of):
            limits = case.get("ranges", {}) | value.get("ranges", {})
            wall = value.get("wall", case.get("wall"))
            inputs, answers = samples({"vehicle": case["vehicle"], "ranges": limits}, wall)
            if over := value.get("over"):
                below = samples({"vehicle": over["vehicle"], "ranges": {}}, over["wall"]).answers
                answers = {"ratio": answers["mean_50ms"] / below["mean_50ms"]}
            rows.append(compared(case, value, Samples(inputs, answers), wall is not None))
        show(number / len(tables["cases"]))
    return tuple(rows), sum(next(iter(known[key].inputs.values())).size for key in known)


def _inputs(tables: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the ranges of every vehicle as rows."""
    return [
        {"vehicle": f"{name}{ending}", "key": key, "lower": lower, "upper": upper, "source": source}
        for table, ending in (("vehicles", ""), ("space_vehicles", " in space"))
        for name, vehicle in tables[table].items()
        for key, (lower, upper, source) in vehicle["ranges"].items()
    ]


def compared(case: Mapping[str, Any], published: Mapping[str, str], samples: Samples, in_space: bool) -> Row:
    """Return the prediction of one published value beside it."""
    quantity, (number, _, unit) = published["quantity"], published["value"].partition(" ")
    value = float(number) * (to_si(unit)[0] if unit else 1.0)
    answers = samples.answers[quantity]
    lower, median, upper = sampling.band_of(answers).percentiles
    solved = np.isfinite(answers)
    fractions = variance_fractions(
        {key: values[solved] for key, values in samples.inputs.items()}, answers[solved]
    )
    plateaus = math.fsum(fraction for key, fraction in fractions.items() if "plateau" in key)
    return Row(
        case["name"], quantity, KINDS.get(quantity, ""), in_space, median, lower, upper, value, median / value,
        lower <= value <= upper, min(1.0, plateaus), case["vehicle"], case["study"], case["source"],
    )  # fmt: skip
