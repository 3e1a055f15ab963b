"""The command `tailslap`. Messages go to standard error, results to standard output."""

from __future__ import annotations

import io
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

# The matrices are small or sparse: threads of BLAS would only disturb each other, a hundredfold where cores are busy.
# Set before NumPy is loaded, and taken over by worker processes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tailslap
from tailslap.errors import InputError, Interrupted
from tailslap.studies import study
from tailslap.sweep.command import sweep

if TYPE_CHECKING:
    from postprocess.report.report import Report

DONE, CHECK_FAILED, WRONG_INPUT, CANNOT_RUN, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit statuses; CANNOT_RUN is for an installation or a machine that lacks something."""

HELP = {"help_option_names": ["-h", "--help"]}


def scene_arguments(function: Callable[..., Any]) -> Callable[..., Any]:
    """The argument SCENE and the option --set, which most commands share."""
    function = click.option(
        "--set",
        "changes",
        multiple=True,
        metavar="KEY=VALUE",
        help="Change a key, like plate.thickness=20mm; KEY= takes it out.",
    )(function)
    return click.argument("name", metavar="SCENE")(function)


@click.group(context_settings=HELP)
@click.version_option(tailslap.__version__, prog_name="tailslap")
def commands() -> None:
    """Check the rigid-body method for vehicle impact on bridge parapets by finite elements.

    SCENE is a TOML file or the name of a scene that comes with the program: see `tailslap scenes`.
    """


@commands.command()
@scene_arguments
@click.option("--out", type=click.Path(path_type=Path), help="Result folder  [default: results/NAME]")
@click.option("--no-pictures", is_flag=True, help="Draw no contour pictures; VTK is then not loaded.")
@click.option(
    "--tolerance", type=float, help="Pick the cheapest mesh and constraint for this relative error."
)
def run(
    name: str, changes: tuple[str, ...], out: Path | None, no_pictures: bool, tolerance: float | None
) -> int:
    """Run a scene: rigid solution, mesh, FE run, comparison, pictures, report."""
    from tailslap.analyses import needs_plate
    from tailslap.report.deliver import deliver

    analysis, plan = _planned(name, changes)
    needs_plate(plan.scene)

    def report(folder: Path) -> Report:
        return analysis.run_report(plan, folder, tolerance, not no_pictures)

    return deliver(out or Path("results") / plan.scene.name, report)


@commands.command()
@scene_arguments
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON, in SI.")
@click.option("--units", type=click.Choice(["si", "us"]), default="si", help="Units of the printed numbers.")
def rigid(name: str, changes: tuple[str, ...], as_json: bool, units: str) -> int:
    """The rigid-body method, or the rigid vehicle's whole impact, alone."""
    if as_json and units == "us":
        raise InputError("--units", units, "--json is in SI always; leave out one of the two")
    analysis, plan = _planned(name, changes)
    lines = analysis.rigid_lines(plan, units) if not as_json else []
    click.echo(json.dumps(analysis.rigid_numbers(plan), indent=2) if as_json else "\n".join(lines))
    return DONE


commands.add_command(study)
commands.add_command(sweep)


@commands.command()
@scene_arguments
def check(name: str, changes: tuple[str, ...]) -> int:
    """Say what a run would use, leave out and cost; run nothing."""
    analysis, plan = _planned(name, changes)
    click.echo("\n".join(analysis.check_lines(plan)))
    return DONE


@commands.command()
@scene_arguments
@click.option("--count", default=10, show_default=True, help="Elastic modes, the lowest.")
@click.option("--out", type=click.Path(path_type=Path), help="Result folder  [default: results/NAME-modes]")
def modes(name: str, changes: tuple[str, ...], count: int, out: Path | None) -> int:
    """Natural frequencies of the plate, with pictures."""
    from tailslap.planning.fe_plan import make_fe_plan, needed_plate
    from tailslap.report.deliver import deliver

    def report(folder: Path) -> Report:
        from tailslap.modes.plate_modes import find_modes
        from tailslap.modes.report import modes_report

        return modes_report(find_modes(make_fe_plan(plan), count))

    plan = _plan(name, changes)
    needed_plate(plan.scene)
    return deliver(out or Path("results") / f"{plan.scene.name}-modes", report)


@commands.command()
@scene_arguments
@click.option("--modes", default=4, show_default=True, help="Elastic modes to keep, the lowest.")
@click.option(
    "--steps", type=click.IntRange(10, 1_000_000), default=100, show_default=True, help="Time steps."
)
@click.option(
    "--tolerance",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=1e-5,
    show_default=True,
    help="Relative error allowed.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON, in SI.")
def modal(
    name: str, changes: tuple[str, ...], modes: int, steps: int, tolerance: float, as_json: bool
) -> int:
    """Run a scene with a few modes of the plate."""
    from tailslap.modal import modal_run
    from tailslap.planning.fe_plan import make_fe_plan
    from tailslap.report.modal_text import modal_numbers, modal_text

    fe_plan = make_fe_plan(_plan(name, changes))
    found = modal_run(fe_plan, modes, tolerance, steps)
    click.echo((modal_numbers if as_json else modal_text)(fe_plan, found))
    return DONE if found.passed else CHECK_FAILED


@commands.command()
def scenes() -> int:
    """List the scenes that come with the program."""
    from tailslap.scene.files import shipped_scenes, title

    shipped = shipped_scenes()
    width = max(map(len, shipped))
    for name, text in shipped.items():
        click.echo(f"{name:<{width}}  {title(text)}")
    return DONE


@commands.command()
@click.option("--out", type=click.Path(path_type=Path), help="Result folder  [default: results/paper]")
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON, in SI, instead of tables.")
def paper(out: Path | None, as_json: bool) -> int:
    """Write the paper's tables and figures, computed beside printed."""
    from tailslap.report.deliver import deliver

    def report(folder: Path) -> Report:
        from tailslap.paper.report.report import paper_report
        from tailslap.paper.review import review_paper

        return paper_report(review_paper())

    return deliver(out or Path("results") / "paper", report, "paper.html", as_json)


def _planned(name: str, changes: tuple[str, ...]) -> tuple[Any, Any]:
    """The calculation that the scene asks for, and its plan."""
    from tailslap.analyses import analysis_of
    from tailslap.scene.files import read_scene

    scene, source = read_scene(name, changes)
    analysis = analysis_of(scene)
    return analysis, analysis.make_plan(scene, source)


def _plan(name: str, changes: tuple[str, ...]) -> Any:
    from tailslap.planning.plan import make_plan
    from tailslap.scene.files import read_scene

    return make_plan(*read_scene(name, changes))


def main(arguments: list[str] | None = None) -> None:
    """Entry point: run a command and leave with its exit status."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters shows question marks
    sys.exit(_status(arguments))


def _status(arguments: list[str] | None) -> int:
    try:
        status = commands.main(arguments, prog_name="tailslap", standalone_mode=False)
        sys.stdout.flush()
        return status if isinstance(status, int) else DONE
    except InputError as error:
        return _complain(str(error), WRONG_INPUT)
    except click.ClickException as error:
        error.show()
        return WRONG_INPUT
    except (KeyboardInterrupt, click.Abort) as error:
        kept = error.__cause__ if isinstance(error.__cause__, Interrupted) else error
        return _complain(str(kept) or "interrupted; nothing was written", INTERRUPTED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except MemoryError:
        return _complain("the memory of this machine does not hold this mesh: see plate.elements", CANNOT_RUN)
    except (ImportError, OSError) as error:
        return _complain(f"{error}\n`python3 bootstrap.py` in the checkout says what is missing", CANNOT_RUN)


def _complain(message: str, status: int) -> int:
    click.echo(f"tailslap: {message}", err=True)
    return status


if __name__ == "__main__":
    main()
