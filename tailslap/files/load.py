"""Results that lie in folders, read again; names and units of the columns of their histories."""

from __future__ import annotations

import json
import os
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from io import BufferedReader
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fem.explicit.columns import COLUMNS, IMPACT_COLUMNS, HistoryColumn
from tailslap import errors, result
from tailslap.arguments import checked_arguments
from tailslap.files import folder, manifest

Read = TypeVar("Read")

SWEEP, SUMMARY = "sweep.parquet", "summary.json"
FILES = {result.FE: "history.csv", result.RIGID: "rigid.csv"}

ENERGY_ERROR = HistoryColumn("energy_error", "J", meaning="energy-balance error")


def corner_columns() -> dict[str, HistoryColumn]:
    """Columns of a run with a constrained corner, those from outside the program among them."""
    t = HistoryColumn("t", "s", meaning="time since the start of Stage 2")
    return {column.name: column for column in (t, *COLUMNS.values(), ENERGY_ERROR)}


def impact_columns() -> dict[str, HistoryColumn]:
    """Columns of a whole impact."""
    return IMPACT_COLUMNS | {ENERGY_ERROR.name: ENERGY_ERROR}


def train_columns() -> dict[str, HistoryColumn]:
    """Columns that trains have besides, of each hinge with its number at the end."""
    force = "of the unit behind on the one ahead, {} the wall, mean since the row before"
    angle = "angle between the unit behind and the wall less that of the one ahead"
    columns = (
        HistoryColumn("hinge_force_x", "N", meaning=force.format("along")),
        HistoryColumn("hinge_force_y", "N", meaning=force.format("across")),
        HistoryColumn("articulation", "rad", meaning=angle),
    )
    return {column.name: column for column in columns}


def column_units(names: Iterable[str]) -> dict[str, str]:
    """SI units of the columns of either calculation that have one of these names, with a unit's number or without."""
    known = train_columns() | impact_columns() | corner_columns()
    found = {name: known.get(re.sub(r"_[1-8]$", "", name)) for name in names}
    return {name: column.unit for name, column in found.items() if column}


def history(columns: Mapping[str, Any]) -> result.Columns:
    """Columns with the units that their names have."""
    return result.Columns(columns, column_units(columns))


def table(columns: Mapping[str, Any]) -> result.Columns:
    """Columns of a sweep, with the units of keys and of compared quantities."""
    from postprocess.comparison.quantities import STRIKES, TAIL_SLAP
    from tailslap.scene import schema, write

    compared = {**TAIL_SLAP.quantities, **STRIKES.quantities}
    units = {f"{of}.{key}": each.unit for of in ("fe", "rigid") for key, each in compared.items()}
    units |= {
        f"{name}.{key}": write.unit_of(field)
        for name, its in schema.TABLES.items()
        for key, field in its.model_fields.items()
    }
    return result.Columns(columns, {name: units[name] for name in columns if units.get(name)})


class Stored:
    """Files of a result folder, verified by the manifest.

    force: read damaged files with a warning, and omit unreadable ones. Files that are not in the manifest are ignored.
    """

    def __init__(self, place: Path, force: bool = False) -> None:
        self.place, self._force = place, force
        try:
            folder.recover(place)
            home = folder.path_in(place, manifest.NAME).parent
            listed, self.origin = manifest.read_manifest(home), manifest.read_origin(home)
        except OSError as error:
            raise errors.place_error(place, "the folder cannot be read", error, "folder") from None
        self.listed = None if listed is None else {item.path: item for item in listed}
        self.names = _names_in(place) if self.listed is None else {*self.listed}

    def demand_manifest(self) -> None:
        """Raise InputError for a folder that has no result, or one without a whole manifest."""
        if SUMMARY not in self.names:
            allowed = f"it has no readable {SUMMARY}; allowed is a result folder of tailslap"
            raise errors.InputError("folder", str(self.place), allowed)
        if self.listed is None:
            self._complain(f"its manifest {manifest.NAME} is missing or damaged")

    def read(self, name: str, parse: Callable[[BufferedReader], Read]) -> Read | None:
        """Parse a file; None where there is none, or nothing can be read. Raises InputError for one that is damaged."""
        if name not in self.names:
            return None
        try:
            with open(folder.path_in(self.place, name), "rb", opener=manifest.open_plain) as file:
                if self.listed is not None and manifest.entry_of(file, name) != self.listed[name]:
                    self._complain(f"its file {name} is damaged or was modified")
                file.seek(0)
                return parse(file)
        except (errors.InputError, Warning):
            raise
        except Exception as error:  # a parser raises what it likes over damaged bytes
            if isinstance(error, OSError) and error.errno in errors.MACHINE_FAULTS:
                raise
            self._complain(f"its file {name} cannot be read, {type(error).__name__}: {error}")
            return None

    def _complain(self, why: str) -> None:
        if not self._force or Stored(self.place).listed != self.listed:
            said = f"{why}; --force (Python: force=True) reads the intact files"
            raise errors.InputError("folder", str(self.place), said)
        warnings.warn(f"{self.place}: {why}", stacklevel=2)

    def copy(self, place: Path, pictures: bool, units: str) -> None:
        """Fill another folder with these files."""
        for name in self.names - {manifest.NAME}:
            content = (
                self.read(name, BufferedReader.read) if pictures or not name.startswith("contour_") else None
            )
            if content is not None:
                (place / name).write_bytes(content)


def _names_in(place: Path) -> set[str]:
    """Names in a folder, none where there is no folder. Raises InputError for one that cannot be read."""
    try:
        return {*os.listdir(place)}
    except (FileNotFoundError, NotADirectoryError):
        return set()
    except OSError as error:
        raise errors.place_error(place, "the folder cannot be read", error, "folder") from None


@checked_arguments
def load(folder: str | os.PathLike[str], *, force: bool = False) -> result.Result:
    """Load the result folder of a run, a study or a sweep.

    Parameters
    ----------
    folder : path
        Result folder of a command or of `Result.save`.
    force : bool
        Read the intact files of a damaged or modified result, with a warning.

    Returns
    -------
    Result
        Result with the numbers and histories of the files, bitwise equal.

    Raises
    ------
    InputError
        For a folder without a result, or with files that differ from its manifest.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.load("results/mash-tl4-sut").history["v_gy"]  # doctest: +SKIP
    """
    place = Path(folder)
    stored = Stored(place, force)
    stored.demand_manifest()
    try:
        return _loaded(stored)
    except errors.InputError:
        again = Stored(place, force)
        if again.listed == stored.listed:
            raise
        return _loaded(again)  # a command has replaced the result meanwhile


def read_history(content: bytes) -> dict[str, NDArray[np.float64]]:
    """Return the columns of a history file by name, shape (n,)."""
    header, _, body = content.decode().partition("\n")
    names = header.split(",")
    if len({*names}) < len(names) or any(name != name.strip() or not name for name in names):
        raise ValueError("its first line has no column names")
    rows = [line.split(",") for line in body.splitlines()]
    table = np.array([[entry or "nan" for entry in row] for row in rows], dtype=np.float64)
    table = table.reshape(-1, len(names))
    return {name: np.ascontiguousarray(table[:, column]) for column, name in enumerate(names)}


def _loaded(stored: Stored) -> result.Result:
    from postprocess.fields import series

    tables = {
        label: stored.read(name, lambda file: read_history(file.read())) for label, name in FILES.items()
    }
    histories = {label: history(columns) for label, columns in tables.items() if columns is not None}
    if (rows := stored.read(SWEEP, read_columns)) is not None:
        histories["table"] = table(rows)
    fields = (lambda: stored.read(series.FILE, series.read_fields)) if series.FILE in stored.names else None

    def made(file: BufferedReader) -> result.Result:
        summary = json.load(file)
        if result.FE in histories:
            found = result.of_run(summary, histories, stored.copy, fields)
        else:
            name, passed = str(summary.get("scene", "")), summary.get("passed")
            found = replace(bare, scene=name, summary=summary, passed=passed)
        str(found)  # says all that it has
        return found

    bare = result.Result(*stored.origin, {}, histories=histories, fill=stored.copy, make_fields=fields)
    return replace(stored.read(SUMMARY, made) or bare, inputs=(stored.place,))


def demand_listed(path: Path, force: bool) -> bool:
    """True if the manifest of its folder lists a file. Raises InputError for one that differs; with force, warns."""
    stored = Stored(path.parent, force)
    is_listed = path.name in (stored.listed or {})
    if is_listed:
        stored.read(path.name, id)
    return is_listed


def read_columns(source: Path | BufferedReader, names: Iterable[str] | None = None) -> dict[str, np.ndarray]:
    """Read columns of the table of a sweep, by default all; missing numbers are NaN."""
    import pyarrow.parquet as pq

    # Without Arrow's threads: one that frees a buffer of Python's while the interpreter ends aborts the process
    # (apache/arrow issue 34314).
    with pq.ParquetFile(source, pre_buffer=False) as file:
        table = file.read(None if names is None else list(names), use_threads=False)
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}
