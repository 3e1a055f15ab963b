"""Read the scene of a command, and deliver its result."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tailslap import options
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.scene import read
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source
from tailslap.storage.folder import default_place, result_folder
from tailslap.storage.manifest import Origin

if TYPE_CHECKING:
    from postprocess.report.command_report import Report
    from tailslap.result.result import Result

DONE, CHECK_FAILED = 0, 1
"""Exit statuses of a completed command."""


def takes_a_case(function: Callable[..., int]) -> Callable[..., int]:
    """Decorate a command with SCENE and --set, and pass it the case."""

    @functools.wraps(function)
    def command(name: str, changes: tuple[str, ...], **arguments: object) -> int:
        return function(case_of(*scene_with_remarks(name, changes)), **arguments)

    return options.with_options(options.SCENE, options.SET)(command)


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


def deliver_case(function: Callable[..., Result], case: Case, arguments: dict[str, Any]) -> int:
    """Deliver the result of a function of a case, see `deliver`.

    arguments: of the command of its name. The result folder is by default that of the scene and the command.
    """
    out, force, units, as_json = (arguments.pop(key) for key in ("out", "force", "units", "as_json"))
    command, scene, changes = function.__name__, case.scene.name, case.changes
    place = out or default_place(scene, changes, f"-{command}")
    compute = functools.partial(function, case, **arguments)
    return deliver(compute, place, Origin(command, scene, changes), as_json, units, force=force)


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
