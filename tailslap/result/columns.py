"""Hold the columns of histories and tables, with names and units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from html import escape
from importlib import import_module
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from fem.explicit.columns import COLUMNS, IMPACT_COLUMNS, HistoryColumn
from postprocess.signals.filters import LABELS
from tailslap.errors import one_of

if TYPE_CHECKING:
    import pandas
    import polars

SHOWN = 5
"""Rows shown at each end of a table in a notebook."""

ENERGY_ERROR = HistoryColumn("energy_error", "J", meaning="energy-balance error")
"""Column that both calculations add to those of the time loop."""


class Columns(dict[str, np.ndarray]):
    """Columns of a history or a table.

    `pandas.DataFrame` accepts it.

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
        """Return a column's name with its unit.

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

    def to_pandas(self) -> pandas.DataFrame:
        """Convert the columns to a pandas DataFrame.

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

    def to_polars(self) -> polars.DataFrame:
        """Convert the columns to a polars DataFrame.

        It has no units.

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
        """Return the first and last rows as HTML."""
        numbers = [*range(self.rows)]
        if self.rows > 2 * SHOWN:
            numbers = [*numbers[:SHOWN], -1, *numbers[-SHOWN:]]
        head = html_cells(map(self.heading, self), "th")
        rows = (["…"] * len(self) if n < 0 else [_text(v[n]) for v in self.values()] for n in numbers)
        body = "".join(f"<tr>{html_cells(row)}</tr>" for row in rows)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table><p>{self.rows} rows</p>"


def html_cells(texts: Iterable[str], tag: str = "td") -> str:
    """Return the cells of an HTML table row."""
    return "".join(f"<{tag}>{escape(text)}</{tag}>" for text in texts)


def _text(value: object) -> str:
    """Return a number with six digits."""
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)


def _library(name: str) -> ModuleType:
    """Import an optional library. Raises ImportError that names it."""
    try:
        return import_module(name)
    except ImportError:
        hint = f"{name} is not installed: `pip install {name}`; the columns are NumPy arrays"
        raise ImportError(hint) from None


def corner_columns() -> dict[str, HistoryColumn]:
    """Return the columns of a run with a constrained corner.

    Columns registered from outside the program are among them.
    """
    t = HistoryColumn("t", "s", meaning="time since the start of Stage 2")
    return {column.name: column for column in (t, *COLUMNS.values(), ENERGY_ERROR)}


def impact_columns() -> dict[str, HistoryColumn]:
    """Return the columns of a whole impact."""
    meaning = "lateral force on the wall, {}, 0 in the first row"
    filtered = (
        HistoryColumn(f"force_normal_{name}", "N", meaning=meaning.format(label))
        for name, label in LABELS.items()
        if name != "raw"
    )
    return IMPACT_COLUMNS | {column.name: column for column in (*filtered, ENERGY_ERROR)}


def train_columns() -> dict[str, HistoryColumn]:
    """Return the additional columns of trains.

    Their names end with the number of a hinge.
    """
    force = "of the unit behind on the one ahead, {} the wall, mean since the row before"
    angle = "angle between the unit behind and the wall less that of the one ahead"
    columns = (
        HistoryColumn("hinge_force_x", "N", meaning=force.format("along")),
        HistoryColumn("hinge_force_y", "N", meaning=force.format("across")),
        HistoryColumn("hinge_force_z", "N", meaning="the same upwards, in space"),
        HistoryColumn("articulation", "rad", meaning=angle),
    )
    return {column.name: column for column in columns}


def sensor_columns() -> dict[str, HistoryColumn]:
    """Return the additional columns with [sensor]."""
    columns = (
        HistoryColumn(
            "sensor_velocity", "m/s", meaning="velocity of the sensor normal to the wall, negative towards it"
        ),
        HistoryColumn(
            "sensor_acceleration",
            "m/s^2",
            meaning="lateral acceleration of the sensor, mean since the previous row, 0 in the first row",
        ),
    )
    return {column.name: column for column in columns}


def column_units(names: Iterable[str]) -> dict[str, str]:
    """Return SI units of columns by name.

    Names may end with the number of a unit of a train. Unknown names are omitted.
    """
    columns = train_columns() | sensor_columns() | impact_columns() | corner_columns()
    described = {name: columns.get(re.sub(r"_[1-8]$", "", name)) for name in names}
    return {name: column.unit for name, column in described.items() if column}


def history(columns: Mapping[str, np.ndarray]) -> Columns:
    """Return a history's columns with their units."""
    return Columns(columns, column_units(columns))


def table(columns: Mapping[str, np.ndarray]) -> Columns:
    """Return a sweep's columns with their units."""
    from postprocess.comparison.quantities import STRIKES, TAIL_SLAP
    from tailslap.scene import schema, write

    compared = {**TAIL_SLAP.quantities, **STRIKES.quantities}
    units = {f"{of}.{key}": quantity.unit for of in ("fe", "rigid") for key, quantity in compared.items()}
    units |= {
        f"{name}.{key}": write.unit_of(field)
        for name, kind in schema.TABLES.items()
        for key, field in schema.values_of(kind).items()
    }
    return Columns(columns, {name: units[name] for name in columns if units.get(name)})


def read_columns(source: Path | BytesIO, names: Iterable[str] | None = None) -> dict[str, np.ndarray]:
    """Read columns of the table of a sweep, by default all.

    Missing numbers are NaN.
    """
    import pyarrow.parquet as pq

    # Without Arrow's threads: one that frees a buffer of Python's while the interpreter ends aborts the process
    # (apache/arrow issue 34314).
    with pq.ParquetFile(source, pre_buffer=False) as file:
        table = file.read(None if names is None else list(names), use_threads=False)
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}
