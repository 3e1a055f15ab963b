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
from tailslap.files import folder, manifest

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
    with sweep_folder(place, definition) as place:
        try:
            with open_records(place, definition) as rows:
                effort = _make_missing(definition, rows, cluster, workers, compute)
                table.write_table(place, definition, rows)
                statuses = {name: rows.statuses[name] for name in table.STATUSES}
            done = table.FinishedSweep(definition, statuses, effort)
            report.write_sweep(done, place, units)
            return done
        except (KeyboardInterrupt, pools.LostError) as error:
            is_lost = isinstance(error, pools.LostError)
            with open_records(place, definition) as rows:
                if kept := len(rows):
                    table.write_table(place, definition, rows)
            why, status = (str(error), LOST) if is_lost else ("interrupted", INTERRUPTED)
            raise StoppedError(why, kept, definition.runs, status) from None


def open_records(place: Path, definition: Definition) -> contextlib.closing[records.Records]:
    """Open the rows of this sweep in its folder, by run."""
    return contextlib.closing(records.Records(place / RECORDS, definition.as_written()))


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
    place = folder.resolved(place)
    if place.exists() and not place.is_dir():
        raise InputError("--out", str(place), "this is a file; allowed is a folder")
    manifest.clear_leftovers(place / DEFINITION)
    is_known = _is_known(place, definition)  # before anything is written
    for name in RESULTS if is_known else ():
        manifest.demand_ours(place / name)
    made = folder.make_folders(place, place)
    try:
        with manifest.locked(place) as is_alone:
            if not is_alone:
                allowed = "another sweep is at work in it; wait for its end, or give another folder"
                raise InputError("--out", str(place), allowed)
            new = not _is_known(place, definition)
            if new:
                _write_definition(place, definition)
            try:
                yield place
            finally:
                if new and not records.count(place / RECORDS):
                    records.remove(place / RECORDS)
                    (place / DEFINITION).unlink(missing_ok=True)
    finally:
        folder.remove_folders(made)


def _write_definition(place: Path, definition: Definition) -> None:
    try:
        with manifest.whole_file(place / DEFINITION) as partial:
            text = json.dumps(definition.as_written(), indent=2, ensure_ascii=False)
            partial.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise place_error(place, "the folder cannot be written", error) from None


def _is_known(place: Path, definition: Definition) -> bool:
    """True where the folder is this sweep's, False for an empty or missing one. Raises InputError for all others."""
    names = sorted(os.listdir(place)) if place.is_dir() else []
    if DEFINITION not in names:
        if names:
            raise folder.others(place, names, "allowed is a new folder or a sweep's")
        return False
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
    return True
