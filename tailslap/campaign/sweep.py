"""Run a scene for many values of its keys."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from postprocess.report.command_report import write_report
from tailslap.arguments import UnitSystem, checked_arguments
from tailslap.campaign.sweep_definition import Definition
from tailslap.case.of_arguments import Changes, change_texts, folder_or_temporary, warn_of_numbers
from tailslap.errors import InputError
from tailslap.result import columns, result
from tailslap.scene.objects import added_names

Values = str | Sequence[object]
"""Values of a varied key: a list, or a text as on the command line, "log:20 GPa:2 TPa:5"."""

IN_THIS_PROCESS = 3
"""Runs of a sweep up to which no processes are started: that would take longer than the runs."""


@checked_arguments
def sweep(
    scene: str | os.PathLike[str],
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
    scene : str or path
        Name of a scene of the program, or path of a TOML file.
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
    from tailslap.campaign.sweep_definition import make_definition, varied_source

    typed = not isinstance(vary, Mapping)
    if isinstance(vary, Mapping):
        texts = {k: v if isinstance(v, str) else ",".join(map(str, v)) for k, v in vary.items()}
        vary = [f"{key}={text}" for key, text in texts.items()]
    sweep_definition = make_definition(os.fspath(scene), change_texts(changes), tuple(vary), sample, seed)
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
    from tailslap.campaign import sweep_report, sweep_run
    from tailslap.campaign.sweep_table import TABLE

    if cluster and workers:
        raise InputError(
            "--workers", workers, "--cluster and --workers exclude each other; remove one of the two"
        )
    try:
        outcome = sweep_run.perform(sweep_definition, place, cluster, workers, units=units, force=force)
    except sweep_run.StoppedError as stopped:
        if stays:
            raise
        raise sweep_run.StoppedError(stopped.why, None, sweep_definition.runs, stopped.status) from None
    page, table = outcome.report, (place / TABLE).read_bytes()
    assert page is not None
    histories = {"table": columns.table(columns.read_columns(place / TABLE))}

    def fill(folder: Path, pictures: bool, units: str) -> None:
        (folder / TABLE).write_bytes(table)
        write_report(page, folder)

    text, passed = sweep_report.sweep_text(outcome, place if stays else None), outcome.failures == 0
    return result.of_report("sweep", page, passed=passed, histories=histories, text=text, fill=fill)


def _local_names(sweep_definition: Definition) -> list[str]:
    """Return names of objects that this process alone has registered."""
    names = []
    for key, added in added_names().items():
        table, _, name = key.partition(".")
        used = {sweep_definition.source.given.get(table, {}).get(name)}
        used |= {value for item in sweep_definition.variations if item.key == key for value in item.settings}
        names += [f"{key} = {value}" for value in used & added]
    return names
