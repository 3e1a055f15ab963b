"""Study `uncertainty` of forces for uncertain inputs."""

import click

from tailslap.options import Whole
from tailslap.studies.study import Study, later, range_options

OPTIONS = (
    click.Option(
        ["--samples"],
        type=Whole(288, 4_000_000),
        help="Minimum number of samples  [default: 100000; whole impact: 4000]",
    ),
    *range_options("impact.friction=0.2:0.5 or impact.speed='50 mph:60 mph'"),
)

STUDY = Study(
    name="uncertainty",
    summary="Uncertainty of the force over assumed ranges, Sobol indices.",
    compute=later("tailslap.studies.uncertainty.uncertainty_study:compute"),
    report=later("tailslap.studies.uncertainty.uncertainty_report:report"),
    options=OPTIONS,
    needs_plate=False,
)
