"""The study `stability`: where the program is right, refuses, or catches itself, over pairs of axes.

With --random it draws scenes with all axes and choices at once, and compares each with a refined model.
"""

import click

from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.options import WORKERS, Real, Whole
from tailslap.studies.study import Study, later

POINTS = click.Option(
    ["--points"],
    type=Whole(2, 40),
    help="Values of each axis: eight axes with ten make 2 800 cells  [default: 10; of a whole impact 6]",
)
TOLERANCE = click.Option(
    ["--tolerance"],
    type=Real(1e-9, 0.1),
    help="Difference from the rigid motion up to which a cell is right  [default: 1e-3; of a whole impact 1e-2]",
)
RANDOM = click.Option(
    ["--random", "count"], type=Whole(1, 10_000), help="Draw so many scenes at random instead."
)
SEED = click.Option(
    ["--seed"], type=Whole(0), default=1, show_default=True, help="With --random: which draws."
)

STUDY = Study(
    name="stability",
    summary="Map of stiff and extreme cases: right, flexible, refused, caught, or wrong; exit 1 if a cell is wrong.",
    compute=later("tailslap.studies.stability.compute:compute"),
    report=later("tailslap.studies.stability.report:report"),
    options=(POINTS, TOLERANCE, RANDOM, SEED, WORKERS),
    analyses=(CORNER, WHOLE_IMPACT),
    folder=lambda options: "random" if options["count"] else "stability",
)
