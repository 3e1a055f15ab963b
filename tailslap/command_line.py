"""The command `tailslap`. Messages go to standard error, results to standard output."""

from __future__ import annotations

import functools
import io
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tailslap.options import (
    ALLOW_LARGE,
    FORCE,
    JSON,
    PROGRESS,
    QUIET,
    SCENE,
    SET,
    UNITS,
    Folder,
    Real,
    Whole,
    tell,
    with_options,
)

# The matrices are small or sparse: threads of BLAS would only disturb each other, a hundredfold where cores are busy.
# Set before NumPy is loaded, and taken over by worker processes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# No plugin of Pydantic concerns a scene; to look for them it reads the records of all installed packages.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")

import tailslap
from tailslap.api.commands import compare, export
from tailslap.campaign.command import sweep
from tailslap.errors import InputError, Interrupted, escaped, machine_fault, shortened
from tailslap.studies import study

if TYPE_CHECKING:
    from postprocess.report.report import Report
    from tailslap.case.case import Case

DONE, CHECK_FAILED, WRONG_INPUT, CANNOT_RUN, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit statuses; CANNOT_RUN is for an installation or a machine that lacks something."""

COMPLETE = "_TAILSLAP_COMPLETE"
"""Set by a shell that asks for completions."""

HELP = {"help_option_names": ["-h", "--help"]}


def fe_scene(function: Callable[..., int]) -> Callable[..., int]:
    """SCENE, --set and --allow-large of a command that takes the case of a scene with a plate."""

    @functools.wraps(function)
    def command(name: str, changes: tuple[str, ...], allow_large: bool, **options: Any) -> int:
        from tailslap.case.cost import demand_run

        case = _case(name, changes)
        demand_run(case.scene, case.duration, allow_large)
        return function(case, **options)

    return with_options(SCENE, SET, ALLOW_LARGE)(command)


@click.group(context_settings=HELP)
@click.version_option(tailslap.__version__, prog_name="tailslap")
def commands() -> None:
    """Check the rigid-body method for vehicle impact on bridge parapets by finite elements.

    SCENE is a TOML file or the name of a scene that comes with the program: see `tailslap scenes`.
    """


@commands.command()
@fe_scene
@click.option("--out", type=Folder(), help="Result folder  [default: results/NAME]")
@click.option("--no-pictures", is_flag=True, help="Draw no contour pictures; VTK is then not loaded.")
@click.option(
    "--tolerance",
    type=Real(0.0, 1.0, min_open=True, max_open=True),
    help="Pick the cheapest mesh and constraint for this relative error.",
)
@click.option("--resume", is_flag=True, help="Go on from the checkpoint of an interrupted run.")
@with_options(FORCE, UNITS, JSON, QUIET, PROGRESS)
def run(
    case: Case,
    out: Path | None,
    no_pictures: bool,
    tolerance: float | None,
    resume: bool,
    force: bool,
    units: str,
    as_json: bool,
) -> int:
    """Run a scene: rigid solution, mesh, FE run, comparison, pictures, report."""
    from postprocess.report.units import SYSTEMS
    from tailslap.files.checkpoints import checkpointed
    from tailslap.files.folder import demand_own, demand_place
    from tailslap.report.deliver import deliver, leave

    place = out or Path("results") / case.scene.name
    demand_own(place, case.scene.name, force)
    demand_place(place)
    with checkpointed(place, {"scene": case.source.given, "tolerance": tolerance}, resume):
        outcome = case.run(tolerance)
        if not no_pictures:  # what was computed is there, whatever becomes of the pictures
            leave(place, lambda folder: case.report(outcome, folder, False), units=units)

        def report(folder: Path) -> Report:
            return case.report(outcome, folder, not no_pictures, SYSTEMS[units])

        return deliver(place, report, as_json=as_json, units=units)


@commands.command()
@with_options(SCENE, SET, UNITS, JSON, QUIET)
def rigid(name: str, changes: tuple[str, ...], as_json: bool, units: str) -> int:
    """The rigid-body method, or the rigid vehicle's whole impact, alone."""
    from postprocess.report.terminal import labelled_text

    if as_json and units == "us":
        raise InputError("--units", units, "--json is in SI always; leave out one of the two")
    case = _case(name, changes)
    if as_json:
        return tell(case.rigid_numbers(), "", True)
    return tell({}, labelled_text(case.rigid_text(units), 19), False)


commands.add_command(study)
commands.add_command(sweep)
commands.add_command(export)
commands.add_command(compare)


@commands.command()
@with_options(SCENE, SET, ALLOW_LARGE, UNITS, JSON, QUIET)
def check(name: str, changes: tuple[str, ...], allow_large: bool, units: str, as_json: bool) -> int:
    """Say what a run would use, leave out and cost; run nothing."""
    from postprocess.report.terminal import labelled_text
    from postprocess.report.units import US
    from tailslap.report.check_text import LABEL, as_numbers

    case = _case(name, changes)
    lines = case.check_text(allow_large)
    text = labelled_text(lines if units == "si" else [US.said(line) for line in lines], LABEL)
    return tell(as_numbers(case.scene.name, lines), text, as_json)


@commands.command()
@fe_scene
@click.option(
    "--count", type=Whole(1, 1000), default=10, show_default=True, help="Elastic modes, the lowest."
)
@click.option("--out", type=Folder(), help="Result folder  [default: results/NAME-modes]")
@with_options(FORCE, UNITS, JSON, QUIET, PROGRESS)
def modes(case: Case, count: int, out: Path | None, force: bool, units: str, as_json: bool) -> int:
    """Natural frequencies of the plate, with pictures."""
    from tailslap.case.corner.case import CornerCase
    from tailslap.files.folder import demand_own
    from tailslap.report.deliver import deliver

    def report(folder: Path) -> Report:
        from tailslap.modal_analysis.modes import find_modes, modes_report

        return modes_report(find_modes(fe_plan, count))

    fe_plan = CornerCase(case.scene, case.source).plan()
    place = out or Path("results") / f"{case.scene.name}-modes"
    demand_own(place, case.scene.name, force)
    return deliver(place, report, as_json=as_json, units=units)


@commands.command()
@fe_scene
@click.option(
    "--modes", type=Whole(1, 200), default=4, show_default=True, help="Elastic modes to keep, the lowest."
)
@click.option("--steps", type=Whole(10, 1_000_000), default=100, show_default=True, help="Time steps.")
@click.option(
    "--tolerance",
    type=Real(0.0, 1.0, min_open=True),
    default=1e-5,
    show_default=True,
    help="Relative error allowed.",
)
@with_options(UNITS, JSON, QUIET)
def modal(case: Case, modes: int, steps: int, tolerance: float, units: str, as_json: bool) -> int:
    """Run a scene with a few modes of the plate."""
    from tailslap.case.corner.case import CornerCase
    from tailslap.modal_analysis.run import modal_numbers, modal_run, modal_text

    fe_plan = CornerCase(case.scene, case.source).plan()
    found = modal_run(fe_plan, modes, tolerance, steps)
    tell(modal_numbers(fe_plan, found), modal_text(fe_plan, found, units), as_json)
    return DONE if found.passed else CHECK_FAILED


@commands.command()
@with_options(JSON, QUIET)
def scenes(as_json: bool) -> int:
    """List the scenes that come with the program."""
    from postprocess.report.terminal import labelled_text
    from tailslap.scene.read import shipped_scenes, title

    shipped = {name: title(text) for name, text in shipped_scenes().items()}
    width = max(map(len, shipped))
    lines = [f"{name:<{width}}  {text}" for name, text in shipped.items()]
    return tell(shipped, labelled_text(lines, width + 2), as_json)


@commands.command()
@click.argument("name", metavar="NAME")
@with_options(JSON, QUIET)
def new(name: str, as_json: bool) -> int:
    """Write NAME.toml: a scene with every key, its meaning, and an example."""
    from tailslap.scene.write import write_new_scene

    path = write_new_scene(name)
    return tell({"scene": name, "file": str(path)}, f"{path}: see `tailslap check {path}`", as_json)


@commands.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@with_options(JSON, QUIET)
def completion(shell: str, as_json: bool) -> int:
    """Print what makes a shell complete commands, options, scenes and keys.

    For bash, in ~/.bashrc: eval "$(tailslap completion bash)"
    """
    from click.shell_completion import get_completion_class

    made = get_completion_class(shell)
    script = made(commands, {}, "tailslap", COMPLETE).source() if made else ""
    return tell({"shell": shell, "script": script}, script, as_json)


@commands.command()
@click.option("--out", type=Folder(), help="Result folder  [default: results/paper]")
@with_options(JSON, QUIET)
def paper(out: Path | None, as_json: bool) -> int:
    """Write the paper's tables and figures, computed beside printed."""
    from tailslap.progress import announced
    from tailslap.report.deliver import deliver

    def report(folder: Path) -> Report:
        from tailslap.paper import page, tables

        with announced("Computing the paper's tables ..."):
            return page.paper_report(tables.review())

    return deliver(out or Path("results") / "paper", report, "paper.html", as_json)


def _case(name: str, changes: tuple[str, ...]) -> Case:
    """The case of a scene as it was asked for; what is not plausible is remarked."""
    from tailslap.case import case_of
    from tailslap.scene.read import read_scene, remarks

    scene, source = read_scene(name, changes)
    for remark in remarks(source):
        click.echo(f"tailslap: remark: {remark}", err=True)
    return case_of(scene, source)


def main(arguments: list[str] | None = None) -> None:
    """Entry point: run a command and leave with its exit status."""
    from tailslap import process

    process.open_closed_streams()
    process.take_signals_as_interrupts()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters shows question marks
    status = _status(arguments)
    process.drop_unwritten()
    sys.exit(status)


def _status(arguments: list[str] | None) -> int:
    try:
        status = _run(arguments)
        sys.stdout.flush()
        return status
    except InputError as error:
        return _complain(str(error), WRONG_INPUT)
    except click.ClickException as error:
        said = io.StringIO()
        error.show(said)
        click.echo(escaped(said.getvalue()), err=True, nl=False)
        return WRONG_INPUT
    except (KeyboardInterrupt, click.Abort) as error:
        kept = error.__cause__ if isinstance(error.__cause__, Interrupted) else error
        return _complain(str(kept) or "interrupted; nothing was written", INTERRUPTED)
    except BrokenPipeError:
        return DONE
    except MemoryError:
        return _complain("the memory of this machine does not hold this mesh: see plate.elements", CANNOT_RUN)
    except ImportError as error:
        return _complain(f"{error}\n`python3 bootstrap.py` in the checkout says what is missing", CANNOT_RUN)
    except OSError as error:
        return _complain(machine_fault(error), CANNOT_RUN)
    except Exception as error:  # a fault of the program: one line, as everywhere; the rest on demand
        if os.environ.get("TAILSLAP_TRACEBACK"):
            raise
        why = f"a fault of the program, {type(error).__name__}: {shortened(str(error))}"
        return _complain(f"{why}\nwith TAILSLAP_TRACEBACK=1 it shows where; please report it", CANNOT_RUN)


def _run(arguments: list[str] | None) -> int:
    """Not by `commands.main`, which ends with 1 where the reader of a pipe leaves."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    if COMPLETE in os.environ:
        from click.shell_completion import shell_complete

        return shell_complete(commands, {}, "tailslap", COMPLETE, os.environ[COMPLETE])
    try:
        with commands.make_context("tailslap", given) as context:
            status = commands.invoke(context)
    except click.exceptions.Exit as left:
        return left.exit_code
    return status if isinstance(status, int) else DONE


def _complain(message: str, status: int) -> int:
    click.echo(f"tailslap: {escaped(message)}", err=True)
    return status


if __name__ == "__main__":
    main()
