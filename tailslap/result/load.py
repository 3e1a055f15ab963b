"""Load results from their folders."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tailslap import errors
from tailslap.arguments import checked_arguments
from tailslap.result import columns, result
from tailslap.storage import folder, manifest

Read = TypeVar("Read")

SWEEP, SUMMARY = "sweep.parquet", "summary.json"
FILES = {result.FE: "history.csv", result.RIGID: "rigid.csv", result.SPACE: "space.csv"}


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
        """Raise InputError without a result or a whole manifest."""
        if SUMMARY not in self.names:
            allowed = f"it has no readable {SUMMARY}; allowed is a result folder of tailslap"
            raise errors.InputError("folder", str(self.place), allowed)
        if self.listed is None:
            self._complain(f"its manifest {manifest.NAME} is missing or damaged")

    def read(self, name: str, parse: Callable[[BytesIO], Read]) -> Read | None:
        """Parse a file, None if it is absent or unreadable.

        An unreadable file is omitted with force. Raises InputError for a damaged file.
        """
        if name not in self.names:
            return None
        try:
            return parse(BytesIO(self._content(name)))
        except (errors.InputError, Warning):
            raise
        except Exception as error:  # damaged bytes may raise any error in a parser
            if isinstance(error, OSError) and error.errno in errors.MACHINE_FAULTS:
                raise
            self._complain(f"its file {name} cannot be read, {type(error).__name__}: {error}")
            return None

    def _content(self, name: str) -> bytes:
        """Read a file at once.

        Parsers therefore meet no error of the system.
        """
        with open(folder.path_in(self.place, name), "rb", opener=manifest.open_plain) as file:
            size = os.fstat(file.fileno()).st_size
            listed = self.listed[name] if self.listed is not None else None
            if listed and size != listed.size:
                self._complain(f"its file {name} is damaged or was modified")
            content = file.read()
        if listed and size == listed.size and hashlib.sha256(content).hexdigest() != listed.sha256:
            self._complain(f"its file {name} is damaged or was modified")
        return content

    def _complain(self, why: str) -> None:
        """Refuse a damaged result, or warn.

        Raises InputError without force.
        """
        if not self._force or Stored(self.place).listed != self.listed:
            allowed = f"{why}; --force (Python: force=True) reads the intact files"
            raise errors.InputError("folder", str(self.place), allowed)
        warnings.warn(f"{self.place}: {why}", stacklevel=2)

    def copy(self, place: Path, pictures: bool, units: str) -> None:
        """Copy these files to another folder."""
        for name in self.names - {manifest.NAME}:
            content = (
                self.read(name, BytesIO.getvalue) if pictures or not name.startswith("contour_") else None
            )
            if content is not None:
                (place / name).write_bytes(content)


def _names_in(place: Path) -> set[str]:
    """Return names in a folder.

    An absent folder has none. Raises InputError for a folder that cannot be read.
    """
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
    """Return the result of a folder's files."""
    from postprocess.fields import series

    tables = {
        label: stored.read(name, lambda file: read_history(file.read())) for label, name in FILES.items()
    }
    histories = {label: columns.history(table) for label, table in tables.items() if table is not None}
    if (rows := stored.read(SWEEP, columns.read_columns)) is not None:
        histories["table"] = columns.table(rows)
    fields = (lambda: stored.read(series.FILE, series.read_fields)) if series.FILE in stored.names else None
    command, scene, changes = stored.origin
    bare = result.Result(
        command, scene, {}, histories=histories, fill=stored.copy, make_fields=fields, changes=changes
    )

    def with_summary(file: BytesIO) -> result.Result:
        summary = json.load(file)
        if result.FE in histories:
            complete = result.of_run(summary, bare)
        else:
            name, passed = str(summary.get("scene", "")), summary.get("passed")
            complete = replace(bare, scene=name, summary=summary, passed=passed)
        str(complete)  # fails for a damaged summary
        return complete

    return replace(stored.read(SUMMARY, with_summary) or bare, inputs=(stored.place,))


def demand_listed(path: Path, force: bool) -> bool:
    """Return True if the manifest of its folder lists a file.

    Raises InputError for a file that differs; with force, warns.
    """
    stored = Stored(path.parent, force)
    is_listed = path.name in (stored.listed or {})
    if is_listed:
        stored.read(path.name, id)
    return is_listed
