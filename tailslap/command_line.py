"""The command `tailslap`. Messages go to standard error, results to standard output."""

from __future__ import annotations

import io
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

import tailslap
from tailslap.errors import InputError
from tailslap.studies import study
from tailslap.sweep import sweep

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
        help="Change a key, like plate.thickness=20mm.",
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
def run(name: str, changes: tuple[str, ...], out: Path | None, no_pictures: bool) -> int:
    """Run a scene: rigid solution, mesh, FE run, comparison, pictures, report."""
    from tailslap.fe_plan import needed_plate
    from tailslap.result_folder import result_folder

    plan = _plan(name, changes)
    needed_plate(plan.scene)
    place = out or Path("results") / plan.scene.name
    with result_folder(place) as folder:
        from tailslap.run import run_scene
        from tailslap.write import write_results

        outcome = write_results(run_scene(plan), folder, not no_pictures)
    from tailslap.tables import print_outcome

    print_outcome(outcome, place)
    return DONE if outcome.passed else CHECK_FAILED


@commands.command()
@scene_arguments
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON, in SI.")
@click.option("--units", type=click.Choice(["si", "us"]), default="si", help="Units of the printed numbers.")
def rigid(name: str, changes: tuple[str, ...], as_json: bool, units: str) -> int:
    """The rigid-body method alone."""
    from tailslap.rigid import rigid_answer, rigid_lines

    if as_json and units == "us":
        raise InputError("--units", units, "--json is in SI always; leave out one of the two")
    plan = _plan(name, changes)
    click.echo(json.dumps(rigid_answer(plan), indent=2) if as_json else "\n".join(rigid_lines(plan, units)))
    return DONE


commands.add_command(study)
commands.add_command(sweep)


@commands.command()
@scene_arguments
def check(name: str, changes: tuple[str, ...]) -> int:
    """Say what a run would use, leave out and cost; run nothing."""
    from tailslap.tables import fe_part, flutter_lines, rigid_part

    plan = _plan(name, changes)
    lines = rigid_part(plan)
    if plan.scene.plate:
        from tailslap.fe_plan import make_fe_plan

        fe_plan = make_fe_plan(plan)
        lines += fe_part(fe_plan) + flutter_lines(fe_plan)
    click.echo("\n".join(lines))
    return DONE


@commands.command()
def scenes() -> int:
    """List the scenes that come with the program."""
    from tailslap.scene_files import shipped_scenes, title

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
    from tailslap.paper.answer import answer
    from tailslap.paper.terminal import print_paper
    from tailslap.paper.write import write_paper
    from tailslap.result_folder import result_folder

    result, place = answer(), out or Path("results") / "paper"
    with result_folder(place) as folder:
        write_paper(result, folder)
    print_paper(result, place, as_json)
    return DONE


def _plan(name: str, changes: tuple[str, ...]) -> Any:
    from tailslap.plan import make_plan
    from tailslap.scene_files import read_scene

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
    except (KeyboardInterrupt, click.Abort):
        return _complain("interrupted; nothing was written", INTERRUPTED)
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
