"""The study `uncertainty`: how forces spread when the inputs do, and which input that comes from."""

import click

from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.options import Whole
from tailslap.studies.study import Study, later

OPTIONS = (
    click.Option(
        ["--samples"],
        type=Whole(288, 4_000_000),
        help="Combinations of inputs, at least  [default: 100000; of a whole impact 4000]",
    ),
    click.Option(
        ["--range", "ranges"],
        multiple=True,
        metavar="KEY=LOWER:UPPER",
        help="Vary a key between two values, like impact.friction=0.2:0.5 or impact.speed='50 mph:60 mph'.",
    ),
    click.Option(
        ["--fix", "fixed"], multiple=True, metavar="KEY", help="Leave a key that varies by default alone."
    ),
)

STUDY = Study(
    name="uncertainty",
    summary="Spread of the peak force, or of a whole impact's strikes, over ranges of the inputs; Sobol indices.",
    compute=later("tailslap.studies.uncertainty.compute:compute"),
    report=later("tailslap.studies.uncertainty.report:report"),
    options=OPTIONS,
    needs_plate=False,
    analyses=(CORNER, WHOLE_IMPACT),
)
