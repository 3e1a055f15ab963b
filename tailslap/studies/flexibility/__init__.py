"""The study `flexibility`: effect of the flexibility of the vehicle on the results of the rigid-body method."""

import click

from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later

POINTS = "Number of first frequencies, in equal ratios."
SOFTEST = "Lowest first frequency  [default: 0.1 Hz; whole impact: 2 Hz]"
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

STUDY = Study(
    name="flexibility",
    summary="Effect of vehicle flexibility on the results of the rigid-body method, from rigid to soft plates.",
    compute=later("tailslap.studies.flexibility.compute:compute"),
    report=later("tailslap.studies.flexibility.report:report"),
    analyses=(CORNER, WHOLE_IMPACT),
    options=OPTIONS,
)
