"""Predict the outcomes of published crash tests.

Predictions are blind probabilities by samples of vehicles in space. An outcome is upright, on its side, or over the
wall. A report that a test passed states that the vehicle was contained, upright or on its side. Scores are therefore
those of the event "over the wall": Brier's, the mean square of probability minus 1 or 0. Rules of design stand beside
the probabilities: a wall of at least their height holds.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from solver import space
from tailslap.validation.samples import Floats, samples_of
from tailslap.validation.tables import metres_or_newtons

SAMPLES = 256
"""Motions of each case."""

UPRIGHT, SIDE, OVER = space.OUTCOMES
CONTAINED = "contained"
STATED = {CONTAINED: (UPRIGHT, SIDE), UPRIGHT: (UPRIGHT,), SIDE: (SIDE,), OVER: (OVER,)}
"""Outcomes that a published one may be."""

OURS, ALWAYS = "this program", "always contained"


class OutcomeRow(NamedTuple):
    """Outcome of a published test beside its probabilities.

    wall: height [m]; probabilities: by outcome; stated: that of the published outcome; holds: verdict of each rule.
    """

    case: str
    vehicle: str
    wall: float
    published: str
    probabilities: dict[str, float]
    stated: float
    holds: dict[str, bool]
    source: str


class Score(NamedTuple):
    """Brier score of a forecast.

    right: number of cases on the right side of one half.
    """

    name: str
    score: float
    right: int
    cases: int


def rule_height(rule: Mapping[str, str]) -> float:
    """Return the height from which on walls hold [m].

    It is stated, or AASHTO's H = G - W B / (2 F).
    """
    if "height" in rule:
        return metres_or_newtons(rule["height"])
    centre, weight, width, force = (
        metres_or_newtons(rule[name]) for name in ("centre", "weight", "width", "force")
    )
    return centre - weight * width / (2.0 * force)


def outcome_rows(parameters: Mapping[str, Any], show: Callable[[float], None]) -> tuple[OutcomeRow, ...]:
    """Return the probabilities of every published outcome."""
    heights = {rule["name"]: rule_height(rule) for rule in parameters["rules"]}
    rows = []
    for number, case in enumerate(parameters["outcomes"], 1):
        samples = samples_of(parameters, case, case["wall"], SAMPLES)
        rows.append(outcome_row(case, samples.answers["outcome"], heights))
        show(number / len(parameters["outcomes"]))
    return tuple(rows)


def outcome_row(case: Mapping[str, Any], outcomes: Floats, heights: Mapping[str, float]) -> OutcomeRow:
    """Return the row of a case from the outcomes of samples."""
    shares = np.bincount(outcomes.astype(int), minlength=len(space.OUTCOMES)) / outcomes.size
    probabilities = dict(zip(space.OUTCOMES, shares.tolist(), strict=True))
    stated = float(sum(probabilities[name] for name in STATED[case["published"]]))
    wall = metres_or_newtons(case["wall"]["height"])
    holds = {name: bool(wall >= height) for name, height in heights.items()}
    vehicle, published, source = (case[name] for name in ("vehicle", "published", "source"))
    return OutcomeRow(case["name"], vehicle, wall, published, probabilities, stated, holds, source)


def scores(rows: Sequence[OutcomeRow]) -> tuple[Score, ...]:
    """Return the scores of probabilities, rules and a constant forecast."""
    over = np.array([row.published == OVER for row in rows], dtype=float)
    forecasts = {OURS: np.array([row.probabilities[OVER] for row in rows])}
    forecasts |= {
        name: np.array([not row.holds[name] for row in rows], dtype=float) for name in rows[0].holds
    }
    forecasts[ALWAYS] = np.zeros(len(rows))
    return tuple(Score(name, *brier(forecast, over), len(rows)) for name, forecast in forecasts.items())


def brier(forecast: Floats, event: Floats) -> tuple[float, int]:
    """Return the Brier score of a forecast, and its right cases."""
    return float(np.mean((forecast - event) ** 2)), int(np.count_nonzero((forecast > 0.5) == (event > 0.5)))
