"""Columns of numbers with their units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np

SHOWN = 5
"""Rows that a notebook shows at each end."""


@dataclass(frozen=True, repr=False, eq=False)
class Columns(Mapping[str, np.ndarray]):
    """A history or another table: arrays by the names of its columns.

    Parameters
    ----------
    arrays : mapping of ndarray, shape (rows,)
        By name, SI.
    units : mapping of str
        SI units by name; a column without one has none, or is not known.

    Examples
    --------
    >>> history = Columns({"t": np.array([0.0, 0.1])}, {"t": "s"})
    >>> history["t"].max(), history.units["t"]
    (np.float64(0.1), 's')
    """

    arrays: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.arrays.values()), ()))

    def __repr__(self) -> str:
        return f"<Columns: {self.rows} rows of {', '.join(self.arrays)}>"

    def heading(self, name: str) -> str:
        """Name of a column with its unit.

        Parameters
        ----------
        name : str
            Of a column.

        Returns
        -------
        str
            Like "v_gx [m/s]".
        """
        unit = self.units.get(name, "")
        return f"{name} [{unit}]" if unit else name

    def to_pandas(self) -> Any:
        """The columns as a pandas DataFrame.

        Returns
        -------
        pandas.DataFrame
            Its `attrs["units"]` are the units.

        Raises
        ------
        ImportError
            Where pandas is not installed.
        """
        frame = _library("pandas").DataFrame(dict(self.arrays))
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_polars(self) -> Any:
        """The columns as a polars DataFrame; polars has no place for units.

        Returns
        -------
        polars.DataFrame
            Columns by the same names.

        Raises
        ------
        ImportError
            Where polars is not installed.
        """
        return _library("polars").DataFrame(dict(self.arrays))

    def _repr_html_(self) -> str:
        """Its first and last rows, for notebooks."""
        numbers = [*range(self.rows)]
        if self.rows > 2 * SHOWN:
            numbers = [*numbers[:SHOWN], -1, *numbers[-SHOWN:]]
        head = "".join(f"<th>{escape(self.heading(name))}</th>" for name in self)
        body = "".join(f"<tr>{self._cells(number)}</tr>" for number in numbers)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table><p>{self.rows} rows</p>"

    def _cells(self, row: int) -> str:
        if row < 0:
            return "<td>…</td>" * len(self)
        return "".join(f"<td>{escape(_text(values[row]))}</td>" for values in self.arrays.values())


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)


def _library(name: str) -> Any:
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError:
        said = f"{name} is not installed: `pip install {name}`; the columns themselves are NumPy arrays"
        raise ImportError(said) from None
