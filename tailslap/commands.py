"""Define the commands of `tailslap`, which call functions of their names."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import tailslap
from postprocess.fields import FORMATS
from tailslap import options, scene_commands
from tailslap.delivery import deliver
from tailslap.exports import PROGRAMS
from tailslap.storage.folder import default_place
from tailslap.storage.manifest import Origin

if TYPE_CHECKING:
    from typing import Literal


COMPLETE = "_TAILSLAP_COMPLETE"
"""Environment variable that a shell sets to request completions."""

HELP = {"help_option_names": ["-h", "--help"]}


@click.group(context_settings=HELP)
@click.version_option(tailslap.__version__, prog_name="tailslap")
def commands() -> None:
    """Verify rigid-body impacts on bridge parapets by finite elements.

    SCENE is a TOML file or the name of a scene of the program, listed by `tailslap scenes`.
    """


for command in (
    scene_commands.run, scene_commands.rigid, scene_commands.check, scene_commands.study, scene_commands.sweep,
    scene_commands.confirm, scene_commands.modes, scene_commands.modal, scene_commands.parapet,
):  # fmt: skip
    commands.add_command(command)


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
@options.option(
    "--magnify",
    type=options.Real(0.0, 1e9),
    default=1.0,
    help="Magnification of the elastic deformation in png and gif.",
)
@options.with_options(options.PICTURE_SIZE, options.FORCE_READ, *options.PRINTED)
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
    compute = functools.partial(tailslap.compare, *results, **arguments)
    place = out or default_place("compare", ())
    return deliver(compute, place, Origin("compare", ""), as_json, units, inputs=results, force=force)


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
    """Write NAME.toml, a scene with every key and its meaning."""
    path = tailslap.new(name)
    return options.report({"scene": name, "file": str(path)}, f"{path}: see `tailslap check {path}`", as_json)


@commands.command()
@click.argument(
    "name", metavar="[SCENE]", default="impact-mash-tl4-sut", shell_complete=options.complete_scene
)
@options.option("--out", type=options.File(), default="explore.html", help="File of the page.")
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
    """Print the script by which a shell completes commands.

    For bash, in ~/.bashrc: eval "$(tailslap completion bash)"
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    script = kind(commands, {}, "tailslap", COMPLETE).source() if kind else ""
    return options.report({"shell": shell, "script": script}, script, as_json)


@commands.command()
@click.option("--out", type=options.Folder(), help="Result folder  [default: results/paper]")
@options.with_options(options.FORCE, options.JSON, options.QUIET)
def paper(out: Path | None, force: bool, as_json: bool) -> int:
    """Compare tables and figures of the paper with own values."""
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
    """Compare published forces and speeds with predictions."""
    from tailslap.validation.validation_report import PAGE

    place = out or default_place("validation", ())

    compute = functools.partial(tailslap.validate, ranges)
    return deliver(compute, place, Origin("validate", ""), as_json, force=force, page=PAGE)
