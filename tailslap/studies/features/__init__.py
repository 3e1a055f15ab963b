"""The study `features`: what each part of a scene costs, and the proof that a part left out costs nothing."""

from __future__ import annotations

from pathlib import Path

import click

from tailslap.studies import study_arguments, with_elements

DEFAULT_TURNS, LEAST_TURNS, MOST_TURNS = 40, 10, 10_000


@click.command("features")
@study_arguments
@click.option(
    "--turns",
    type=click.IntRange(LEAST_TURNS, MOST_TURNS),
    default=DEFAULT_TURNS,
    show_default=True,
    help="Turns in which all loops are timed, one after the other.",
)
@click.option("--no-processes", is_flag=True, help="Time no whole commands and their imports.")
def command(name: str, changes: tuple[str, ...], out: Path | None, turns: int, no_processes: bool) -> int:
    """Time and imports that each part of the scene costs; a part left out must cost nothing."""
    from tailslap.planning.plan import make_plan
    from tailslap.results.result_folder import result_folder
    from tailslap.scene.files import read_scene

    changes = with_elements(make_plan(*read_scene(name, changes)), changes)
    plan = make_plan(*read_scene(name, changes))
    place = out or Path("results") / f"{plan.scene.name}-features"
    with result_folder(place) as folder:
        from tailslap.studies.features.costs import find_costs
        from tailslap.studies.features.report.write import write_costs

        costs = find_costs(plan, turns, None if no_processes else (name, changes))
        write_costs(costs, folder)
    from tailslap.studies.features.report.terminal import print_costs

    print_costs(costs, place)
    return 0 if costs.proof.passed else 1
