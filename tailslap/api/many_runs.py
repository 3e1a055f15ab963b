"""Many runs of a scene: prepared studies, and sweeps."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from postprocess.files.summary import plain
from postprocess.report.table import Table
from postprocess.report.terminal import printed
from tailslap.api.laws import named
from tailslap.api.result import Result, filled_by
from tailslap.errors import InputError
from tailslap.scene.vary import shown

Values = str | Sequence[Any]
"""Of a key that varies: a list, or text as the command takes it, "log:20 GPa:2 TPa:5"."""


def study(
    name: str,
    scene: str | os.PathLike[str],
    changes: Mapping[str, Any] | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
    allow_large: bool = False,
    **options: Any,
) -> Result:
    """Run a prepared study of a scene.

    Parameters
    ----------
    name : str
        "cost", "flexibility", "stability" or "uncertainty".
    scene : str or path
        Name of a scene that comes with the program, or path of a TOML file.
    changes : mapping, optional
        As of `run`.
    folder : path, optional
        Where the command would leave its result: an interrupted study goes on from the journal beside it. Nothing is
        written there but by `save`.
    allow_large : bool
        As of `run`.
    **options : object
        The study's own, by the names on the command line with "_" for "-": samples=1000, range={"impact.friction":
        "0.2:0.5"}; those that can be given several times take a list or a dict.

    Returns
    -------
    Result
        `summary` is what the command's `summary.json` holds.

    Raises
    ------
    InputError
        As `run`, and for a study or an option that is wrong.

    Examples
    --------
    >>> import tailslap
    >>> found = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000)
    >>> found.summary["study"], found.passed
    ('uncertainty', None)
    """
    import click

    from tailslap.studies import find_study
    from tailslap.studies.study import compute_study, study_command

    chosen = find_study(name)
    words = [os.fspath(scene), *_words("set", named(changes or {})), *_options(options)]
    try:
        given = study_command(chosen).make_context(name, words).params
    except click.UsageError as error:
        raise InputError(f"study {name}", " ".join(words[1:]), error.format_message()) from None
    own = {str(option.name): given[str(option.name)] for option in chosen.options}
    out = None if folder is None else Path(folder)
    found = compute_study(chosen, given["name"], given["changes"], out, allow_large, own)[1]
    report = chosen.report(found)

    parts = [part for part in report.terminal if isinstance(part, Table)]
    tables = {part.title or f"Table {n}": part for n, part in enumerate(parts, 1)} | dict(report.tables)
    page, summary = report.page, plain(report.summary)
    said = printed(report.terminal)
    fill = filled_by(lambda place, pictures: report)
    return Result(
        f"study {name}", page.title, summary, page.headline, page.passed, tables, fill=fill, text=said
    )


def sweep(
    scene: str | os.PathLike[str],
    vary: Mapping[str, Values],
    changes: Mapping[str, Any] | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
    sample: int | None = None,
    seed: int = 307,
    cluster: str | None = None,
    workers: int | None = None,
) -> Result:
    """Run a scene for many values of its keys, in worker processes.

    Parameters
    ----------
    scene : str or path
        Name of a scene that comes with the program, or path of a TOML file.
    vary : mapping
        Values by dotted key: a list, or text as the command takes it, "log:20 GPa:2 TPa:5".
    changes : mapping, optional
        As of `run`, but by name: workers know no objects.
    folder : path, optional
        Where the table is kept, and where an interrupted sweep goes on; without it, results/NAME-sweep.
    sample : int, optional
        Instead of the grid, so many runs by Latin hypercube; ranges are then "a:b" or "log:a:b".
    seed : int
        Of the samples.
    cluster : str, optional
        Address of a Dask scheduler.
    workers : int, optional
        Processes on this machine; without it, as many as it has cores.

    Returns
    -------
    Result
        Its history is the table, a row a run. A script that calls this needs `if __name__ == "__main__":`.

    Raises
    ------
    InputError
        As `run`, and for values that make no sweep.
    StoppedError
        Where it was interrupted, or the cluster was lost; what was finished is kept.

    Examples
    --------
    >>> import tailslap
    >>> found = tailslap.sweep("paper-table-3", {"corner.friction": [0.2, 0.47]})  # doctest: +SKIP
    >>> found.history["difference.v_gy"]  # doctest: +SKIP
    """
    from tailslap.campaign.definition import make_definition
    from tailslap.campaign.perform import perform
    from tailslap.files.load import sweep_result

    if cluster and workers:
        raise InputError("workers", workers, "a cluster has its own workers; leave out one of the two")
    varied = tuple(f"{key}={_values(values)}" for key, values in vary.items())
    definition = make_definition(os.fspath(scene), shown(named(changes or {})), varied, sample, seed)
    place = Path(folder) if folder is not None else Path("results") / f"{definition.scene}-sweep"
    perform(definition, place, cluster, workers)
    return sweep_result(place)


def _values(values: Values) -> str:
    return values if isinstance(values, str) else ",".join(map(str, values))


def _options(options: Mapping[str, Any]) -> list[str]:
    """Options as words of a command line."""
    return [word for name, value in options.items() for word in _words(name.replace("_", "-"), value)]


def _words(name: str, value: Any) -> list[str]:
    if isinstance(value, Mapping):
        value = shown(value)
    many = value if isinstance(value, list | tuple) else [value]
    if value is True:
        return [f"--{name}"]
    return [
        word for each in many if each is not None and each is not False for word in (f"--{name}", str(each))
    ]
