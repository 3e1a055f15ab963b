"""Study `tipping` of the roll of vehicles in space over walls."""

import click

from tailslap.case.case import WHOLE_IMPACT
from tailslap.options import WORKERS, Whole
from tailslap.studies.study import Study, later, range_options

SAMPLES = "Minimum number of samples."

STUDY = Study(
    name="tipping",
    summary="Lowest walls that keep uncertain vehicles upright.\n\n"
    "Walls for 5, 50 and 95 % of the vehicles, force and its height, Sobol indices.",
    compute=later("tailslap.studies.tipping.tipping_study:compute"),
    report=later("tailslap.studies.tipping.tipping_report:report"),
    needs_plate=False,
    analyses=(WHOLE_IMPACT,),
    options=(
        click.Option(
            ["--samples"], type=Whole(128, 4_000_000), default=2048, show_default=True, help=SAMPLES
        ),
        *range_options("body.centre_height='1.2 m:1.5 m' or 'axle.*.spring'=0.5:2"),
        WORKERS,
    ),
)
