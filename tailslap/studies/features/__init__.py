"""The study `features`: what each part of a scene costs, and the proof that a part left out costs nothing."""

import click

from tailslap.analysis import later
from tailslap.options import Whole
from tailslap.studies.study import Study

TURNS = click.Option(
    ["--turns"],
    type=Whole(10, 10_000),
    default=40,
    show_default=True,
    help="Turns in which all loops are timed, one after the other.",
)

STUDY = Study(
    name="features",
    summary="Time that each part of the scene costs; a part left out must cost nothing.",
    compute=later("tailslap.studies.features.costs:study_costs"),
    report=later("tailslap.studies.features.report:costs_report"),
    options=(TURNS,),
)
