"""The study `stability`: a map of where the program is right, refuses, or catches itself, over pairs of axes.

With --random it draws scenes with all axes and choices at once, and holds each against a refined model.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from tailslap.studies import study_arguments

if TYPE_CHECKING:
    from tailslap.planning.plan import Plan


@click.command("stability")
@study_arguments
@click.option(
    "--points",
    type=click.IntRange(2, 40),
    default=10,
    show_default=True,
    help="Values of each axis: eight axes with ten make 2 800 cells.",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(1e-9, 0.1),
    default=1e-3,
    show_default=True,
    help="Difference from the rigid motion up to which a cell is right.",
)
@click.option(
    "--random", "count", type=click.IntRange(1, 10_000), help="Draw so many scenes at random instead."
)
@click.option(
    "--seed", type=click.IntRange(0), default=1, show_default=True, help="With --random: which draws."
)
@click.option("--workers", type=click.IntRange(1, 256), help="Processes  [default: one a core]")
def command(
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    points: int,
    tolerance: float,
    count: int | None,
    seed: int,
    workers: int | None,
) -> int:
    """Map of stiff and extreme cases: right, flexible, refused, caught, or wrong; exit 1 if a cell is wrong."""
    from tailslap.planning.fe_plan import needed_plate
    from tailslap.planning.plan import make_plan
    from tailslap.results.result_folder import demand_place
    from tailslap.scene.files import read_scene

    plan = make_plan(*read_scene(name, changes))
    needed_plate(plan.scene)
    place = out or Path("results") / f"{plan.scene.name}-{'random' if count else 'stability'}"
    demand_place(place)
    if count:
        return _random(plan, count, seed, place, workers)
    return _map(plan, points, tolerance, place, workers)


def _map(plan: Plan, points: int, tolerance: float, place: Path, workers: int | None) -> int:
    from tailslap.results.result_folder import result_folder
    from tailslap.studies.stability.report.words import lines
    from tailslap.studies.stability.survey import survey

    found = survey(plan, points, tolerance, place, workers)
    with result_folder(place) as folder:
        from tailslap.studies.stability.report.write import write_map

        write_map(found, folder)
    return _told(lines(found), place, found.counts["wrong"])


def _random(plan: Plan, count: int, seed: int, place: Path, workers: int | None) -> int:
    from tailslap.results.result_folder import result_folder
    from tailslap.studies.stability.random_survey import random_survey
    from tailslap.studies.stability.report.random_words import lines

    found = random_survey(plan, count, seed, place, workers)
    with result_folder(place) as folder:
        from tailslap.studies.stability.report.random_write import write_random

        write_random(found, folder)
    return _told(lines(found), place, found.counts["wrong"])


def _told(lines: list[str], place: Path, wrong: int) -> int:
    click.echo("\n".join([*lines, f"Report: {place / 'report.html'}"]))
    return 1 if wrong else 0
