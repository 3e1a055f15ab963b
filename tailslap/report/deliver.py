"""A report into its result folder and onto the terminal: the same for all commands that make one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from postprocess.report.report import Report


def deliver(
    place: Path,
    make: Callable[[Path], Report],
    page: str = "report.html",
    as_json: bool = False,
    units: str = "si",
) -> int:
    """Fill the folder `place` with the report that `make` makes, and say what was found; 1 if something failed.

    make: takes the folder, and may draw into it. page: name of the page; as_json: say the summary instead; units: of
    page and terminal, "si" or "us".
    """
    report = leave(place, make, page, units)
    from postprocess.files.summary import summary_text
    from postprocess.report.report import report_text

    click.echo(summary_text(report.summary) if as_json else report_text(report, place, page))
    return 0 if report.passed else 1


def leave(
    place: Path, make: Callable[[Path], Report], page: str = "report.html", units: str = "si"
) -> Report:
    """Fill the folder `place` alike, and say nothing. Raises InputError where it cannot be written."""
    from tailslap.files.folder import result_folder

    with result_folder(place) as folder:
        report = make(folder)
        from postprocess.report.report import in_units, write_report
        from postprocess.report.units import SYSTEMS

        if units != "si":
            report = in_units(report, SYSTEMS[units])
        write_report(report, folder, page)
    return report
