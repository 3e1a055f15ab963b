"""What the functions return: one frozen record for all of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.report.table import Table
from tailslap.api.columns import Columns
from tailslap.errors import InputError, Missing

if TYPE_CHECKING:
    import pyvista

    from postprocess.fields.series import FieldSeries
    from postprocess.figures.histories import HistoryPlot
    from postprocess.report.report import Report

Fill = Callable[[Path, bool], None]
"""Fills an empty folder with the result's files; the second argument: whether with pictures."""

RIGID, FE = "rigid", "FE"


def filled_by(make: Callable[[Path, bool], Report]) -> Fill:
    """What fills a folder with the files of a report, which may draw pictures into it."""

    def fill(folder: Path, pictures: bool) -> None:
        from postprocess.report.report import write_report

        write_report(make(folder, pictures), folder)

    return fill


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """What a command has found.

    Attributes
    ----------
    command : str
        The command that finds the same: "run", "rigid", "study cost" and so on.
    scene : str
        Name of the scene.
    summary : dict
        Numbers and words, SI, by the names of `summary.json`; None where there is no finite number.
    headline : str
        What was found, in a sentence.
    passed : bool or None
        Whether every check passed; None where nothing is judged.
    tables : mapping of Table
        What the terminal shows, by title.
    histories : mapping of Columns
        "FE" and "rigid", where there are any; of a sweep its table.
    fill : callable or None
        Fills a folder with the files that the command leaves.
    make_fields : callable or None
        Makes the fields that were kept.
    make_ends : callable or None
        Makes the fields at the start and at the tail-slap, of a run that has kept none.
    text : str
        What the terminal says, where it is no table.
    """

    command: str
    scene: str
    summary: dict[str, Any]
    headline: str = ""
    passed: bool | None = None
    tables: Mapping[str, Table] = field(default_factory=dict)
    histories: Mapping[str, Columns] = field(default_factory=dict)
    fill: Fill | None = None
    make_fields: Callable[[], FieldSeries] | None = None
    make_ends: Callable[[], FieldSeries] | None = None
    text: str = ""

    @property
    def history(self) -> Columns:
        """The FE run's history, or the only one that there is."""
        return self._history(FE, *self.histories)

    @property
    def rigid(self) -> Columns:
        """The rigid vehicle's history, at the same instants."""
        return self._history(RIGID)

    @property
    def fields(self) -> FieldSeries:
        """Fields of the plate at the instants of `[output] fields = N`, shape as `FieldSeries` says."""
        if self.make_fields is None:
            raise InputError("output.fields", Missing, "no fields were kept; run with {'output.fields': 20}")
        return self.make_fields()

    def mesh(self, t: float | None = None) -> pyvista.UnstructuredGrid:
        """Mesh of the plate with its fields, for PyVista.

        Parameters
        ----------
        t : float, optional
            Of the instants of `[output] fields = N` the nearest to this one [s]; without it the last, the tail-slap.

        Returns
        -------
        pyvista.UnstructuredGrid
            The unstrained plate where the run starts, SI; `mesh.warp_by_vector("displacement")` is where it is. At the
            points vectors (`velocity`) and their components (`velocity_x`), at the cells stresses and energy density,
            the instant in `field_data["t"]`.

        Raises
        ------
        InputError
            Where no fields were kept: for an instant, and for a result without a tail-slap of its own.

        Examples
        --------
        >>> import tailslap
        >>> mesh = tailslap.run("mash-tl4-sut").mesh()
        >>> mesh.n_cells, round(float(mesh["velocity_y"].min()), 2)
        (120, -6.55)
        """
        if t is None and self.make_fields is None and self.make_ends is not None:
            return self.make_ends().grid()
        series = self.fields
        return series.grid(-1 if t is None else int(abs(series.t - t).argmin()))

    def plot(self, *names: str) -> HistoryPlot:
        """Draw columns over time, the rigid vehicle's beside the FE run's.

        Parameters
        ----------
        *names : str
            Columns of the history; without any, the first few of the result's kind.

        Returns
        -------
        HistoryPlot
            Shown by a notebook as it is; `save` writes it as PNG, SVG or PDF.

        Raises
        ------
        InputError
            For a column that is not there, or a result without histories.
        """
        from tailslap.api.plots import plot_histories

        return plot_histories(self.histories, names)

    def save(self, folder: str | os.PathLike[str], pictures: bool = True, *, force: bool = False) -> Path:
        """Write the files that the command leaves.

        Parameters
        ----------
        folder : path
            A new or empty folder, or an unchanged earlier result, which is replaced.
        pictures : bool
            Whether with contour pictures or an animation.
        force : bool
            Also where there is the result of another scene.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            Where the folder cannot be written or holds other files, or the result leaves none.
        """
        from tailslap.files.folder import demand_own, result_folder

        if self.fill is None:
            raise InputError("folder", str(folder), f"`tailslap {self.command}` leaves no files")
        place = Path(folder)
        demand_own(place, self.scene, force)
        with result_folder(place) as unfinished:
            self.fill(unfinished, pictures)
        return place

    def __repr__(self) -> str:
        judged = {None: "", True: " passed", False: " FAILED"}[self.passed]
        said = f": {self.headline}" if self.headline else ""
        text = f"<{self.command} {self.scene}{judged}{said}"
        return f"{text if len(text) < 159 else text[:156] + '...'}>".replace("\n", " ")

    def __str__(self) -> str:
        if self.text:
            return self.text
        from postprocess.report.terminal import printed

        return printed((*self.tables.values(), self.headline or repr(self)))

    def _repr_html_(self) -> str:
        from tailslap.api.notebook import result_html

        return result_html(self.headline, self.text or repr(self), self.tables)

    def _history(self, *names: str) -> Columns:
        found: Sequence[str] = [name for name in names if name in self.histories]
        if not found:
            raise InputError(names[0], Missing, f"`tailslap {self.command}` leaves no such history")
        return self.histories[found[0]]
