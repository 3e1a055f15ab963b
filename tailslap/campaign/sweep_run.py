"""Run of a sweep in its folder, which can be resumed.

The folder of a sweep exists from the start and belongs to one sweep:

    sweep.json       definition, by which another sweep is refused
    records.sqlite   record of each finished run, see records.py
    sweep.parquet    table, written when the sweep ends or is interrupted
    report.html, its charts, summary.json   written at the end

The last two lines are the result, with a manifest, and are replaced like other results: tailslap/storage/folder.py.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from postprocess.report.command_report import PAGE, SUMMARY, write_report
from tailslap import progress
from tailslap.arguments import UnitSystem, checked_arguments
from tailslap.campaign import engine, pools, records, sweep_report, sweep_table
from tailslap.campaign.records import Record
from tailslap.campaign.sweep_definition import Definition, make_definition, varied_source
from tailslap.case import resources
from tailslap.case.of_arguments import Changes, change_texts, folder_or_temporary, warn_of_numbers
from tailslap.errors import MACHINE_FAULTS, InputError, demand_encodable, machine_fault, place_error
from tailslap.result import columns, result
from tailslap.scene.read import Scene
from tailslap.scene.vary import added_names
from tailslap.storage import folder, manifest

LOST, INTERRUPTED = 3, 130
"""Exit statuses of a lost machine and of an interruption."""

DEFINITION, RECORDS = "sweep.json", "records.sqlite"
RESULTS = (sweep_table.TABLE, PAGE, SUMMARY)
"""Files that are rewritten when the sweep is resumed. A file that the user has added or changed is not replaced."""

Values = str | Sequence[object]
"""Values of a varied key: a list, or a text as on the command line, "log:20 GPa:2 TPa:5"."""

IN_THIS_PROCESS = 3
"""Runs of a sweep up to which no processes are started: that would take longer than the runs."""


class StoppedError(Exception):
    """A sweep that ended before it was complete.

    Parameters
    ----------
    why : str
        Reason.
    rows : int, optional
        Number of saved rows, None without a folder.
    runs : int
        Number of runs of the sweep.
    status : int
        Exit status of the command.
    """

    def __init__(self, why: str, rows: int | None, runs: int, status: int) -> None:
        saved = f"{rows} of {runs} rows are saved; the same command resumes the sweep"
        if not rows:
            saved = "without a folder no row is kept" if rows is None else "no run is complete"
        super().__init__(f"{why}; {saved}")
        self.why, self.status = why, status


def perform(
    definition: Definition,
    place: Path,
    cluster: str | None = None,
    workers: int | None = None,
    compute: Callable[..., Record] = sweep_table.compute_row,
    units: str = "si",
    force: bool = False,
) -> sweep_table.FinishedSweep:
    """Compute the missing runs and write the result.

    place: folder of the sweep; cluster: address of a Dask scheduler, without one `workers` processes of this machine,
    by default one per core; compute: returns the row of a run; units: of the page; force: replaces the result of
    another command. Raises InputError where the folder cannot be used, and StoppedError after an interruption, the loss
    of the scheduler, or on a full disk. Finished rows are saved.
    """
    origin = manifest.Origin("sweep", definition.scene)
    with sweep_folder(place, definition, force) as place:
        saved = 0
        try:
            with open_records(place, definition) as rows:
                try:
                    effort = _make_missing(definition, rows, cluster, workers, compute)
                    new = folder.fresh(place)
                    sweep_table.write_table(new, definition, rows)
                    statuses = {name: rows.statuses[name] for name in sweep_table.STATUSES}
                finally:
                    saved = len(rows)
            sweep = sweep_table.FinishedSweep(definition, statuses, effort)
            sweep = replace(sweep, report=sweep_report.write_sweep(sweep, new, units))
        except (KeyboardInterrupt, OSError) as error:
            why, status = _reason(error)
            if saved:
                with contextlib.suppress(OSError):  # on a full disk, the table is omitted
                    with open_records(place, definition) as rows:
                        sweep_table.write_table(folder.fresh(place), definition, rows)
                    folder.commit(place, origin)
            raise StoppedError(why, saved, definition.runs, status) from None
        folder.commit(place, origin)
        return sweep


def _reason(error: BaseException) -> tuple[str, int]:
    """Return the reason and exit status of an early end.

    Other errors are raised again.
    """
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", INTERRUPTED
    if isinstance(error, pools.LostError):
        return str(error), LOST
    if isinstance(error, OSError) and error.errno in MACHINE_FAULTS:
        return machine_fault(error), LOST
    raise error


def open_records(place: Path, definition: Definition) -> contextlib.closing[records.Records]:
    """Open the rows of a sweep in its folder, by run."""
    return contextlib.closing(records.Records(place / RECORDS, definition.as_written()))


def _make_missing(
    definition: Definition,
    rows: records.Records,
    cluster: str | None,
    workers: int | None,
    compute: Callable[..., Record],
) -> engine.CampaignEffort:
    """Compute the runs that have no row."""
    recorded = set(rows)
    missing = [run for run in range(definition.runs) if run not in recorded]
    if not missing:
        return engine.CampaignEffort()

    def died(run: records.Key) -> Record:
        inputs = definition.inputs_of(int(run))
        return {"run": run, **inputs, "status": sweep_table.ERROR, "reason": sweep_table.KILLS}

    def arguments(run: records.Key) -> tuple[object, ...]:
        return run, definition.source, definition.changes_of(int(run))

    def show_progress(threads: int) -> None:
        idle = "" if threads else "; waiting for a worker"
        failed = rows.statuses[sweep_table.FAILED] + rows.statuses[sweep_table.ERROR]
        show(len(rows), f", {failed} failed{idle}")

    count = resources.worker_count(workers, len(missing))
    with (
        pools.cluster(cluster) if cluster else pools.local(count) as pool,
        progress.counted(definition.scene, definition.runs, len(rows)) as show,
    ):
        parts = engine.Parts(compute, [*missing], arguments, died)
        return engine.Engine(parts, rows, pool).run(show_progress)


@contextlib.contextmanager
def sweep_folder(place: Path, definition: Definition, force: bool = False) -> Iterator[Path]:
    """Lock the folder of a sweep and write its definition.

    New files are removed if the sweep ends without a row. With `force`, the folder may contain the result of another
    command, which the table replaces. Raises InputError if the folder cannot be written, is locked, or contains another
    sweep or other files.
    """
    with folder.locked(place) as place:
        demand_encodable("--out", str(place))  # Arrow's paths are in UTF-8
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


def _write_definition(place: Path, definition: Definition) -> None:
    """Write `sweep.json` completely or not at all."""
    try:
        partial = folder.fresh(place) / DEFINITION
        text = json.dumps(definition.as_written(), indent=2, ensure_ascii=False)
        partial.write_text(text + "\n", encoding="utf-8")
        manifest.sync(partial)
        os.replace(partial, place / DEFINITION)
    except OSError as error:
        raise place_error(place, "the folder cannot be written", error) from None


def _is_known(place: Path, definition: Definition, force: bool) -> bool:
    """Return True for the folder of this sweep.

    Raises InputError for all other folders.
    """
    if DEFINITION not in folder.visible_names(place):
        folder.demand_result(place, force, manifest.Origin("sweep", definition.scene))
        return False
    stored, current = None, definition.as_written()
    try:
        stored = json.loads((place / DEFINITION).read_text(encoding="utf-8"))
    except OSError as error:
        raise place_error(place / DEFINITION, "the file cannot be read", error) from None
    except (ValueError, RecursionError):
        pass
    if not isinstance(stored, dict):
        raise InputError("--out", str(place), f"its {DEFINITION} is damaged; allowed is a new folder")
    different = [name for name in current if stored.get(name) != current[name]]
    if different:
        names = ", ".join(name for name in different if name not in ("digest", "runs")) or "values"
        allowed = (
            f"the folder contains another sweep ({names} differ, see {DEFINITION}); allowed is a new folder"
        )
        raise InputError("--out", str(place), allowed)
    return True


@checked_arguments
def sweep(
    scene: Scene,
    vary: Mapping[str, Values] | Sequence[str],
    changes: Changes | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
    sample: int | None = None,
    seed: int = 307,
    cluster: str | None = None,
    workers: int | None = None,
    units: UnitSystem = "si",
    force: bool = False,
) -> result.Result:
    """Run a scene for many values of its keys.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    vary : mapping or sequence of str
        Values by dotted key: a list, or a text as on the command line, "log:20 GPa:2 TPa:5".
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    folder : path, optional
        Result folder, in which an interrupted sweep resumes. By default nothing is written.
    sample : int, optional
        Number of runs of a Latin hypercube in place of the grid; ranges are then "a:b" or "log:a:b".
    seed : int
        Random seed of the samples.
    cluster : str, optional
        Address of a Dask scheduler.
    workers : int, optional
        Number of worker processes; 0 runs in this process. Default: 0 for up to three runs and for objects registered
        in this process, otherwise the number of cores.
    units : {"si", "us"}
        Units of the page and the printed text, "si" or "us"; numbers are in SI.
    force : bool
        Replace the result of another command, but not of another sweep, in this folder.

    Returns
    -------
    Result
        `history` is the table, one row per run; `charts` contains the charts of the page by name.

    Raises
    ------
    InputError
        For an invalid scene, key or value, and for objects registered in this process with workers or a cluster.
    StoppedError
        If the sweep is interrupted or the cluster is lost; completed rows remain in the folder.

    Examples
    --------
    >>> import tailslap
    >>> result = tailslap.sweep("paper-table-3", {"corner.friction": [0.2, 0.47]})
    >>> [f"{v_gy:.2f}" for v_gy in result.history["fe.v_gy"]]
    ['-3.28', '-3.28']
    """
    typed = not isinstance(vary, Mapping)
    if isinstance(vary, Mapping):
        texts = {k: v if isinstance(v, str) else ",".join(map(str, v)) for k, v in vary.items()}
        vary = [f"{key}={text}" for key, text in texts.items()]
    sweep_definition = make_definition(scene, change_texts(changes), tuple(vary), sample, seed)
    source = varied_source(sweep_definition) if typed else sweep_definition.source
    warn_of_numbers(source, not isinstance(changes, Mapping))
    local = _local_names(sweep_definition)
    if local and (workers or cluster):
        key, value = "--workers" if workers else "--cluster", workers or cluster
        raise InputError(key, value, f"{', '.join(local)} is registered in this process only; use workers=0")
    if workers is None and not cluster and (local or sweep_definition.runs <= IN_THIS_PROCESS):
        workers = 0
    with folder_or_temporary(folder) as place:
        return sweep_result(sweep_definition, place, cluster, workers, units, force, stays=folder is not None)


def sweep_result(
    sweep_definition: Definition,
    place: Path,
    cluster: str | None,
    workers: int | None,
    units: str,
    force: bool,
    stays: bool = True,
) -> result.Result:
    """Run a sweep in a folder.

    stays: False for a folder that is removed afterwards. Raises StoppedError.
    """
    if cluster and workers:
        raise InputError(
            "--workers", workers, "--cluster and --workers exclude each other; remove one of the two"
        )
    try:
        outcome = perform(sweep_definition, place, cluster, workers, units=units, force=force)
    except StoppedError as stopped:
        if stays:
            raise
        raise StoppedError(stopped.why, None, sweep_definition.runs, stopped.status) from None
    page, table = outcome.report, (place / sweep_table.TABLE).read_bytes()
    assert page is not None
    histories = {"table": columns.table(columns.read_columns(place / sweep_table.TABLE))}

    def fill(folder: Path, pictures: bool, units: str) -> None:
        (folder / sweep_table.TABLE).write_bytes(table)
        write_report(page, folder)

    text, passed = sweep_report.sweep_text(outcome, place if stays else None), outcome.failures == 0
    return result.of_report("sweep", page, passed=passed, histories=histories, text=text, fill=fill)


def _local_names(sweep_definition: Definition) -> list[str]:
    """Return names of objects that this process alone has registered."""
    names = []
    for key, added in added_names().items():
        table, _, name = key.partition(".")
        used = {sweep_definition.source.tables.get(table, {}).get(name)}
        used |= {value for item in sweep_definition.variations if item.key == key for value in item.settings}
        names += [f"{key} = {value}" for value in used & added]
    return names
