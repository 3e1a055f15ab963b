"""The study `flexibility`: how soft may the vehicle be for the rigid-body method still to hold."""

from __future__ import annotations

from pathlib import Path

import click

from tailslap.studies import study_arguments


@click.command("flexibility")
@study_arguments
@click.option(
    "--points",
    type=click.IntRange(4, 100),
    default=16,
    show_default=True,
    help="First frequencies, at even ratios.",
)
@click.option("--lowest", default="0.1 Hz", show_default=True, metavar="FREQUENCY", help="The softest plate.")
@click.option(
    "--highest", default="1 kHz", show_default=True, metavar="FREQUENCY", help="The stiffest plate."
)
@click.option("--workers", type=click.IntRange(1, 256), help="Processes  [default: one a core]")
def command(
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    points: int,
    lowest: str,
    highest: str,
    workers: int | None,
) -> int:
    """Rigid to soft plates: how far the five quantities, reaction and stored energy are from the rigid values."""
    from tailslap.planning.fe_plan import needed_plate
    from tailslap.planning.plan import make_plan
    from tailslap.results.result_folder import demand_place, result_folder
    from tailslap.scene.files import read_scene
    from tailslap.studies.flexibility.survey import survey
    from tailslap.studies.flexibility.sweep import frequencies

    plan = make_plan(*read_scene(name, changes))
    needed_plate(plan.scene)
    sweep = frequencies(lowest, highest, points)
    place = out or Path("results") / f"{plan.scene.name}-flexibility"
    demand_place(place)
    found = survey(plan, sweep, place, workers)
    with result_folder(place) as folder:
        from tailslap.studies.flexibility.report.write import write_flexibility

        write_flexibility(found, folder)
    from tailslap.studies.flexibility.report.terminal import print_flexibility

    print_flexibility(found, place)
    return 0 if any(point.passed for point in found.points) else 1
