"""Computation of the study `flexibility`."""

from pathlib import Path

from tailslap.campaign import levels
from tailslap.case.case import Case
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.studies.flexibility.corner_flexibility import corner_flexibility
from tailslap.studies.flexibility.impact_flexibility import impact_flexibility
from tailslap.studies.flexibility.plate_runs import Flexibility

LOWEST, IMPACT_LOWEST = "0.1 Hz", "2 Hz"
"""Lowest first frequencies of a constrained corner and of a whole impact."""


def compute(
    case: Case, place: Path, points: int, lowest: str | None, highest: str, workers: int | None
) -> Flexibility:
    """Run plates from stiff to soft."""
    if isinstance(case, ImpactCase):
        frequencies = levels.frequencies(lowest or IMPACT_LOWEST, highest, points)
        return impact_flexibility(case, frequencies, place, workers)
    assert isinstance(case, CornerCase)
    return corner_flexibility(case, levels.frequencies(lowest or LOWEST, highest, points), place, workers)
