"""The study `stability`: a map of where the program is right, refuses, or catches itself, over pairs of axes."""

from __future__ import annotations

from pathlib import Path

import click

from tailslap.studies import study_arguments


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
@click.option("--workers", type=click.IntRange(1, 256), help="Processes  [default: one a core]")
def command(
    name: str, changes: tuple[str, ...], out: Path | None, points: int, tolerance: float, workers: int | None
) -> int:
    """Map of stiff and extreme cases: right, flexible, refused, caught, or wrong; exit 1 if a cell is wrong."""
    from tailslap.fe_plan import needed_plate
    from tailslap.plan import make_plan
    from tailslap.result_folder import demand_place, result_folder
    from tailslap.scene_files import read_scene
    from tailslap.studies.stability.survey import survey

    plan = make_plan(*read_scene(name, changes))
    needed_plate(plan.scene)
    place = out or Path("results") / f"{plan.scene.name}-stability"
    demand_place(place)
    found = survey(plan, points, tolerance, place, workers)
    with result_folder(place) as folder:
        from tailslap.studies.stability.write import write_map

        write_map(found, folder)
    from tailslap.studies.stability.words import lines

    click.echo("\n".join([*lines(found), f"Report: {place / 'report.html'}"]))
    return 1 if found.counts["wrong"] else 0
