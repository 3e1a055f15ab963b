"""Define the commands of `tailslap` and call the functions of their names."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import tailslap
from postprocess.fields import FORMATS
from tailslap import errors, options, studies
from tailslap.arguments import UnitSystem
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.exports import PROGRAMS, SOLVERS
from tailslap.scene import read
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source, changes_of
from tailslap.storage.folder import commit, default_place, result_folder
from tailslap.storage.manifest import Origin
from tailslap.studies.study import Study, prepared

if TYPE_CHECKING:
    from typing import Literal

    from postprocess.report.command_report import Report
    from tailslap.result.result import Result

DONE, CHECK_FAILED = 0, 1
"""Exit statuses of a completed command."""

COMPLETE = "_TAILSLAP_COMPLETE"
"""Environment variable that a shell sets to request completions."""

PICTURES_HELP = (
    "Pixels of the pictures; letters and lines are in proportion  [default: 1600x700, of animations less]"
)

HELP = {"help_option_names": ["-h", "--help"]}
option = functools.partial(click.option, show_default=True)


def takes_a_case(function: Callable[..., int]) -> Callable[..., int]:
    """Decorate a command with SCENE and --set, and pass it the case."""

    @functools.wraps(function)
    def command(name: str, changes: tuple[str, ...], **arguments: object) -> int:
        return function(case_of(*scene_with_remarks(name, changes)), **arguments)

    return options.with_options(options.SCENE, options.SET)(command)


def place_of(case: Case, ending: str = "") -> Path:
    """Return the default result folder of a command on a case."""
    return default_place(case.scene.name, case.changes, ending)


def scene_with_remarks(name: str, changes: tuple[str, ...]) -> tuple[Scene, Source]:
    """Return a scene with its source, and print remarks on unusual numbers."""
    scene, source = read.read_scene(name, changes)
    remark_on(source)
    return scene, source


def remark_on(source: Source) -> None:
    """Print remarks on unusual numbers in a scene."""
    for remark in read.remarks(source):
        click.echo(f"tailslap: remark: {remark}", err=True)


def deliver(
    compute: Callable[[], Result],
    place: Path,
    origin: Origin,
    as_json: bool,
    units: str = "si",
    *,
    inputs: tuple[Path, ...] = (),
    force: bool = False,
    page: str = "",
) -> int:
    """Compute a result, write it to a locked folder and print it.

    page: file name of the page, by default that of a report.
    """
    with result_folder(place, inputs, force, origin) as folder:
        fill = compute().fill
        assert fill is not None
        report = fill(folder, True, units)
    return conclude(report, place, as_json, page)


def conclude(
    report: Report | None, place: Path, as_json: bool, page: str = "", most: float = math.inf
) -> int:
    """Print the report in `most` lines, or its summary as JSON.

    Returns the exit status.
    """
    from postprocess.report.command_report import PAGE, report_text

    assert report is not None
    options.report(report.numbers, report_text(report, place, page or PAGE, most), as_json)
    return DONE if report.passed else CHECK_FAILED


def show(result: Result, as_json: bool) -> int:
    """Print a result, or its summary as JSON.

    Returns the exit status.
    """
    options.report(result.summary, result.text, as_json)
    return CHECK_FAILED if result.passed is False else DONE


@click.group(context_settings=HELP)
@click.version_option(tailslap.__version__, prog_name="tailslap")
def commands() -> None:
    """Verify rigid-body impacts on bridge parapets by finite elements.

    SCENE is a TOML file or the name of a scene of the program, listed by `tailslap scenes`.
    """


@commands.command()
@options.with_options(options.SCENE, options.SET, options.ALLOW_LARGE)
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/NAME+CHANGES]")
@click.option("--picture-size", type=options.PictureSize(), metavar="WIDTHxHEIGHT", help=PICTURES_HELP)
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
    allow_large: bool,
    out: Path | None,
    picture_size: tuple[int, int] | None,
    no_pictures: bool,
    tolerance: float | None,
    resume: bool,
    full: bool,
    no_band: bool,
    force: bool,
    units: str,
    as_json: bool,
) -> int:
    """Run a scene and write the result folder.

    A run solves the rigid body, makes the mesh, integrates the FE model, compares both, and writes pictures and a
    report.
    """
    from postprocess.fields import canvas
    from postprocess.report.terminal import SCREEN
    from tailslap.campaign.records import program
    from tailslap.storage import checkpoints

    scene, source = scene_with_remarks(name, changes)
    case = case_of(scene, source)
    place, origin = out or place_of(case), Origin("run", case.scene.name, case.changes)
    definition = {"program": program(), "scene": case.source.tables, "tolerance": tolerance}
    with result_folder(place, force=force, origin=origin) as folder:
        if scene.contact is None and not no_pictures:
            canvas.load_beside()
        with checkpoints.checkpointed(place, definition, resume):
            result = tailslap.run(
                case,
                tolerance=tolerance,
                allow_large=allow_large,
                picture_size=picture_size,
                band=not no_band,
            )
            assert result.fill is not None
            report = result.fill(folder, False, units)
            commit(folder.parent, origin)  # results are stored even if the pictures fail
        if not no_pictures:
            report = result.fill(folder, True, units)
    return conclude(report, place, as_json, most=math.inf if full else SCREEN)


@commands.command()
@takes_a_case
@options.with_options(options.NO_BAND, *options.PRINTED)
def rigid(case: Case, no_band: bool, as_json: bool, units: UnitSystem) -> int:
    """Solve the rigid-body method, or the whole impact of the rigid vehicle."""
    if as_json and units == "us":
        raise errors.InputError("--units", units, "--json is always in SI; remove one of the two options")
    return show(tailslap.rigid(case, units=units, band=not no_band), as_json)


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


@commands.command("study", cls=Studies, subcommand_metavar="NAME SCENE [OPTIONS]...")
def study() -> None:
    """Run a study of a scene.

    `tailslap study NAME --help` lists its options.
    """


def study_command(chosen: Study) -> click.Command:
    """Return the command of a study with its options."""
    help_out = f"Result folder  [default: results/NAME+CHANGES-{chosen.name}]"
    out = click.Option(["--out", "folder"], type=options.Folder(), help=help_out)
    shared = [options.SCENE, options.SET, out, options.ALLOW_LARGE, options.FORCE, *options.WATCHED]

    def run(name: str, changes: tuple[str, ...], units: str, as_json: bool, **settings: Any) -> int:
        from tailslap import api

        folder, allow_large, force = (settings.pop(key) for key in ("folder", "allow_large", "force"))
        case = case_of(*scene_with_remarks(name, changes))
        place, origin = prepared(chosen, case, folder, allow_large, settings)
        compute = functools.partial(api.study_result, chosen, case, place, settings)
        return deliver(compute, place, origin, as_json, units, force=force)

    return click.Command(chosen.name, params=[*shared, *chosen.options], callback=run, help=chosen.summary)


@commands.command()
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
@option("--seed", type=options.Whole(0), default=307, help="Random seed of the samples.")
@click.option(
    "--out", "folder", type=options.Folder(), help="Result folder  [default: results/NAME+CHANGES-sweep]"
)
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
    folder: Path | None,
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
    remark_on(varied_source(definition))
    place = folder or default_place(definition.scene, changes_of(definition.source), "-sweep")
    try:
        return show(sweep_result(definition, place, **execution), as_json)
    except StoppedError as stopped:
        click.echo(f"tailslap: {stopped}", err=True)
        return stopped.status


@commands.command()
@click.argument("result", metavar="RESULT|SCENE", type=options.Folder())
@options.with_options(options.SET)
@click.option(
    "--to", type=click.Choice((*FORMATS, *PROGRAMS)), required=True, help="Format of the files, or program."
)
@click.option("--out", "folder", type=options.Folder(), help="Output folder  [default: RESULT-FORMAT]")
@click.option(
    "--field",
    type=options.Text(),
    help="Field shown by png and gif, e.g. stress_von_mises  [default: all fields]",
)
@option(
    "--magnify",
    type=options.Real(0.0, 1e9),
    default=1.0,
    help="Magnification of the elastic deformation in png and gif.",
)
@click.option("--picture-size", type=options.PictureSize(), metavar="WIDTHxHEIGHT", help=PICTURES_HELP)
@options.with_options(options.FORCE_READ, *options.PRINTED)
def export(result: Path, as_json: bool, **arguments: Any) -> int:
    """Export a result or a scene for other programs.

    RESULT is a result folder, whose fields and histories are written for ParaView, Gmsh or data frames. Mesh and fields
    require a run with --set output.fields=N; csv and parquet contain the histories of any run. calculix and abaqus are
    input files of a SCENE that run as they are.
    """
    written = tailslap.export(result, **arguments)
    return options.report({"written": written}, f"Written: {written}", as_json)


@commands.command()
@click.argument("results", metavar="RESULT RESULT...", nargs=-1, required=True, type=options.Folder())
@click.option(
    "--columns",
    type=options.Text(),
    metavar="NAME=THEIRS,...",
    help="Column names of the files, or numbers of columns without names, e.g. 'time=t,v_gy=-VY [mph]'; a minus "
    "reverses the sign. '2:time=t [ms]' is for the second result alone.",
)
@click.option("--only", type=options.Text(), metavar="NAME,...", help="Columns to compare.")
@click.option(
    "--decimal-comma",
    "decimal_commas",
    type=options.Whole(min=1),
    multiple=True,
    metavar="NUMBER",
    help="Number of a result, from 1, that is a text file with decimal commas. Repeatable.",
)
@click.option("--author", type=options.Text(), metavar="NAME", help="Name on the page validation.html.")
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/compare]")
@options.with_options(options.FORCE_READ, *options.PRINTED)
def compare(
    results: tuple[Path, ...],
    columns: str | None,
    only: str | None,
    author: str | None,
    out: Path | None,
    force: bool,
    units: str,
    as_json: bool,
    **arguments: Any,
) -> int:
    """Compare results with the first one.

    The report has curves, differences and validation metrics. The page validation.html has the form of NCHRP W179:
    solution verification, metrics of all channels, phenomena.

    A RESULT is a result folder, a text file with columns: a history from ABAQUS, LS-DYNA or a test; an ISO-MME channel;
    a Parquet file of export; or nodes of CalculiX (.dat), LS-DYNA (nodout), ABAQUS (field output report) or OpenRadioss
    (CSV). Exit status 1 if a metric exceeds the limits of NCHRP W179, or less than half of the reference's time is
    compared.
    """
    names = tuple(name.strip() for name in (only or "").split(",") if name.strip())

    arguments |= {"columns": columns, "only": names, "author": author or "", "force": force}
    compute, place = (
        functools.partial(tailslap.compare, *results, **arguments),
        out or default_place("compare", ()),
    )
    return deliver(compute, place, Origin("compare", ""), as_json, units, inputs=results, force=force)


@commands.command()
@takes_a_case
@options.with_options(options.ALLOW_LARGE)
@option("--with", "program", type=click.Choice(SOLVERS), default=SOLVERS[0], help="Solver.")
@option(
    "--time-limit",
    type=options.Real(0.0, 1e7, min_open=True),
    default=600.0,
    help="Longest time of the solver, in s.",
)
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/NAME+CHANGES-confirm]")
@options.with_options(options.FORCE, *options.WATCHED)
def confirm(case: Case, out: Path | None, force: bool, units: str, as_json: bool, **arguments: Any) -> int:
    """Run a scene in another solver and compare the motions.

    The motion is compared with the exact one. The solver must be installed; exit status 1 if the difference exceeds the
    limit, 3 if the solver fails.
    """
    place = out or place_of(case, "-confirm")
    compute = functools.partial(tailslap.confirm, case, **arguments)
    return deliver(
        compute, place, Origin("confirm", case.scene.name, case.changes), as_json, units, force=force
    )


@commands.command()
@takes_a_case
@options.with_options(options.ALLOW_LARGE, *options.PRINTED)
def check(case: Case, as_json: bool, **arguments: Any) -> int:
    """Show model, automatic choices and estimated cost of a run.

    Nothing is run.
    """
    return show(tailslap.check(case, **arguments), as_json)


@commands.command()
@takes_a_case
@options.with_options(options.ALLOW_LARGE)
@option("--count", type=options.Whole(1, 1000), default=10, help="Number of elastic modes.")
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/NAME+CHANGES-modes]")
@options.with_options(options.FORCE, *options.WATCHED)
def modes(case: Case, out: Path | None, force: bool, units: str, as_json: bool, **arguments: Any) -> int:
    """Compute the natural frequencies and mode shapes of the free plate."""
    place = out or place_of(case, "-modes")
    compute = functools.partial(tailslap.modes, case, **arguments)
    return deliver(
        compute, place, Origin("modes", case.scene.name, case.changes), as_json, units, force=force
    )


@commands.command()
@takes_a_case
@options.with_options(options.ALLOW_LARGE)
@option("--modes", type=options.Whole(1, 200), default=4, help="Number of elastic modes, lowest first.")
@option("--steps", type=options.Whole(10, 1_000_000), default=100, help="Number of time steps.")
@option(
    "--tolerance",
    type=options.Real(0.0, 1.0, min_open=True),
    default=1e-5,
    help="Largest allowed relative error.",
)
@options.with_options(*options.PRINTED)
def modal(case: Case, as_json: bool, **arguments: Any) -> int:
    """Run a scene with the modal model of the plate."""
    return show(tailslap.modal(case, **arguments), as_json)


@commands.command()
@options.with_options(options.JSON, options.QUIET)
def scenes(as_json: bool) -> int:
    """List the scenes of the program."""
    from postprocess.report import terminal

    shipped = tailslap.scenes()
    width = max(map(len, shipped))
    lines = [f"{name:<{width}}  {text}" for name, text in shipped.items()]
    return options.report(shipped, terminal.labelled_text(lines, width + 2), as_json)


@commands.command()
@click.argument("name", metavar="NAME")
@options.with_options(options.JSON, options.QUIET)
def new(name: str, as_json: bool) -> int:
    """Write NAME.toml, a scene with every key, its meaning and an example."""
    path = tailslap.new(name)
    return options.report({"scene": name, "file": str(path)}, f"{path}: see `tailslap check {path}`", as_json)


@commands.command()
@click.argument(
    "name", metavar="[SCENE]", default="impact-mash-tl4-sut", shell_complete=options.complete_scene
)
@option("--out", type=options.File(), default="explore.html", help="File of the page.")
@click.option("--headless", is_flag=True, help="Write the page and open no browser.")
@options.with_options(options.JSON, options.QUIET)
def explore(name: str, out: Path, headless: bool, as_json: bool) -> int:
    """Open a page that computes whole impacts in any browser.

    Force, strikes, plan and band of the rigid vehicle follow number boxes and sliders. The page is one file that needs
    no network and no server; the kernels are those of this program, compiled to WebAssembly.
    """
    from tailslap.browser import page

    path = page.write(name, out)
    if not headless:
        click.launch(path.resolve().as_uri())
    return options.report({"scene": name, "file": str(path)}, str(path), as_json)


@commands.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@options.with_options(options.JSON, options.QUIET)
def completion(shell: str, as_json: bool) -> int:
    """Print the shell script for completion of commands, options, scenes and keys.

    For bash, in ~/.bashrc: eval "$(tailslap completion bash)"
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    script = kind(commands, {}, "tailslap", COMPLETE).source() if kind else ""
    return options.report({"shell": shell, "script": script}, script, as_json)


@commands.command()
@takes_a_case
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/NAME+CHANGES-parapet]")
@options.with_options(options.NO_BAND, options.FORCE, *options.WATCHED)
def parapet(case: Case, out: Path | None, no_band: bool, force: bool, units: str, as_json: bool) -> int:
    """Compare the strength of the parapet with the force of the impact.

    The flexural strength of [parapet] by AASHTO LRFD A13.3.1 and between proven bounds of limit analysis. Exit status
    1 if there is no proof, or the bounds differ by more than 1 %.
    """
    place, origin = out or place_of(case, "-parapet"), Origin("parapet", case.scene.name, case.changes)
    compute = functools.partial(tailslap.parapet, case, band=not no_band)
    return deliver(compute, place, origin, as_json, units, force=force)


@commands.command()
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/paper]")
@options.with_options(options.FORCE, options.JSON, options.QUIET)
def paper(out: Path | None, force: bool, as_json: bool) -> int:
    """Compare the tables and figures of the paper with computed values."""
    from tailslap.replication.paper_page import PAGE

    place = out or default_place("paper", ())
    return deliver(tailslap.paper, place, Origin("paper", ""), as_json, force=force, page=PAGE)


@commands.command()
@click.option(
    "--set",
    "ranges",
    type=click.Choice(["first", "second"]),
    default="second",
    help="Ranges of the inputs: fixed before the first prediction, or chosen later.",
    show_default=True,
)
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/validation]")
@options.with_options(options.FORCE, options.JSON, options.QUIET)
def validate(ranges: Literal["first", "second"], out: Path | None, force: bool, as_json: bool) -> int:
    """Compare published forces, durations and speeds with predictions."""
    from tailslap.validation.validation_report import PAGE

    place = out or default_place("validation", ())

    def computed() -> Result:
        return tailslap.validate(ranges)

    return deliver(computed, place, Origin("validate", ""), as_json, force=force, page=PAGE)
