"""The study `uncertainty`: how the peak force spreads when the inputs do, and which input it comes from."""

import click

from tailslap.options import Whole
from tailslap.studies.study import Study, later

SAMPLES = click.Option(
    ["--samples"],
    type=Whole(1_000, 4_000_000),
    default=100_000,
    show_default=True,
    help="Combinations of inputs, at least.",
)
RANGES = click.Option(
    ["--range", "ranges"],
    multiple=True,
    metavar="KEY=LOWER:UPPER",
    help="Vary a key between two values, like impact.friction=0.2:0.5 or impact.speed='50 mph:60 mph'.",
)
FIXED = click.Option(
    ["--fix", "fixed"], multiple=True, metavar="KEY", help="Leave a key that varies by default alone."
)

STUDY = Study(
    name="uncertainty",
    summary="Spread of the peak force over ranges of the inputs, and its Sobol indices.",
    compute=later("tailslap.studies.uncertainty.spread:study_spread"),
    report=later("tailslap.studies.uncertainty.report:spread_report"),
    options=(SAMPLES, RANGES, FIXED),
    needs_plate=False,
)
