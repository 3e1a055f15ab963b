"""The study `strike`: the forces of a whole impact against its inputs, as bands, and against the plate's stiffness."""

import click

from tailslap.case.case import WHOLE_IMPACT
from tailslap.options import Whole
from tailslap.studies.study import Study, later
from tailslap.studies.uncertainty import FIXED, RANGES

SAMPLES = click.Option(
    ["--samples"],
    type=Whole(288, 100_000),
    default=4_000,
    show_default=True,
    help="Impacts of the bands, at least.",
)

STUDY = Study(
    name="strike",
    summary="Peaks, impulses and durations of both strikes: against each input, as bands, beside Tables 4 and 5.",
    compute=later("tailslap.studies.strike.campaign:study_strike"),
    report=later("tailslap.studies.strike.report:strike_report"),
    options=(SAMPLES, RANGES, FIXED),
    needs_plate=False,
    analyses=(WHOLE_IMPACT,),
)
