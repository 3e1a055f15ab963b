"""Define the commands that calculate a scene."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Any

import click

import tailslap
from tailslap import delivery, errors, options, studies
from tailslap.arguments import UnitSystem
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.exports import SOLVERS
from tailslap.scene.vary import changes_of
from tailslap.storage.folder import commit, default_place, result_folder
from tailslap.storage.manifest import Origin
from tailslap.studies.study import Study, prepared


@click.command()
@options.with_options(
    options.SCENE, options.SET, options.ALLOW_LARGE, options.place_option(), options.PICTURE_SIZE
)
@click.option("--no-pictures", is_flag=True, help="Omit the contour images.")
@click.option(
    "--tolerance",
    type=options.Real(1e-8, 1.0, max_open=True),
    help="Refine the mesh until the relative error is below this value, of whole impacts at least 0.005.",
)
@click.option("--resume", is_flag=True, help="Resume from the checkpoint of an interrupted run.")
@click.option("--full", is_flag=True, help="Print all tables, in place of those that have room in 40 lines.")
@options.with_options(options.NO_BAND, options.FORCE, *options.WATCHED)
def run(
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    no_pictures: bool,
    resume: bool,
    full: bool,
    no_band: bool,
    force: bool,
    units: str,
    as_json: bool,
    **arguments: Any,
) -> int:
    """Run a scene and write the result folder.

    A run solves the rigid body, makes the mesh, integrates the FE model, compares both, and writes pictures and a
    report.
    """
    from postprocess.fields import canvas
    from postprocess.report.terminal import SCREEN
    from tailslap.campaign.records import program
    from tailslap.storage import checkpoints

    scene, source = delivery.scene_with_remarks(name, changes)
    case = case_of(scene, source)
    place = out or default_place(scene.name, case.changes)
    origin = Origin("run", scene.name, case.changes)
    definition = {"program": program(), "scene": case.source.tables, "tolerance": arguments["tolerance"]}
    with result_folder(place, force=force, origin=origin) as folder:
        if scene.contact is None and not no_pictures:
            canvas.load_beside()
        with checkpoints.checkpointed(place, definition, resume):
            result = tailslap.run(case, band=not no_band, **arguments)
            assert result.fill is not None
            report = result.fill(folder, False, units)
            commit(folder.parent, origin)  # results are stored even if the pictures fail
        if not no_pictures:
            report = result.fill(folder, True, units)
    return delivery.conclude(report, place, as_json, most=math.inf if full else SCREEN)


@click.command()
@delivery.takes_a_case
@options.with_options(options.NO_BAND, *options.PRINTED)
def rigid(case: Case, no_band: bool, as_json: bool, units: UnitSystem) -> int:
    """Solve the rigid-body method, or a rigid whole impact."""
    if as_json and units == "us":
        raise errors.InputError("--units", units, "--json is always in SI; remove one of the two options")
    return delivery.show(tailslap.rigid(case, units=units, band=not no_band), as_json)


class Studies(click.Group):
    """Subcommands of `tailslap study`, imported on demand."""

    def list_commands(self, context: click.Context) -> list[str]:
        """Return the names of the studies."""
        return studies.study_names()

    def get_command(self, context: click.Context, name: str) -> click.Command:
        """Return the command of a study.

        Raises InputError, with a list of the studies, for an unknown name.
        """
        return study_command(studies.find_study(name))


@click.command("study", cls=Studies, subcommand_metavar="NAME SCENE [OPTIONS]...")
def study() -> None:
    """Run a study of a scene.

    `tailslap study NAME --help` lists its options.
    """


def study_command(chosen: Study) -> click.Command:
    """Return the command of a study with its options."""
    out = options.place_option(f"-{chosen.name}")
    shared = [options.SCENE, options.SET, out, options.ALLOW_LARGE, options.FORCE, *options.WATCHED]

    def run(name: str, changes: tuple[str, ...], units: str, as_json: bool, **settings: Any) -> int:
        from tailslap import api
        from tailslap.campaign import records

        folder, allow_large, force = (settings.pop(key) for key in ("out", "allow_large", "force"))
        case = case_of(*delivery.scene_with_remarks(name, changes))
        place, origin = prepared(chosen, case, folder, allow_large, settings)
        compute = functools.partial(api.study_result, chosen, case, place, settings)
        with records.kept(place):
            return delivery.deliver(compute, place, origin, as_json, units, force=force)

    return click.Command(chosen.name, params=[*shared, *chosen.options], callback=run, help=chosen.summary)


@click.command()
@options.with_options(options.SCENE, options.SET)
@click.option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    metavar="KEY=VALUES",
    help="Values: n from a to b by a:b:n, n in equal ratios by log:a:b:n, or a list v1,v2,v3. Units as in a scene.",
)
@click.option(
    "--sample",
    type=options.Whole(2, options.MAX_RUNS),
    metavar="N",
    help="Latin hypercube of N runs in place of the grid; ranges are then a:b or log:a:b.",
)
@options.option("--seed", type=options.Whole(0), default=307, help="Random seed of the samples.")
@options.with_options(options.place_option("-sweep"))
@click.option(
    "--cluster",
    type=options.Text(),
    metavar="ADDRESS",
    help="Address of a Dask scheduler, e.g. tcp://10.0.0.1:8786.",
)
@click.option(
    "--workers",
    type=options.Whole(1, 1024),
    metavar="N",
    help="Number of worker processes  [default: number of cores]",
)
@options.with_options(options.FORCE, *options.WATCHED)
def sweep(
    name: str,
    changes: tuple[str, ...],
    varied: tuple[str, ...],
    sample: int | None,
    seed: int,
    out: Path | None,
    as_json: bool,
    **execution: Any,
) -> int:
    """Run a scene for many values of its keys.

    The result is a table with a row for each run. Interrupted or killed, the same command resumes, and repeats nothing.
    Exit status: 0 if every run passed its checks or was refused by the theory; 1 if one failed a check or ended in an
    error; 3 if the cluster was lost.
    """
    from tailslap.campaign.sweep_definition import make_definition, varied_source
    from tailslap.campaign.sweep_run import StoppedError, sweep_result

    definition = make_definition(name, changes, varied, sample, seed)
    delivery.remark_on(varied_source(definition))
    place = out or default_place(definition.scene, changes_of(definition.source), "-sweep")
    try:
        return delivery.show(sweep_result(definition, place, **execution), as_json)
    except StoppedError as stopped:
        click.echo(f"tailslap: {stopped}", err=True)
        return stopped.status


@click.command()
@delivery.takes_a_case
@options.with_options(options.ALLOW_LARGE)
@options.option("--with", "program", type=click.Choice(SOLVERS), default=SOLVERS[0], help="Solver.")
@options.option(
    "--time-limit",
    type=options.Real(0.0, 1e7, min_open=True),
    default=600.0,
    help="Longest time of the solver, in s.",
)
@options.with_options(options.place_option("-confirm"), options.FORCE, *options.WATCHED)
def confirm(case: Case, **arguments: Any) -> int:
    """Run a scene in another solver and compare the motions.

    The motion is compared with the exact one. The solver must be installed; exit status 1 if the difference exceeds the
    limit, 3 if the solver fails.
    """
    return delivery.deliver_case(tailslap.confirm, case, arguments)


@click.command()
@delivery.takes_a_case
@options.with_options(options.ALLOW_LARGE, *options.PRINTED)
def check(case: Case, as_json: bool, **arguments: Any) -> int:
    """Show model, automatic choices and estimated cost of a run.

    Nothing is run.
    """
    return delivery.show(tailslap.check(case, **arguments), as_json)


@click.command()
@delivery.takes_a_case
@options.with_options(options.ALLOW_LARGE)
@options.option("--count", type=options.Whole(1, 1000), default=10, help="Number of elastic modes.")
@options.with_options(options.place_option("-modes"), options.FORCE, *options.WATCHED)
def modes(case: Case, **arguments: Any) -> int:
    """Compute natural frequencies and mode shapes of the plate."""
    return delivery.deliver_case(tailslap.modes, case, arguments)


@click.command()
@delivery.takes_a_case
@options.with_options(options.ALLOW_LARGE)
@options.option(
    "--modes", type=options.Whole(1, 200), default=4, help="Number of elastic modes, lowest first."
)
@options.option("--steps", type=options.Whole(10, 1_000_000), default=100, help="Number of time steps.")
@options.option(
    "--tolerance",
    type=options.Real(0.0, 1.0, min_open=True),
    default=1e-5,
    help="Largest allowed relative error.",
)
@options.with_options(*options.PRINTED)
def modal(case: Case, as_json: bool, **arguments: Any) -> int:
    """Run a scene with the modal model of the plate."""
    return delivery.show(tailslap.modal(case, **arguments), as_json)


@click.command()
@delivery.takes_a_case
@options.with_options(options.place_option("-parapet"), options.NO_BAND, options.FORCE, *options.WATCHED)
def parapet(case: Case, no_band: bool, **arguments: Any) -> int:
    """Compare the strength of the parapet with the force.

    The flexural strength of [parapet] by AASHTO LRFD A13.3.1 and between proven bounds of limit analysis. Exit status
    1 if there is no proof, or the bounds differ by more than 1 %, 2 % under the load of this impact.
    """
    return delivery.deliver_case(tailslap.parapet, case, arguments | {"band": not no_band})
