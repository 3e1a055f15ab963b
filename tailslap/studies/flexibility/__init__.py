"""The study `flexibility`: how soft may the vehicle be for the rigid-body method still to hold?"""

import click

from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later

POINTS = "First frequencies, at even ratios."
SOFTEST = "The softest plate  [default: 0.1 Hz; of a whole impact 2 Hz]"
OPTIONS = (
    click.Option(["--points"], type=Whole(4, 100), default=16, show_default=True, help=POINTS),
    click.Option(["--lowest"], metavar="FREQUENCY", help=SOFTEST),
    click.Option(
        ["--highest"], default="1 kHz", show_default=True, metavar="FREQUENCY", help="The stiffest plate."
    ),
    WORKERS,
)

STUDY = Study(
    name="flexibility",
    summary="Rigid to soft plates: how far the five quantities, reaction and stored energy are from the rigid values.",
    compute=later("tailslap.studies.flexibility.compute:compute"),
    report=later("tailslap.studies.flexibility.report:report"),
    analyses=(CORNER, WHOLE_IMPACT),
    options=OPTIONS,
)
