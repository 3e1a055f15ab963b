"""Hold the result that all functions return."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from html import escape
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.comparison import quantities
from postprocess.report.command_report import PAGE, Report, write_report
from postprocess.report.data_files import plain
from postprocess.report.page import Headline
from postprocess.report.tables import Table
from postprocess.report.terminal import concluded
from postprocess.units import SI, SYSTEMS
from tailslap.arguments import checked_arguments
from tailslap.errors import InputError, Missing, Verbatim, one_of
from tailslap.result.columns import Columns, html_cells
from tailslap.storage.folder import result_folder
from tailslap.storage.manifest import Origin

if TYPE_CHECKING:
    import pandas
    import PIL.Image
    import pyvista

    from postprocess.fields.series import FieldSeries
    from postprocess.figures.histories import HistoryPlot
    from postprocess.svg.chart import Chart

Fill = Callable[[Path, bool, str], "Report | None"]
"""Writes the files of a result to an empty folder, with or without pictures, in units "si" or "us"."""

RIGID: str = "rigid"
SPACE: str = "space"
FE: str = "FE"

MOST = 4
"""Largest number of columns drawn by default."""

FIELDS_NEEDED = (
    "the result has no fields; run the scene with --set output.fields=20 (Python: {'output.fields': 20})"
)

FIRST = (
    "force_normal",
    "v_gx",
    "v_gy",
    "omega",
    "reaction_normal",
    "fe.peak_force",
    "fe.v_gy",
    "rigid.peak_force",
)
"""Columns drawn by default, if they exist."""


def filled_by(make: Callable[[Path, bool, str], Report], page: str = PAGE) -> Fill:
    """Return a function that writes a report's files.

    page: file name of the page.
    """

    def fill(place: Path, pictures: bool, units: str) -> Report:
        report = make(place, pictures, units)
        if units != "si":
            report = report.in_units(SYSTEMS[units])
        write_report(report, place, page)
        return report

    return fill


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """Numbers, tables, histories, fields and files of a command.

    `history` and `rigid` are pandas data frames where pandas is installed, and `Columns` otherwise.

    Attributes
    ----------
    command : str
        Command with the same result: "run", "rigid", "study cost" etc.
    scene : str
        Name of the scene.
    summary : dict
        Contents of `summary.json`, in SI; None in place of numbers that are not finite.
    passed : bool or None
        True if every check passed; None for results without checks.
    tables : mapping of Table
        Tables of the terminal output, by title.
    histories : mapping of Columns
        Histories "FE" and "rigid", if any, or the table of a sweep.
    fill : callable or None
        Writes the files of the command: takes the folder, a flag for pictures, and units.
    make_fields : callable or None
        Computes the fields at the stored instants.
    make_ends : callable or None
        Computes the fields at the start and at the tail-slap of a run without stored fields.
    text : str
        Text of the terminal output, if it is not a table.
    make_charts : callable or None
        Draws the charts.
    inputs : tuple of Path
        Files and folders from which it was read; they are never overwritten.
    changes : sequence of str
        Changes of the scene, as texts KEY=VALUE.
    """

    command: str
    scene: str
    summary: dict[str, Any]
    passed: bool | None = None
    tables: Mapping[str, Table] = field(default_factory=dict)
    histories: Mapping[str, Columns] = field(default_factory=dict)
    fill: Fill | None = None
    make_fields: Callable[[], FieldSeries | None] | None = None
    make_ends: Callable[[], FieldSeries] | None = None
    text: str = ""
    make_charts: Callable[[], Iterable[Chart]] | None = None
    inputs: tuple[Path, ...] = ()
    changes: Sequence[str] = ()

    @property
    def headline(self) -> Headline:
        """Headline of the result in SI.

        It has title, answer, set-up, certainty and band.
        """
        return Headline(*(str(self.summary.get(part.name) or "") for part in fields(Headline)))

    @cached_property
    def history(self) -> pandas.DataFrame:
        """History of the FE run, or the only one.

        It is a data frame if pandas is installed, else `Columns`. Both take `history["v_gy"]` and have `columns` and
        `attrs["units"]`.
        """
        return self._history(FE, *self.histories)

    @cached_property
    def rigid(self) -> pandas.DataFrame:
        """History of the rigid vehicle at the same instants.

        It is a data frame if pandas is installed, else `Columns`.
        """
        return self._history(RIGID)

    @cached_property
    def charts(self) -> dict[str, Chart]:
        """Charts by name, which notebooks show.

        They are those of the page of a study or sweep, or force and set-up of `rigid`.
        """
        return {chart.name: chart for chart in (self.make_charts() if self.make_charts else ())}

    @property
    def fields(self) -> FieldSeries:
        """Fields of the plate at the instants of `[output] fields = N`.

        Raises InputError for a result without fields.
        """
        series = self.make_fields() if self.make_fields else None
        if series is None:
            raise InputError("output.fields", Missing, FIELDS_NEEDED)
        return series

    @checked_arguments
    def mesh(self, t: float | None = None) -> pyvista.UnstructuredGrid:
        """Return the mesh of the plate with its fields, for PyVista.

        Parameters
        ----------
        t : float, optional
            Time [s]; the nearest instant of `[output] fields = N` is used. Default: the last instant, the tail-slap.

        Returns
        -------
        pyvista.UnstructuredGrid
            Undeformed plate in its initial position, in SI; `mesh.warp_by_vector("displacement")` deforms it. Point
            data: vectors (`velocity`) and components (`velocity_x`); cell data: stresses and energy density;
            `field_data["t"]`: time.

        Raises
        ------
        InputError
            For a result without fields.

        Examples
        --------
        >>> import tailslap
        >>> mesh = tailslap.run("mash-tl4-sut").mesh()
        >>> mesh.n_cells, round(float(mesh["velocity_y"].min()), 2)
        (120, -6.55)
        """
        series, k = self._instant(t)
        return series.grid(k)

    @checked_arguments
    def plot_field(self, name: str, t: float | None = None, magnify: float = 1.0) -> PIL.Image.Image:
        """Draw a field of the plate as a contour picture.

        Parameters
        ----------
        name : str
            Field: "v_gx" or "v_gy" (velocity along or normal to the wall), "stress_von_mises", "displacement_y" etc.
        t : float, optional
            Time [s]; the nearest instant of `[output] fields = N` is used. Default: the last instant, the tail-slap.
        magnify : float
            Magnification of the elastic deformation [-].

        Returns
        -------
        PIL.Image.Image
            Picture, displayed in notebooks; `save` writes PNG, JPEG or PDF.

        Raises
        ------
        InputError
            For an unknown field, or a result without fields.

        Examples
        --------
        >>> import tailslap
        >>> tailslap.run("mash-tl4-sut").plot_field("v_gy").save("v_gy.png")
        """
        from postprocess.fields import contours, series

        scalars = {"v_gx": "velocity_x", "v_gy": "velocity_y"} | {scalar: scalar for scalar in series.SCALARS}
        if name not in scalars:
            raise InputError("plot_field", Verbatim(name), one_of(name, scalars))
        fields, k = self._instant(t)
        (picture,) = contours.frames(fields.at(k), scalars[name], magnify, [0], SI)
        return picture

    def _instant(self, t: float | None) -> tuple[FieldSeries, int]:
        """Return the fields, and the number of an instant among them.

        It is the nearest to t [s], for None the last.
        """
        if t is None and self.make_fields is None and self.make_ends is not None:
            return self.make_ends(), -1
        fields = self.fields
        return fields, -1 if t is None else int(abs(fields.t - t).argmin())

    @checked_arguments
    def plot(self, *names: str) -> HistoryPlot:
        """Plot columns over time, of a sweep over the first varied key.

        Parameters
        ----------
        *names : str
            Columns of the history. Default: the main columns.

        Returns
        -------
        HistoryPlot
            Plot, displayed in notebooks; `save` writes PNG, SVG or PDF.

        Raises
        ------
        InputError
            For an unknown column, or a result without histories.
        """
        from postprocess.figures.histories import Curve, plot_overlays

        over = self.summary.get("definition", {}).get("vary", ["t"])[0].partition("=")[0].strip()
        drawn = {label: columns for label, columns in self.histories.items() if over in columns}
        if not drawn:
            raise InputError("plot", Missing, "this result has no history over time")
        allowed = list(dict.fromkeys(name for columns in drawn.values() for name in columns))
        panels = {}
        for name in names or [name for name in FIRST if name in allowed][:MOST] or allowed[1 : MOST + 1]:
            if name not in allowed:
                raise InputError("plot", Verbatim(name), one_of(name, allowed, "allowed are"))
            tables = {label: columns for label, columns in drawn.items() if name in columns}
            heading = next(iter(tables.values())).heading(name)
            panels[heading] = [Curve(label, table[over], table[name]) for label, table in tables.items()]
        return plot_overlays(panels, drawn[next(iter(drawn))].heading(over))

    @checked_arguments
    def save(self, folder: str | os.PathLike[str], pictures: bool = True, *, force: bool = False) -> Path:
        """Write the files of the command.

        Parameters
        ----------
        folder : path
            New or empty folder, or an unmodified earlier result, which is replaced.
        pictures : bool
            Write contour pictures or the animation.
        force : bool
            Replace the result of another command or scene.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            For a folder that cannot be written, is in use, is an input or contains other files, or a result without
            files.
        """
        if self.fill is None:
            raise InputError("folder", str(folder), f"`tailslap {self.command}` writes no files")
        place, scene = Path(folder), str(self.summary.get("scene", ""))
        origin = Origin(self.command, scene, tuple(self.changes))
        with result_folder(place, self.inputs, force, origin) as unfinished:
            self.fill(unfinished, pictures, "si")
        return place

    def __repr__(self) -> str:
        outcome = {None: "", True: " passed", False: " FAILED"}[self.passed]
        answer = f": {self.headline.answer}" if self.headline.answer else ""
        return f"<{self.command} {self.scene}".rstrip() + f"{outcome}{answer}>"

    def __str__(self) -> str:
        return self.text or concluded(self.headline, *self.tables.values()) or repr(self)

    def _repr_html_(self) -> str:
        lines = "".join(f"<p>{escape(line)}</p>" for line in self.headline.lines)
        tables = "".join(_table_html(title, table) for title, table in self.tables.items())
        return f"<div>{lines}{tables}{'' if lines or tables else f'<pre>{escape(str(self))}</pre>'}</div>"

    def _history(self, *names: str) -> pandas.DataFrame:
        """Return the first of these histories, by preference as a data frame.

        Raises InputError where the result has none.
        """
        for name in names:
            if name in self.histories:
                with suppress(ImportError):
                    return self.histories[name].to_pandas()
                return self.histories[name]
        why = f"the result of `tailslap {self.command}` has no history; its numbers are in `summary`"
        raise InputError(".rigid" if names == (RIGID,) else ".history", Missing, why)


def _table_html(title: str, table: Table) -> str:
    """Return a table as HTML without style."""
    heads = html_cells((column.heading for column in table.columns), "th")
    head = f"<thead><tr>{heads}</tr></thead>" if any(column.label for column in table.columns) else ""
    rows = (html_cells(column.text(row) for column in table.columns) for row in table.rows)
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    caption = html_cells([title], "caption") if title else ""
    return f"<table>{caption}{head}<tbody>{body}</tbody></table>"


def of_report(command: str, report: Report, page_name: str = PAGE, **more: Any) -> Result:
    """Return the result of a report.

    page_name: file name of the page; more: other fields of the result.
    """
    parts = chain.from_iterable(getattr(part, "tables", (part,)) for part in report.terminal)
    printed = [part for part in parts if isinstance(part, Table)]
    tables = {table.title or f"Table {n}": table for n, table in enumerate(printed, 1)} | dict(report.tables)
    summary = plain(report.numbers)
    values = {
        "scene": summary.get("scene", ""),
        "passed": report.page.passed,
        "tables": tables,
        "make_charts": lambda: report.page.charts,
        "fill": filled_by(lambda place, pictures, units: report, page_name),
    }
    return Result(command, summary=summary, **(values | more))


def of_run(summary: dict[str, Any], partial: Result) -> Result:
    """Return the result of a run.

    Other fields follow from its summary.
    """
    values = {"scene": summary["scene"], "summary": summary, "passed": summary["passed"]}
    return replace(partial, command="run", tables=_run_tables(summary), **values)


def _run_tables(summary: Mapping[str, Any]) -> dict[str, Table]:
    """Return tables of the results and of failed checks of a run."""
    from tailslap.case.check import printed_check
    from tailslap.case.report_parts import CHECKS, TAIL_SLAP, strikes_table

    fe, rigid = summary["fe"], summary["rigid"]
    tables = {}
    if fe.get("strikes") is not None:
        planar = {"FE": fe["strikes"], "rigid": rigid["strikes"]}
        in_space = {"in space": summary["space"]["strikes"]} if "space" in summary else {}
        tables["Strikes"] = strikes_table(in_space or planar)
    elif all(fe[key] is not None for key in quantities.KEYS):
        columns = tuple(replace(c, form=".7g") if c.key in ("fe", "rigid") else c for c in TAIL_SLAP)
        tables["At the tail-slap"] = Table(columns, quantities.comparison_rows(fe, rigid))
    failed = [printed_check(check) for check in summary["checks"] if not check["passed"]]
    return tables | ({"Failed checks": Table(CHECKS, failed)} if failed else {})
