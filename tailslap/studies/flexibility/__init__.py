"""Study `flexibility` of soft vehicles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tailslap.case.case import CORNER, WHOLE_IMPACT, Case
from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later

if TYPE_CHECKING:
    from tailslap.studies.flexibility.plate_runs import Flexibility

POINTS = "Number of first frequencies, in equal ratios."
SOFTEST = "Lowest first frequency  [default: 0.1 Hz; whole impact: 2 Hz]"
LOWEST, IMPACT_LOWEST = "0.1 Hz", "2 Hz"
"""Lowest first frequencies of a constrained corner and of a whole impact."""
OPTIONS = (
    click.Option(["--points"], type=Whole(4, 100), default=16, show_default=True, help=POINTS),
    click.Option(["--lowest"], metavar="FREQUENCY", help=SOFTEST),
    click.Option(
        ["--highest"],
        default="1 kHz",
        show_default=True,
        metavar="FREQUENCY",
        help="Highest first frequency.",
    ),
    WORKERS,
)


def compute(
    case: Case, place: Path, points: int, lowest: str | None, highest: str, workers: int | None
) -> Flexibility:
    """Run plates from stiff to soft."""
    from tailslap.campaign import levels

    impact = case.scene.contact is not None
    lowest = lowest or (IMPACT_LOWEST if impact else LOWEST)
    name = "impact_flexibility" if impact else "corner_flexibility"
    run: Callable[..., Flexibility] = later(f"tailslap.studies.flexibility.{name}:{name}")
    return run(case, levels.frequencies(lowest, highest, points), place, workers)


STUDY = Study(
    name="flexibility",
    summary="Effect of vehicle flexibility on the results of the rigid-body method, from rigid to soft plates.",
    compute=compute,
    report=later("tailslap.studies.flexibility.flexibility_report:report"),
    analyses=(CORNER, WHOLE_IMPACT),
    options=OPTIONS,
)
