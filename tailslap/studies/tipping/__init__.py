"""The study `tipping`: roll of the vehicle over walls, and uncertainty of the lowest wall without rollover."""

import click

from tailslap.case.case import WHOLE_IMPACT
from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later

SAMPLES = "Minimum number of samples."
RANGE = "Range of a key, e.g. tipping.centre_height='1.2 m:1.5 m'."

STUDY = Study(
    name="tipping",
    summary="Roll for wall heights and centre heights; lowest wall without rollover, with Sobol indices.",
    compute=later("tailslap.studies.tipping.compute:compute"),
    report=later("tailslap.studies.tipping.report:report"),
    needs_plate=False,
    analyses=(WHOLE_IMPACT,),
    options=(
        click.Option(
            ["--samples"], type=Whole(128, 4_000_000), default=8000, show_default=True, help=SAMPLES
        ),
        click.Option(["--range", "ranges"], multiple=True, metavar="KEY=LOWER:UPPER", help=RANGE),
        click.Option(
            ["--fix", "fixed"], multiple=True, metavar="KEY", help="Keep a key fixed that varies by default."
        ),
        WORKERS,
    ),
)
