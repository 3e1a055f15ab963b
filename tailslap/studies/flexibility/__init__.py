"""Study `flexibility` of soft vehicles."""

import click

from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later

POINTS = "Number of first frequencies, in equal ratios."
LOWEST = "Lowest first frequency  [default: 0.1 Hz; whole impact: 2 Hz]"
HIGHEST = "Highest first frequency."
OPTIONS = (
    click.Option(["--points"], type=Whole(4, 100), default=16, show_default=True, help=POINTS),
    click.Option(["--lowest"], metavar="FREQUENCY", help=LOWEST),
    click.Option(["--highest"], default="1 kHz", show_default=True, metavar="FREQUENCY", help=HIGHEST),
    WORKERS,
)

STUDY = Study(
    name="flexibility",
    summary="Errors of the rigid-body method, from rigid to soft plates.",
    compute=later("tailslap.studies.flexibility.impact_flexibility:compute"),
    report=later("tailslap.studies.flexibility.flexibility_report:report"),
    options=OPTIONS,
)
