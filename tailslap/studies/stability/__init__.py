"""Study `stability` of stiff and extreme cases."""

import click

from tailslap.options import WORKERS, Real, Whole
from tailslap.studies.study import Study, later

POINTS = click.Option(
    ["--points"],
    type=Whole(2, 40),
    help="Number of values of each of eight axes; 10 yield 2 800 cells  [default: 10; whole impact: 6]",
)
TOLERANCE = click.Option(
    ["--tolerance"],
    type=Real(1e-9, 0.1),
    help="Largest difference from the rigid motion of a correct cell  [default: 1e-3; whole impact: 1e-2]",
)
RANDOM = click.Option(
    ["--random", "count"], type=Whole(1, 10_000), help="Number of random scenes in place of the map."
)
SEED = click.Option(
    ["--seed"], type=Whole(0), default=1, show_default=True, help="Random seed, with --random."
)

STUDY = Study(
    name="stability",
    summary="Map of stiff and extreme cases with verdicts.\n\nExit status 1 for an undetected error.",
    compute=later("tailslap.studies.stability.stability_study:compute"),
    report=later("tailslap.studies.stability.stability_report:report"),
    options=(POINTS, TOLERANCE, RANDOM, SEED, WORKERS),
    folder=lambda options: "random" if options["count"] else "stability",
)
