"""A sweep in words: what was computed, and what it means."""

from __future__ import annotations

import math

import numpy as np

from postprocess.figures.sweep_plots import SweepRows
from tailslap.sweep.complete import Sweep
from tailslap.sweep.row import ERROR, FAILED, PASSED, REFUSED
from tailslap.sweep.variation import Variation

STATUS_WORDS = {PASSED: "passed all checks", FAILED: "failed a check", REFUSED: "refused", ERROR: "in error"}


def counts(sweep: Sweep) -> str:
    """How many rows have each status, those that none has left out."""
    return ", ".join(f"{n} {STATUS_WORDS[status]}" for status, n in sweep.statuses.items() if n)


def headline(sweep: Sweep, rows: SweepRows) -> str:
    """The result in two sentences."""
    words = f"{sweep.definition.runs} runs: {counts(sweep)}."
    good = rows.worst[rows.status == PASSED]
    if not good.size:
        return words
    return (
        f"{words} In those that passed, the largest difference between FE and the exact rigid solution lies between "
        f"{good.min():.1e} and {good.max():.1e}, in half of them below {np.median(good):.1e}."
    )


def statements(sweep: Sweep) -> tuple[str, ...]:
    """What a reader must know beside the numbers."""
    definition = sweep.definition
    drawn = (
        f"The runs are a Latin hypercube of {definition.sample} samples with the seed {definition.seed}: each range is "
        "cut into as many equal parts, and each part has one sample. The same call gives the same runs."
        if definition.sample
        else "The runs are all combinations of the values."
    )
    made = (
        drawn,
        "Every row has the exact rigid solution of its own inputs, its differences, and the values of all checks.",
        "Refused: the rigid-body theory has no answer for these inputs, or they make no model; the row says why."
        if sweep.statuses[REFUSED]
        else "",
        "Results of runs that failed a check are in the table and the plots, and are not to be believed."
        if sweep.statuses[FAILED]
        else "",
    )
    return tuple(sentence for sentence in made if sentence)


def values_words(item: Variation) -> str:
    """The values of a key: all of a short list, else the ends and how they lie between."""
    values = list(dict.fromkeys(item.values))
    if not item.numeric or len(values) <= 4:
        return ", ".join(shown(value, item.unit) for value in values)
    low, high = (shown(end, item.unit) for end in (min(values), max(values)))
    return f"{low} to {high}" + (", in equal ratios" if item.logarithmic else "")


def shown(value: float | int | str, unit: str) -> str:
    """A value with its unit, angles in degrees."""
    if isinstance(value, str):
        return value
    if unit == "rad":
        return f"{math.degrees(value):.5g} deg"
    return f"{value:.5g} {unit}".strip()
