"""A whole sweep: its folder, the runs that have no row yet, table and page, and its command.

Unlike other result folders that of a sweep is there from the start, belongs to one sweep alone, and can be resumed:

    sweep.json       what the sweep is: another one in the same folder is refused
    records.sqlite   a record a finished run, see records.py
    sweep.parquet    the table, written when the sweep ends or is interrupted
    report.html, its charts, summary.json: when it ends

The last two lines are its result, with a manifest, which the command replaces as any other: tailslap/storage/folder.py.
"""

import contextlib
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from tailslap import progress
from tailslap.campaign import definition as sweeps
from tailslap.campaign import engine, pools, records, report
from tailslap.case import cost
from tailslap.errors import MACHINE_FAULTS, InputError, machine_fault, place_error
from tailslap.storage import folder, manifest

LOST, INTERRUPTED = 3, 130

DEFINITION, RECORDS = "sweep.json", "records.sqlite"
RESULTS = (sweeps.TABLE, report.REPORT, report.SUMMARY)
"""Files that are written anew each time the sweep is resumed, and refused if the user has added or changed them."""


class StoppedError(Exception):
    """A sweep that ended before it was complete; kept: number of rows, None without a folder; `status` is the command's
    exit status."""

    def __init__(self, why: str, kept: int | None, runs: int, status: int) -> None:
        rows = (
            f"{kept} of {runs} rows are saved; the same command resumes the sweep"
            if kept
            else "no run is complete"
        )
        super().__init__(f"{why}; {'without a folder no row is kept' if kept is None else rows}")
        self.why, self.status = why, status


def perform(
    definition: sweeps.Definition,
    place: Path,
    cluster: str | None = None,
    workers: int | None = None,
    compute: Callable[..., dict[str, Any]] = sweeps.compute_row,
    units: str = "si",
    force: bool = False,
) -> sweeps.FinishedSweep:
    """Make the runs that are missing in the folder `place`, and write what belongs there.

    cluster: address of a Dask scheduler; None: `workers` processes here. compute: the row of a run;
    units: of the page, "si" or "us"; force: also where there is a result of another command.
    Raises InputError, and StoppedError for an interruption, the loss of the scheduler or a full disk: the rows so far
    are then kept.
    """
    origin = manifest.Origin("sweep", definition.scene)
    with sweep_folder(place, definition, force) as place:
        kept = 0
        try:
            with open_records(place, definition) as rows:
                try:
                    effort = _make_missing(definition, rows, cluster, workers, compute)
                    new = folder.fresh(place)
                    sweeps.write_table(new, definition, rows)
                    statuses = {name: rows.statuses[name] for name in sweeps.STATUSES}
                finally:
                    kept = len(rows)
            done = sweeps.FinishedSweep(definition, statuses, effort)
            done = replace(done, report=report.write_sweep(done, new, units))
        except (KeyboardInterrupt, OSError) as error:
            why, status = _reason(error)
            if kept:
                with contextlib.suppress(OSError):  # on a full disk the rows alone are kept
                    with open_records(place, definition) as rows:
                        sweeps.write_table(folder.fresh(place), definition, rows)
                    folder.commit(place, origin)
            raise StoppedError(why, kept, definition.runs, status) from None
        folder.commit(place, origin)
        return done


def _reason(error: BaseException) -> tuple[str, int]:
    """Why a sweep ended early, and the status of that; what else went wrong is raised on."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", INTERRUPTED
    if isinstance(error, pools.LostError):
        return str(error), LOST
    if isinstance(error, OSError) and error.errno in MACHINE_FAULTS:
        return machine_fault(error), LOST
    raise error


def open_records(place: Path, definition: sweeps.Definition) -> contextlib.closing[records.Records]:
    """Open the rows of this sweep in its folder, by run."""
    return contextlib.closing(records.Records(place / RECORDS, definition.as_written()))


def _make_missing(
    definition: sweeps.Definition,
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
        return {"run": run, **definition.inputs_of(run), "status": sweeps.ERROR, "reason": sweeps.KILLS}

    def arguments(run: Any) -> tuple[Any, ...]:
        return run, definition.source, definition.changes_of(run)

    def look(threads: int) -> None:
        idle = "" if threads else "; waiting for a worker"
        failed = rows.statuses[sweeps.FAILED] + rows.statuses[sweeps.ERROR]
        show(len(rows), f", {failed} failed{idle}")

    count = cost.worker_count(workers, len(missing))
    with (
        pools.cluster(cluster) if cluster else pools.local(count) as pool,
        progress.counted(definition.scene, definition.runs, len(rows)) as show,
    ):
        return engine.perform(engine.Parts(compute, [*missing], arguments, died), rows, pool, look)


@contextlib.contextmanager
def sweep_folder(place: Path, definition: sweeps.Definition, force: bool = False) -> Iterator[Path]:
    """The folder, locked, with the definition in it. What was new is removed again if it ends without any row.

    force: also where there is a result of another command, which goes when the table is there.
    Raises InputError if it cannot be written, holds another sweep or something else, or is at work.
    """
    with folder.locked(place) as place:
        new = not _is_known(place, definition, force)
        folder.earlier(place, RESULTS)
        if new:
            _write_definition(place, definition)
        try:
            yield place
        finally:
            if new and not records.count(place / RECORDS):
                records.remove(place / RECORDS)
                (place / DEFINITION).unlink(missing_ok=True)


def _write_definition(place: Path, definition: sweeps.Definition) -> None:
    try:
        partial = folder.fresh(place) / DEFINITION
        text = json.dumps(definition.as_written(), indent=2, ensure_ascii=False)
        partial.write_text(text + "\n", encoding="utf-8")
        manifest.sync(partial)
        os.replace(partial, place / DEFINITION)
    except OSError as error:
        raise place_error(place, "the folder cannot be written", error) from None


def _is_known(place: Path, definition: sweeps.Definition, force: bool) -> bool:
    """True where the folder is this sweep's, False where it may become so. Raises InputError for all others."""
    if DEFINITION not in folder.visible_names(place):
        folder.demand_result(place, force, manifest.Origin("sweep", definition.scene))
        return False
    theirs, ours = None, definition.as_written()
    try:
        theirs = json.loads((place / DEFINITION).read_text(encoding="utf-8"))
    except OSError as error:
        raise place_error(place / DEFINITION, "the file cannot be read", error) from None
    except (ValueError, RecursionError):
        pass
    if not isinstance(theirs, dict):
        raise InputError("--out", str(place), f"its {DEFINITION} is damaged; allowed is a new folder")
    different = [name for name in ours if theirs.get(name) != ours[name]]
    if different:
        shown = ", ".join(name for name in different if name not in ("digest", "runs")) or "values"
        allowed = (
            f"the folder contains another sweep ({shown} differ, see {DEFINITION}); allowed is a new folder"
        )
        raise InputError("--out", str(place), allowed)
    return True
