"""The study `tipping`: over which walls does the vehicle of a whole impact roll, and how sure is that?"""

import click

from tailslap.case.case import WHOLE_IMPACT
from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later

SAMPLES = "Combinations of inputs, at least."
RANGE = "Vary a key between two values, like tipping.centre_height='1.2 m:1.5 m'."

STUDY = Study(
    name="tipping",
    summary="Roll over wall height and centre height; the lowest wall that holds, its band and Sobol indices.",
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
            ["--fix", "fixed"], multiple=True, metavar="KEY", help="Keep a key that varies by default."
        ),
        WORKERS,
    ),
)
