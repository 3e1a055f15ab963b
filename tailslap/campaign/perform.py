"""A whole sweep: its folder, the runs that have no row yet, table and page, and its command.

Unlike other result folders that of a sweep is there from the start, belongs to one sweep alone, and can be resumed:

    sweep.json       what the sweep is: another one in the same folder is refused
    records.sqlite   a record a finished run, see records.py
    sweep.parquet    the table, written when the sweep ends or is interrupted
    report.html, summary.json
    .tailslap-result.json  the manifest of the last three, see tailslap/files/manifest.py

One process at a time works in it: the lock goes with the process, however that ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tailslap import progress
from tailslap.campaign import engine, pools, records, report, table
from tailslap.campaign.definition import Definition
from tailslap.case import cost
from tailslap.errors import InputError, place_error
from tailslap.files import folder as result_folder
from tailslap.files import manifest

LOST, INTERRUPTED = 3, 130

DEFINITION, RECORDS = "sweep.json", "records.sqlite"
RESULTS = (table.TABLE, report.REPORT, report.SUMMARY)
"""Files that are written anew each time the sweep is resumed, and refused if the user has added or changed them."""


class StoppedError(Exception):
    """A sweep that ended before it was complete; `status` is the command's exit status."""

    def __init__(self, why: str, kept: int, runs: int, status: int) -> None:
        rows = f"{kept} of {runs} rows are kept; the same command resumes" if kept else "no run was finished"
        super().__init__(f"{why}; {rows}")
        self.status = status


def perform(
    definition: Definition,
    place: Path,
    cluster: str | None = None,
    workers: int | None = None,
    compute: Callable[..., dict[str, Any]] = table.compute_row,
    units: str = "si",
) -> table.FinishedSweep:
    """Make the runs that are missing in the folder `place`, and write what belongs there.

    cluster: address of a Dask scheduler; None: `workers` processes here. compute: the row of a run;
    units: of the page, "si" or "us".
    Raises InputError, and StoppedError for an interruption or the loss of the scheduler: the rows so far are then kept.
    """
    with sweep_folder(place, definition) as folder:
        try:
            with open_records(folder, definition) as rows:
                effort = _make_missing(definition, rows, cluster, workers, compute)
                table.write_table(folder, definition, rows)
                statuses = {name: rows.statuses[name] for name in table.STATUSES}
            done = table.FinishedSweep(definition, statuses, effort)
            report.write_sweep(done, folder, units)
            return done
        except KeyboardInterrupt:
            raise _stopped("interrupted", folder, definition, INTERRUPTED) from None
        except pools.LostError as lost:
            raise _stopped(str(lost), folder, definition, LOST) from None


def open_records(folder: Path, definition: Definition) -> contextlib.closing[records.Records]:
    """The rows of this sweep in its folder, by run."""
    return contextlib.closing(records.Records(folder / RECORDS, definition.as_written()))


def _stopped(why: str, folder: Path, definition: Definition, status: int) -> StoppedError:
    """The error to raise, when what is on disk is in the table."""
    with open_records(folder, definition) as rows:
        kept = len(rows)
        if kept:
            table.write_table(folder, definition, rows)
    return StoppedError(why, kept, definition.runs, status)


def _make_missing(
    definition: Definition,
    rows: records.Records,
    cluster: str | None,
    workers: int | None,
    compute: Callable[..., dict[str, Any]],
) -> engine.CampaignEffort:
    known = set(rows)
    missing = [run for run in range(definition.runs) if run not in known]
    if not missing:
        return engine.CampaignEffort()

    def died(run: Any) -> dict[str, Any]:
        return {"run": run, **definition.inputs_of(run), "status": table.ERROR, "reason": table.KILLS}

    def arguments(run: Any) -> tuple[Any, ...]:
        return run, definition.source, definition.changes_of(run)

    def look(threads: int) -> None:
        idle = "" if threads else "; no worker is there, waiting for one"
        failed = rows.statuses[table.FAILED] + rows.statuses[table.ERROR]
        show(len(rows), f", {failed} failed{idle}")

    cores = cost.available_cores()
    count = min(workers or cores, cores, len(missing))
    with (
        pools.cluster(cluster) if cluster else pools.local(count) as pool,
        progress.counted(definition.scene, definition.runs, len(rows)) as show,
    ):
        return engine.perform(engine.Parts(compute, [*missing], arguments, died), rows, pool, look)


@contextlib.contextmanager
def sweep_folder(place: Path, definition: Definition) -> Iterator[Path]:
    """The folder, locked, with the definition in it. What was new is removed again if it ends without any row.

    Raises InputError if it cannot be written, holds another sweep or something else, or is at work.
    """
    place = result_folder.resolved(place)
    _refuse_foreign(place, definition)
    made = result_folder.make_folders(place, place)
    try:
        with _locked(place):
            new = _claim(place, definition)
            try:
                yield place
            finally:
                if new and not records.count(place / RECORDS):
                    records.remove(place / RECORDS)
                    (place / DEFINITION).unlink(missing_ok=True)
    finally:
        result_folder.remove_folders(made)


def _refuse_foreign(place: Path, definition: Definition) -> None:
    """Before anything is written; what is there must be this sweep's, and its results as they were written."""
    if place.exists() and not place.is_dir():
        raise InputError("--out", str(place), "this is a file; allowed is a folder")
    manifest.clear_leftovers(place / DEFINITION)
    names = sorted(os.listdir(place)) if place.is_dir() else []
    if DEFINITION in names:
        _demand_same(place, definition)
        for name in RESULTS:
            manifest.demand_ours(place / name)
        return
    if names:
        shown = ", ".join(names[:2]) + (", ..." if names[2:] else "")
        allowed = f"it holds other files ({shown}); allowed is a new folder or a sweep's"
        raise InputError("--out", str(place), allowed)


@contextlib.contextmanager
def _locked(place: Path) -> Iterator[None]:
    number = os.open(place, os.O_RDONLY)
    try:
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            allowed = "another sweep is at work in it; wait for its end, or give another folder"
            raise InputError("--out", str(place), allowed) from None
        yield
    finally:
        os.close(number)


def _claim(place: Path, definition: Definition) -> bool:
    """Write the definition, or compare it with the one that is there; whether it was written."""
    if os.path.lexists(place / DEFINITION):
        _demand_same(place, definition)
        return False
    try:
        with manifest.whole_file(place / DEFINITION) as partial:
            text = json.dumps(definition.as_written(), indent=2, ensure_ascii=False)
            partial.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise place_error(place, "the folder cannot be written", error) from None
    return True


def _demand_same(place: Path, definition: Definition) -> None:
    """Raise InputError where the folder is another sweep's."""
    theirs, ours = None, definition.as_written()
    with contextlib.suppress(OSError, ValueError):
        theirs = json.loads((place / DEFINITION).read_text(encoding="utf-8"))
    if not isinstance(theirs, dict):
        raise InputError("--out", str(place), f"{DEFINITION} in it is damaged; allowed is a new folder")
    different = [name for name in ours if theirs.get(name) != ours[name]]
    if different:
        shown = ", ".join(name for name in different if name not in ("digest", "runs")) or "values"
        allowed = f"it holds another sweep: {shown} differ (see {DEFINITION}); allowed is that sweep or a new folder"
        raise InputError("--out", str(place), allowed)
