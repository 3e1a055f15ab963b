"""The study `uncertainty`: scatter of the forces due to uncertain inputs, and Sobol indices of the inputs."""

import click

from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.options import Whole
from tailslap.studies.study import Study, later

OPTIONS = (
    click.Option(
        ["--samples"],
        type=Whole(288, 4_000_000),
        help="Minimum number of samples  [default: 100000; whole impact: 4000]",
    ),
    click.Option(
        ["--range", "ranges"],
        multiple=True,
        metavar="KEY=LOWER:UPPER",
        help="Range of a key, e.g. impact.friction=0.2:0.5 or impact.speed='50 mph:60 mph'.",
    ),
    click.Option(
        ["--fix", "fixed"], multiple=True, metavar="KEY", help="Keep a key fixed that varies by default."
    ),
)

STUDY = Study(
    name="uncertainty",
    summary="Uncertainty of the peak force, or of both strikes of a whole impact, with Sobol indices.",
    compute=later("tailslap.studies.uncertainty.compute:compute"),
    report=later("tailslap.studies.uncertainty.report:report"),
    options=OPTIONS,
    needs_plate=False,
    analyses=(CORNER, WHOLE_IMPACT),
)
