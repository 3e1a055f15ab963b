"""The study `cost`: error against run time of every method and setting, and the cheapest for each error."""

from __future__ import annotations

from pathlib import Path

import click

from tailslap.studies import study_arguments, with_elements


@click.command("cost")
@study_arguments
def command(name: str, changes: tuple[str, ...], out: Path | None) -> int:
    """Error against run time, the cheapest setting for each error, grid convergence; goes on where it was stopped."""
    from tailslap.planning.plan import make_plan
    from tailslap.results.result_folder import demand_place, result_folder
    from tailslap.scene.files import read_scene
    from tailslap.studies.cost.survey import survey

    changes = with_elements(make_plan(*read_scene(name, changes)), changes)
    plan = make_plan(*read_scene(name, changes))
    place = out or Path("results") / f"{plan.scene.name}-cost"
    demand_place(place)
    found = survey(plan, name, changes, place)
    with result_folder(place) as folder:
        from tailslap.studies.cost.report.write import write_cost

        write_cost(found, folder)
    from tailslap.studies.cost.report.terminal import print_cost

    print_cost(found, place)
    return 0
