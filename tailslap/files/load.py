"""Results that lie in folders, read again; names and units of the columns of their histories."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fem.explicit.columns import COLUMNS, IMPACT_COLUMNS, HistoryColumn
from postprocess.report import page
from tailslap import result
from tailslap.errors import InputError, Verbatim

SWEEP, SUMMARY = "sweep.parquet", "summary.json"
COMMANDS = {"modes": "modes", "compared": "compare", "stage2": "rigid", "strikes": "rigid"}
"""The command that leaves a summary with this key."""
FILES = {result.FE: "history.csv", result.RIGID: "rigid.csv"}

ENERGY_ERROR = HistoryColumn("energy_error", "J", meaning="what the energy balance leaves unaccounted for")


def corner_columns() -> dict[str, HistoryColumn]:
    """Columns of a run with a constrained corner, those from outside the program among them."""
    t = HistoryColumn("t", "s", meaning="time since the start of Stage 2")
    return {column.name: column for column in (t, *COLUMNS.values(), ENERGY_ERROR)}


def impact_columns() -> dict[str, HistoryColumn]:
    """Columns of a whole impact."""
    return IMPACT_COLUMNS | {ENERGY_ERROR.name: ENERGY_ERROR}


def column_units(names: Iterable[str]) -> dict[str, str]:
    """SI units of the columns of either calculation that have one of these names."""
    known = impact_columns() | corner_columns()
    return {name: known[name].unit for name in names if name in known}


def history(columns: Mapping[str, Any]) -> result.Columns:
    """Columns with the units that their names have."""
    return result.Columns(columns, column_units(columns))


def load(folder: str | os.PathLike[str]) -> result.Result:
    """Read a result folder again, of a run, a study or a sweep.

    Parameters
    ----------
    folder : path
        That a command, or `Result.save`, has left.

    Returns
    -------
    Result
        With the numbers and histories of its files, every bit of them.

    Raises
    ------
    InputError
        Where there is no result in the folder.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.load("results/mash-tl4-sut").history["v_gy"]  # doctest: +SKIP
    """
    from postprocess.fields import series

    place = Path(folder)
    summary = _summary(place)
    if (place / SWEEP).is_file():
        return sweep_result(place)
    histories = {
        label: history(page.read_history(place / name))
        for label, name in FILES.items()
        if (place / name).is_file()
    }
    fields = place / series.FILE
    if result.FE in histories:
        kept = (lambda: series.read_fields(fields)) if fields.is_file() else None
        return result.of_run(summary, histories, _copies(place), kept)
    command = f"study {summary.get('study')}"
    if "study" not in summary:
        command = next((command for key, command in COMMANDS.items() if key in summary), "paper")
    name, passed = str(summary.get("scene", "")), summary.get("passed")
    return result.Result(command, name, summary, passed=passed, histories=histories, fill=_copies(place))


def read_columns(path: Path, names: Iterable[str] | None = None) -> dict[str, np.ndarray]:
    """Read columns of a sweep's table, without names all; numbers that a row lacks are NaN."""
    import pyarrow.parquet as pq

    table = pq.read_table(path, columns=None if names is None else list(names))
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


def sweep_result(place: Path) -> result.Result:
    """The table of a sweep's folder."""
    columns, summary = read_columns(place / SWEEP), _summary(place)
    scene = str(summary.get("scene", place.name))
    passed = not any(status in ("failed", "error") for status in columns["status"])
    return result.Result("sweep", scene, summary, passed=passed, histories={"table": result.Columns(columns)})


def _summary(place: Path) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads((place / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        allowed = f"there is no {SUMMARY} that can be read; allowed is a result folder of tailslap"
        raise InputError("folder", str(place), allowed) from None
    if not isinstance(found, dict):
        raise InputError("folder", Verbatim(place), f"its {SUMMARY} is not one of tailslap's")
    return found


def _copies(place: Path) -> Any:
    """Make a function that fills another folder with the files of this one."""

    from tailslap.files import manifest

    def fill(folder: Path, pictures: bool, units: str) -> None:
        for entry in manifest.read_manifest(place) or ():
            if entry.path != manifest.NAME and (pictures or not entry.path.startswith("contour_")):
                shutil.copyfile(place / entry.path, folder / entry.path)

    return fill
