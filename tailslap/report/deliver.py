"""A report into its result folder and onto the terminal: the same for all commands that make one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from postprocess.report.report import Report


def deliver(
    place: Path, make: Callable[[Path], Report], page: str = "report.html", as_json: bool = False
) -> int:
    """Fill the folder `place` with the report that `make` makes, and say what was found; 1 if something failed.

    make: takes the folder, and may draw into it. page: name of the page; as_json: say the summary instead.
    """
    report = leave(place, make, page)
    from postprocess.files.summary import summary_text
    from postprocess.report.report import report_text

    click.echo(summary_text(report.summary) if as_json else report_text(report, place, page))
    return 0 if report.passed else 1


def leave(place: Path, make: Callable[[Path], Report], page: str = "report.html") -> Report:
    """Fill the folder `place` alike, and say nothing. Raises InputError where it cannot be written."""
    from tailslap.results.result_folder import result_folder

    with result_folder(place) as folder:
        report = make(folder)
        from postprocess.report.report import write_report

        write_report(report, folder, page)
    return report
