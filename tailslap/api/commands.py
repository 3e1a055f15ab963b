"""The commands that take results: `tailslap export` and `tailslap compare`."""

from __future__ import annotations

from pathlib import Path

import click

from postprocess.fields import FORMATS
from tailslap.options import JSON, QUIET, UNITS, Folder, Real, Text, tell, with_options


@click.command("export")
@click.argument("folder", metavar="RESULT", type=Folder())
@click.option("--to", type=click.Choice(FORMATS), required=True, help="Format of the files.")
@click.option("--out", type=Folder(), help="Folder for them  [default: RESULT-FORMAT]")
@click.option(
    "--field", type=Text(), help="What png and gif show, like stress_von_mises  [default: all fields]"
)
@click.option(
    "--magnify", type=Real(0.0, 1e9), default=1.0, show_default=True, help="The elastic deformation in them."
)
@with_options(UNITS, JSON, QUIET)
def export(
    folder: Path, to: str, out: Path | None, field: str | None, magnify: float, units: str, as_json: bool
) -> int:
    """Write a result's fields and histories for ParaView, Gmsh or a data frame, or draw them.

    RESULT is a result folder. Mesh and fields are there for runs with --set output.fields=N; csv and parquet hold the
    histories of any run.
    """
    from tailslap.files.export import export as write

    written = write(folder, to, out, field=field, magnify=magnify, units=units)
    return tell({"written": written}, f"Written: {written}", as_json)


@click.command("compare")
@click.argument("given", metavar="RESULT RESULT...", nargs=-1, required=True, type=Folder())
@click.option(
    "--columns",
    type=Text(),
    metavar="NAME=THEIRS,...",
    help="What columns of files are called, like 'time=t,v_gy=-VY [mph]': a minus turns the sign.",
)
@click.option("--only", type=Text(), metavar="NAME,...", help="Columns to compare.")
@click.option("--out", type=Folder(), help="Folder of the page  [default: results/compare]")
@with_options(UNITS, JSON, QUIET)
def compare(
    given: tuple[Path, ...],
    columns: str | None,
    only: str | None,
    out: Path | None,
    units: str,
    as_json: bool,
) -> int:
    """Set results beside the first: curves, differences, metrics of validation.

    A RESULT is a result folder, or a file with named columns: a history of ABAQUS, LS-DYNA or a test. Exit status 1 if
    a metric is beyond the limits of NCHRP W179.
    """
    from tailslap.comparing.report import compare_items, compare_report
    from tailslap.report.deliver import deliver

    names = tuple(name.strip() for name in (only or "").split(",") if name.strip())
    found = compare_items(given, columns, names)
    place = out or Path("results") / "compare"
    return deliver(place, lambda folder: compare_report(found), as_json=as_json, units=units)
