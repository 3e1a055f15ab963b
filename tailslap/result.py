"""Result: the record that all functions return, with its columns, in a notebook, as plots, as files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from html import escape
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.comparison import quantities
from postprocess.figures.histories import Curve, HistoryPlot, plot_overlays
from postprocess.report.command_report import PAGE, Report, write_report
from postprocess.report.data_files import plain
from postprocess.report.page import Headline
from postprocess.report.tables import Table
from postprocess.report.terminal import opened
from postprocess.units import SI, SYSTEMS
from tailslap.arguments import checked_arguments
from tailslap.errors import InputError, Missing, Verbatim, one_of
from tailslap.files.folder import result_folder
from tailslap.files.manifest import Origin

if TYPE_CHECKING:
    import pandas
    import PIL.Image
    import pyvista

    from postprocess.fields.series import FieldSeries
    from postprocess.svg.chart import Chart

Fill = Callable[[Path, bool, str], "Report | None"]
"""Writes the files of a result to an empty folder, with or without pictures, in units "si" or "us"."""

RIGID: str = "rigid"
FE: str = "FE"

SHOWN, MOST = 5, 4
"""Rows shown at each end of a table in a notebook; largest number of columns drawn by default."""

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
    """Function that writes the files of a report to a folder; page: file name of the page."""

    def fill(place: Path, pictures: bool, units: str) -> Report:
        report = make(place, pictures, units)

        if units != "si":
            report = report.in_units(SYSTEMS[units])
        write_report(report, place, page)
        return report

    return fill


class Columns(dict[str, np.ndarray]):
    """History or another table: arrays by column name; `pandas.DataFrame` accepts it.

    Parameters
    ----------
    arrays : mapping of ndarray, shape (rows,)
        Columns by name, in SI [-].
    units : mapping of str
        SI units by name; missing for columns without a known unit.

    Examples
    --------
    >>> history = Columns({"t": np.array([0.0, 0.1])}, {"t": "s"})
    >>> history["t"].max(), history.attrs["units"]["t"]
    (np.float64(0.1), 's')
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], units: Mapping[str, str] | None = None) -> None:
        super().__init__(arrays)
        self.attrs = {"units": dict(units or {})}

    def __missing__(self, name: str) -> np.ndarray:
        raise KeyError(f"{name}: {one_of(name, self, 'columns are')}")

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self)

    @property
    def units(self) -> dict[str, str]:
        """SI units by name."""
        return self.attrs["units"]

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.values()), ()))

    def __repr__(self) -> str:
        return f"<Columns: {self.rows} rows of {', '.join(self)}>"

    def heading(self, name: str) -> str:
        """Name of a column with its unit.

        Parameters
        ----------
        name : str
            Name of a column.

        Returns
        -------
        str
            Heading, e.g. "v_gx [m/s]".
        """
        unit = self.units.get(name, "")
        return f"{name} [{unit}]" if unit else name

    def to_pandas(self) -> Any:
        """The columns as a pandas DataFrame.

        Returns
        -------
        pandas.DataFrame
            Data frame with the units in `attrs["units"]`.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        frame = _library("pandas").DataFrame(dict(self))
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_polars(self) -> Any:
        """The columns as a polars DataFrame, without units.

        Returns
        -------
        polars.DataFrame
            Data frame with the same column names.

        Raises
        ------
        ImportError
            If polars is not installed.
        """
        return _library("polars").DataFrame(dict(self))

    def _repr_html_(self) -> str:
        """First and last rows, for notebooks."""
        numbers = [*range(self.rows)]
        if self.rows > 2 * SHOWN:
            numbers = [*numbers[:SHOWN], -1, *numbers[-SHOWN:]]
        head = _cells(map(self.heading, self), "th")
        rows = (["…"] * len(self) if n < 0 else [_text(v[n]) for v in self.values()] for n in numbers)
        body = "".join(f"<tr>{_cells(row)}</tr>" for row in rows)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table><p>{self.rows} rows</p>"


def _cells(texts: Iterable[str], tag: str = "td") -> str:
    return "".join(f"<{tag}>{escape(text)}</{tag}>" for text in texts)


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        said = f"{name} is not installed: `pip install {name}`; the columns are NumPy arrays"
        raise ImportError(said) from None


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """Result of a command: numbers, tables, histories, fields and files.

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
        Changes of the scene, as texts KEY=VALUE, for the name of a folder of exports.
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
        """Title, answer, set-up and certainty, as the page and the terminal open."""
        return Headline(*(str(self.summary.get(each.name) or "") for each in fields(Headline)))

    @cached_property
    def history(self) -> pandas.DataFrame | Columns:
        """History of the FE run, or the only one; a data frame if pandas is installed, else `Columns`.

        Both take `history["v_gy"]` and have `columns` and `attrs["units"]`.
        """
        return self._history(FE, *self.histories)

    @cached_property
    def rigid(self) -> pandas.DataFrame | Columns:
        """History of the rigid vehicle at the same instants; a data frame if pandas is installed, else `Columns`."""
        return self._history(RIGID)

    @cached_property
    def charts(self) -> dict[str, Chart]:
        """Charts by name, which notebooks show: those of the page of a study or sweep, force and set-up of `rigid`."""
        return {chart.name: chart for chart in (self.make_charts() if self.make_charts else ())}

    @property
    def fields(self) -> FieldSeries:
        """Fields of the plate at the instants of `[output] fields = N`. Raises InputError without them."""
        found = self.make_fields() if self.make_fields else None
        if found is None:
            raise InputError("output.fields", Missing, FIELDS_NEEDED)
        return found

    @checked_arguments
    def mesh(self, t: float | None = None) -> pyvista.UnstructuredGrid:
        """Mesh of the plate with its fields, for PyVista.

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

        known = {"v_gx": "velocity_x", "v_gy": "velocity_y"} | {each: each for each in series.SCALARS}
        if name not in known:
            raise InputError("plot_field", Verbatim(name), one_of(name, known))
        fields, k = self._instant(t)
        (picture,) = contours.frames(fields.at(k), known[name], magnify, [0], SI)
        return picture

    def _instant(self, t: float | None) -> tuple[FieldSeries, int]:
        """The fields, and the number among them of the instant nearest to t [s], None for the last."""
        if t is None and self.make_fields is None and self.make_ends is not None:
            return self.make_ends(), -1
        fields = self.fields
        return fields, -1 if t is None else int(abs(fields.t - t).argmin())

    @checked_arguments
    def plot(self, *names: str) -> HistoryPlot:
        """Plot columns of the FE run and the rigid vehicle over time, or of a sweep over the first varied key.

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
        over = self.summary.get("definition", {}).get("vary", ["t"])[0].partition("=")[0]
        drawn = {label: columns for label, columns in self.histories.items() if over in columns}
        if not drawn:
            raise InputError("plot", Missing, "this result has no history over time")
        known = list(dict.fromkeys(name for columns in drawn.values() for name in columns))
        panels = {}
        for name in names or [name for name in FIRST if name in known][:MOST] or known[1 : MOST + 1]:
            if name not in known:
                raise InputError("plot", Verbatim(name), one_of(name, known, "allowed are"))
            having = {label: columns for label, columns in drawn.items() if name in columns}
            heading = next(iter(having.values())).heading(name)
            panels[heading] = [Curve(label, its[over], its[name]) for label, its in having.items()]
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
        place, origin = Path(folder), Origin(self.command, str(self.summary.get("scene", "")))
        with result_folder(place, self.inputs, force, origin) as unfinished:
            self.fill(unfinished, pictures, "si")
        return place

    def __repr__(self) -> str:
        judged = {None: "", True: " passed", False: " FAILED"}[self.passed]
        answer = f": {self.headline.answer}" if self.headline.answer else ""
        return f"<{self.command} {self.scene}".rstrip() + f"{judged}{answer}>"

    def __str__(self) -> str:
        return self.text or opened(self.headline, *self.tables.values()) or repr(self)

    def _repr_html_(self) -> str:
        lines = "".join(f"<p>{escape(line)}</p>" for line in self.headline.lines)
        shown = "".join(_table_html(title, table) for title, table in self.tables.items())
        return f"<div>{lines}{shown}{'' if lines or shown else f'<pre>{escape(str(self))}</pre>'}</div>"

    def _history(self, *names: str) -> Any:
        for name in names:
            if name in self.histories:
                with suppress(ImportError):
                    return self.histories[name].to_pandas()
                return self.histories[name]
        raise InputError(
            names[0], Missing, f"the result of `tailslap {self.command}` does not have this history"
        )


def _table_html(title: str, table: Table) -> str:
    """A table without style of its own."""
    heads = _cells((column.heading for column in table.columns), "th")
    head = f"<thead><tr>{heads}</tr></thead>" if any(column.label for column in table.columns) else ""
    rows = (_cells(column.text(row) for column in table.columns) for row in table.rows)
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    caption = _cells([title], "caption") if title else ""
    return f"<table>{caption}{head}<tbody>{body}</tbody></table>"


def of_report(command: str, report: Report, page_name: str = PAGE, **more: Any) -> Result:
    """The result of a command that makes a report; page_name: of its file; more: what else the result has."""
    parts = chain.from_iterable(getattr(part, "tables", (part,)) for part in report.terminal)
    shown = [part for part in parts if isinstance(part, Table)]
    tables = {table.title or f"Table {n}": table for n, table in enumerate(shown, 1)} | dict(report.tables)
    summary = plain(report.numbers)
    found = {
        "scene": summary.get("scene", ""),
        "passed": report.page.passed,
        "tables": tables,
        "make_charts": lambda: report.page.charts,
        "fill": filled_by(lambda place, pictures, units: report, page_name),
    }
    return Result(command, summary=summary, **(found | more))


def of_run(summary: dict[str, Any], *rest: Any, **more: Any) -> Result:
    """The result of a run, just made or read again; rest: of the result, from its histories on; more: by name."""
    return Result("run", summary["scene"], summary, summary["passed"], _run_tables(summary), *rest, **more)


def _run_tables(summary: Mapping[str, Any]) -> dict[str, Table]:
    """Tables of a run from its summary: what was found, and the checks that failed."""
    from tailslap.case.case import as_read
    from tailslap.case.report import CHECKS, TAIL_SLAP, strikes_table

    fe, rigid = summary["fe"], summary["rigid"]
    found = {}
    if fe.get("strikes") is not None:
        found["Strikes"] = strikes_table({"FE": fe["strikes"], "rigid": rigid["strikes"]})
    elif all(fe[key] is not None for key in quantities.KEYS):
        columns = tuple(replace(c, form=".7g") if c.key in ("fe", "rigid") else c for c in TAIL_SLAP)
        found["At the tail-slap"] = Table(columns, quantities.comparison_rows(fe, rigid, None))
    failed = [as_read(check) for check in summary["checks"] if not check["passed"]]
    return found | ({"Failed checks": Table(CHECKS, failed)} if failed else {})
