"""The random survey in words."""

from __future__ import annotations

from tailslap.studies.stability.random_survey import RandomSurvey
from tailslap.studies.stability.random_verdict import (
    GOOD,
    REFUSED,
    UNJUDGED,
    WRONG,
    WRONG_FROM,
    RandomVerdict,
)

MEANINGS = {
    "right": "every check passed, and the five quantities are those of a refined model of the same plate",
    "reaction only": "right, but the reaction rings, and checks of its history alone say so",
    "good but failed": "other checks failed although the five quantities are right beyond doubt",
    "caught": "a check failed, and the five quantities are off or in doubt",
    "refused": "wrong input: a message, and no run",
    "unjudged": "no refined model came to an answer that can be trusted",
    "wrong": "every check passed, and the five quantities are off",
}

SHOWN = (WRONG, GOOD, UNJUDGED, REFUSED)
"""Verdicts whose cells are listed; what is drawn is valid by itself, so that a refusal needs its reason."""


def headline(found: RandomSurvey) -> str:
    """The result in two sentences."""
    counts = found.counts
    wrong = "None is" if not counts[WRONG] else f"{counts[WRONG]} are"
    return (
        f"Of {len(found.verdicts)} scenes drawn at random {counts['right']} are right, to "
        f"{WRONG_FROM[0]:g} and {100 * WRONG_FROM[1]:g} % of what the plate's flexibility changes. "
        f"{wrong} wrong without being caught."
    )


def lines(found: RandomSurvey) -> list[str]:
    """What the command prints."""
    rows = [f"{kind:<16}{count:>6}  {MEANINGS[kind]}" for kind, count in found.counts.items()]
    cells = [
        f"{verdict.kind.upper()}  cell {number:04d}: {sentence(verdict)}"
        for number, verdict in found.of_kind(WRONG, GOOD).items()
    ]
    name, total = found.plan.scene.name, len(found.verdicts)
    return [f"{name}: {total} random cells, seed {found.seed}, in {found.seconds:.0f} s", *rows, *cells]


def sentence(verdict: RandomVerdict) -> str:
    """Distance and failed checks of a cell."""
    off = f"{verdict.distance:.1e} off, {verdict.allowed:.1e} allowed, own estimate {verdict.error:.1e}"
    return f"{off}; failed: {verdict.failed}" if verdict.failed else off
