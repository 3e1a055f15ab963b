"""The functions of `import tailslap`; the commands of the same names call them.

`load` stands in `tailslap.files`, `export` in `tailslap.exports`.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.report import data_files
from postprocess.report.command_report import write_report
from postprocess.report.terminal import labelled_text, opened
from postprocess.units import SYSTEMS
from tailslap import result
from tailslap.arguments import UnitSystem, checked_arguments, picture_pixels
from tailslap.case import case_of, cost
from tailslap.case.case import Case
from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError, Interrupted, one_of
from tailslap.files import load
from tailslap.files.folder import result_folder
from tailslap.scene import read
from tailslap.scene.objects import added_names, named
from tailslap.scene.vary import Source, changes_of, parse_changes, shown, vary
from tailslap.studies import find_study
from tailslap.studies.study import Study, checked_options, prepared

if TYPE_CHECKING:
    from tailslap.campaign.definition import Definition

Scene = str | os.PathLike[str] | Mapping[str, Any] | Case
"""Name of a scene of the program, path of a TOML file, tables of a scene, or a case."""

Changes = Mapping[str, Any] | Sequence[str]
"""Values by dotted key: numbers in SI, texts with a unit, objects, None to remove the key; or texts KEY=VALUE."""

Values = str | Sequence[Any]
"""Values of a varied key: a list, or a text as on the command line, "log:20 GPa:2 TPa:5"."""

IN_THIS_PROCESS = 3
"""Runs of a sweep up to which no processes are started: that would take longer than the runs."""


@checked_arguments
def run(
    scene: Scene,
    changes: Changes | None = None,
    *,
    tolerance: float | None = None,
    allow_large: bool = False,
    picture_size: str | tuple[int, int] | None = None,
) -> result.Result:
    """Run a scene: rigid solution, mesh, FE run, comparison, checks. Nothing is written.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    changes : mapping or sequence of str, optional
        Values by dotted key, or tables of them: numbers in SI, texts with a unit, None to remove a key, or an object (a
        friction law, constraint or material) in place of its name: {"corner.reaction": law}. Alternatively texts
        KEY=VALUE: "plate.thickness=20mm".
    tolerance : float, optional
        Relative error [-] below which the mesh is refined.
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.
    picture_size : tuple of int or str, optional
        Width and height [pixels] of the pictures written by `save`, (3200, 1400) or "3200x1400"; text and lines are
        scaled.

    Returns
    -------
    Result
        `summary` contains the numbers of `summary.json`, bitwise equal except for run times.

    Raises
    ------
    InputError
        For an invalid scene, key or value, with key, given value and allowed values.

    Examples
    --------
    >>> import tailslap
    >>> result = tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa"})
    >>> result.passed, round(result.summary["fe"]["t"], 4)
    (True, 0.3867)
    """
    from tailslap.case import report

    size, case = picture_pixels(picture_size), _affordable(scene, changes, allow_large)
    outcome = case.run(tolerance)
    found, columns = outcome.run, case.histories(outcome)
    return result.of_run(
        data_files.plain(case.summary(outcome, True)),
        {label: load.history(columns[name]) for label, name in load.FILES.items()},
        result.filled_by(
            lambda place, pictures, units: case.report(outcome, place, pictures, SYSTEMS[units], size)
        ),
        None
        if found.snapshots is None
        else lambda: report.field_series(outcome.fe_plan.model, found.snapshots),
        None if getattr(found, "strike", None) is None else lambda: report.series_of_ends(outcome),
        changes=changes_of(case.source),
    )


@checked_arguments
def rigid(scene: Scene, changes: Changes | None = None, *, units: UnitSystem = "si") -> result.Result:
    """Solve the rigid-body method, or the whole impact of the rigid vehicle, without loading mesh or FE libraries.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    units : {"si", "us"}
        Units of the printed text, "si" or "us"; numbers are in SI.

    Returns
    -------
    Result
        `summary` contains the numbers of `tailslap rigid --json`, `history` the motion; `charts` has the force over
        time, "force", beside the design forces, and the "set-up".

    Raises
    ------
    InputError
        For an invalid scene, key or value.

    Examples
    --------
    >>> import tailslap
    >>> round(tailslap.rigid("mash-tl4-sut").summary["stage3"]["peak_force"] / 1e3)
    653
    """
    from tailslap.case import force

    case = _case(scene, changes)
    headline, columns = case.headline(), case.rigid_history()
    summary = data_files.plain({**vars(headline), **case.rigid_numbers()})

    def fill(folder: Path, pictures: bool, units: str) -> None:
        data_files.write_summary(folder / "summary.json", summary)
        data_files.write_history(folder / "rigid.csv", columns)

    return result.Result(
        "rigid",
        summary["scene"],
        summary,
        tables=force.force_tables(case),
        histories={result.RIGID: load.history(columns)},
        text=f"{opened(headline.in_units(SYSTEMS[units]))}\n\n{labelled_text(case.rigid_text(units), 19)}",
        fill=fill,
        make_charts=lambda: (force.force_chart(case), case.drawing()),
        changes=changes_of(case.source),
    )


@checked_arguments
def check(
    scene: Scene, changes: Changes | None = None, *, allow_large: bool = False, units: UnitSystem = "si"
) -> result.Result:
    """Show the model, automatic choices and estimated cost of a run without running it.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.
    units : {"si", "us"}
        Units of the printed text, "si" or "us"; numbers are in SI.

    Returns
    -------
    Result
        `summary` contains the numbers of `tailslap check --json`; `print` shows the text of `tailslap check`.

    Raises
    ------
    InputError
        For an invalid scene, key or value.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.check("paper-table-3").summary["plate"][0][:23]
    '120 elements, 147 nodes'
    """
    from tailslap.case.case import LABEL
    from tailslap.case.report import as_numbers

    case = _case(scene, changes)
    headline, lines = case.check_text(allow_large)
    found = labelled_text([SYSTEMS[units].rendered(line) for line in lines], LABEL)
    summary = data_files.plain(
        {**vars(headline), "scene": case.scene.name, "valid": True, **as_numbers(lines)}
    )
    text = f"{opened(headline.in_units(SYSTEMS[units]))}\n\n{found}"
    return result.Result("check", case.scene.name, summary, text=text)


@checked_arguments
def modal(
    scene: Scene,
    changes: Changes | None = None,
    *,
    modes: int = 4,
    steps: int = 100,
    tolerance: float = 1e-5,
    allow_large: bool = False,
    units: UnitSystem = "si",
) -> result.Result:
    """Run a scene with the modal model of the plate.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene; with a constrained corner.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    modes : int
        Number of elastic modes, lowest first.
    steps : int
        Number of time steps to the tail-slap.
    tolerance : float
        Largest allowed relative error [-].
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.
    units : {"si", "us"}
        Units of the printed text, "si" or "us"; numbers are in SI.

    Returns
    -------
    Result
        `summary` contains the numbers of `tailslap modal --json`.

    Raises
    ------
    InputError
        For an invalid scene, key or value, and for features that the modal model does not support.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.modal("paper-table-3", modes=2).passed
    True
    """
    from tailslap import modal_analysis

    fe_plan = _corner_plan(scene, changes, allow_large)
    found = modal_analysis.modal_run(fe_plan, modes, tolerance, steps)
    summary = data_files.plain(modal_analysis.modal_numbers(fe_plan, found))
    return result.Result(
        "modal",
        summary["scene"],
        summary,
        passed=found.passed,
        histories={"modal": load.history(found.history)},
        text=modal_analysis.modal_text(fe_plan, found, units),
    )


@checked_arguments
def modes(
    scene: Scene, changes: Changes | None = None, *, count: int = 10, allow_large: bool = False
) -> result.Result:
    """Compute natural frequencies and mode shapes of the free plate, or of the hinged plates of a train, in its plane.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    count : int
        Number of elastic modes, lowest first.
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.

    Returns
    -------
    Result
        `summary["modes"]` contains a record per mode: frequency [Hz], its relative error [-], kind, frequency of
        beam theory.

    Raises
    ------
    InputError
        For an invalid scene, key or value, and for more modes than the mesh allows.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.modes("paper-table-3", count=1).summary["modes"][0]["kind"]
    'bending'
    """
    from tailslap import modal_analysis

    report = modal_analysis.modes_report(_affordable(scene, changes, allow_large, 6), count)
    return result.of_report("modes", report, tables={"Frequencies": report.terminal[0]})


@checked_arguments
def study(
    name: str,
    scene: str | os.PathLike[str],
    changes: Changes | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
    allow_large: bool = False,
    force: bool = False,
    **options: Any,
) -> result.Result:
    """Run a study of a scene.

    Parameters
    ----------
    name : str
        "cost", "flexibility", "stability", "tipping" or "uncertainty".
    scene : str or path
        Name of a scene of the program, or path of a TOML file.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    folder : path, optional
        Result folder; an interrupted study resumes from the journal beside it. By default nothing is written.
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.
    force : bool
        Replace the result of another command or scene in this folder.
    **options : object
        Options of the study, named as on the command line with "_" for "-": samples=1000, range={"impact.friction":
        "0.2:0.5"}; repeatable options take a list or a dict.

    Returns
    -------
    Result
        `summary` contains the numbers of `summary.json`.

    Raises
    ------
    InputError
        For an invalid study, option, scene, key or value.

    Examples
    --------
    >>> import tailslap
    >>> found = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000)
    >>> found.summary["study"], found.passed
    ('uncertainty', None)
    """
    chosen = find_study(name)
    own = checked_options(chosen, options)
    with _folder_or_none(folder) as place:
        case, _, origin = prepared(chosen, os.fspath(scene), _texts(changes), place, allow_large, own)
        _warn(case.source, not isinstance(changes, Mapping))
        with result_folder(place, force=force, origin=origin) as unfinished:
            found = study_result(chosen, case, place, own)
            if folder is not None and found.fill:
                found.fill(unfinished, True, "si")
        return found


def study_result(chosen: Study, case: Case, place: Path, options: Mapping[str, Any]) -> result.Result:
    """Run a study of a case, whose place is locked; options: its own, as `compute` takes them."""
    report = chosen.report(chosen.compute(case, place, **options))
    text = opened(report.page.headline, *report.terminal)
    return result.of_report(f"study {chosen.name}", report, text=text)


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
    >>> found = tailslap.sweep("paper-table-3", {"corner.friction": [0.2, 0.47]})
    >>> [f"{v_gy:.2f}" for v_gy in found.history["fe.v_gy"]]
    ['-3.28', '-3.28']
    """
    from tailslap.campaign import definition

    typed = not isinstance(vary, Mapping)
    if isinstance(vary, Mapping):
        texts = {k: v if isinstance(v, str) else ",".join(map(str, v)) for k, v in vary.items()}
        vary = [f"{key}={text}" for key, text in texts.items()]
    asked = definition.make_definition(os.fspath(scene), _texts(changes), tuple(vary), sample, seed)
    _warn(definition.varied_source(asked) if typed else asked.source, not isinstance(changes, Mapping))
    own = _own_names(asked)
    if own and (workers or cluster):
        key, value = "--workers" if workers else "--cluster", workers or cluster
        raise InputError(key, value, f"{', '.join(own)} is registered in this process only; use workers=0")
    if workers is None and not cluster and (own or asked.runs <= IN_THIS_PROCESS):
        workers = 0
    with _folder_or_none(folder) as place:
        return sweep_result(asked, place, cluster, workers, units, force, stays=folder is not None)


def sweep_result(
    asked: Definition,
    place: Path,
    cluster: str | None,
    workers: int | None,
    units: str,
    force: bool,
    stays: bool = True,
) -> result.Result:
    """Make the runs of a sweep in a folder, which may go again once the result is there. Raises StoppedError."""
    from tailslap.campaign import definition, perform, report

    if cluster and workers:
        raise InputError(
            "--workers", workers, "--cluster and --workers exclude each other; remove one of the two"
        )
    try:
        done = perform.perform(asked, place, cluster, workers, units=units, force=force)
    except perform.StoppedError as stopped:
        raise (
            stopped if stays else perform.StoppedError(stopped.why, None, asked.runs, stopped.status)
        ) from None
    made, table = done.report, (place / definition.TABLE).read_bytes()
    assert made is not None
    columns = {"table": load.table(load.read_columns(place / definition.TABLE))}

    def fill(folder: Path, pictures: bool, units: str) -> None:
        (folder / definition.TABLE).write_bytes(table)
        write_report(made, folder)

    text, passed = report.sweep_text(done, place if stays else None), done.failures == 0
    return result.of_report("sweep", made, passed=passed, histories=columns, text=text, fill=fill)


def _own_names(asked: Definition) -> list[str]:
    """Names in a sweep of objects that this process alone has registered."""
    names = []
    for key, own in added_names().items():
        table, _, name = key.partition(".")
        used = {asked.source.given.get(table, {}).get(name)}
        used |= {value for item in asked.variations if item.key == key for value in item.settings}
        names += [f"{key} = {value}" for value in used & own]
    return names


@contextmanager
def _folder_or_none(folder: str | os.PathLike[str] | None) -> Iterator[Path]:
    """Yield the folder of a result; without one, one that is removed at the end."""
    if folder is not None:
        yield Path(folder)
        return
    with TemporaryDirectory(prefix="tailslap-") as temporary:
        try:
            yield Path(temporary) / "result"
        except Interrupted:
            raise KeyboardInterrupt("interrupted; without a folder no rows are saved") from None


@checked_arguments
def compare(
    reference: result.Result | str | os.PathLike[str],
    *others: result.Result | str | os.PathLike[str],
    columns: Mapping[str, str] | str | None = None,
    only: Sequence[str] = (),
    author: str = "",
    force: bool = False,
) -> result.Result:
    """Compare histories with a reference: differences, Sprague-Geers metrics, residuals, validation by NCHRP W179.

    Parameters
    ----------
    reference : Result or path
        Result of a run, its folder, a file with named columns: a history from ABAQUS, LS-DYNA or a test; or nodes of
        CalculiX (.dat), LS-DYNA (nodout), ABAQUS (field output report) or OpenRadioss (CSV of th_to_csv).
    *others : Result or path
        Results, folders or files that are compared with the reference.
    columns : mapping or str, optional
        Column names of the files by names of this program: {"time": "t", "v_gy": "-VY [mph]"}; a minus reverses the
        sign, a unit in brackets holds for a file without one. Default: SI.
    only : sequence of str
        Columns to compare. Default: the main columns in common.
    author : str
        Name on the page `validation.html`. Default: a blank to fill in.
    force : bool
        Read the intact files of damaged or modified results.

    Returns
    -------
    Result
        `summary["compared"]` contains the metrics by label and column, `summary["notes"]` what is missing or hardly
        shows in them; `passed` is True if all are within the limits of NCHRP W179 over half of the reference's time.

    Raises
    ------
    InputError
        For unreadable or damaged results, cells without a number, units of time that differ, or no common column.

    Examples
    --------
    >>> import tailslap
    >>> soft = tailslap.run("paper-table-3", {"plate.youngs_modulus": "20 GPa"})
    >>> tailslap.compare(tailslap.run("paper-table-3"), soft).passed
    True
    """
    from tailslap.comparing import report, validation

    items = (reference, *others)
    found = report.compare_items(items, columns, only, force)
    made = validation.with_validation(report.compare_report(found), found, author)
    histories = {item.label: result.Columns(item.columns, item.units) for item in found.items}
    tables = {"Metrics": made.tables["metrics.csv"]}
    inputs = [item.inputs if isinstance(item, result.Result) else (Path(item),) for item in items]
    return result.of_report("compare", made, tables=tables, histories=histories, inputs=tuple(chain(*inputs)))


@checked_arguments
def confirm(
    scene: Scene,
    changes: Changes | None = None,
    *,
    program: str = "calculix",
    time_limit: float = 600.0,
    allow_large: bool = False,
) -> result.Result:
    """Run a scene in another solver and compare it with the exact rigid-body motion and this program's plate.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene; with a constrained corner, without
        friction.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    program : str
        "calculix", which must be installed as `ccx`.
    time_limit : float
        Longest time of the other solver [s].
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.

    Returns
    -------
    Result
        `summary["difference"]` contains the relative differences from the exact motion at the tail-slap; `passed` is
        True if none exceeds `summary["limit"]`.

    Raises
    ------
    InputError
        For an invalid scene or key, a scene that the solver cannot have, and a solver that is not installed.
    OSError
        For a solver that fails or exceeds the time limit, with its last lines.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.confirm("paper-table-3", {"corner.reaction": "none"}).passed  # doctest: +SKIP
    True
    """
    from tailslap.exports import SOLVERS, confirm, deck

    if program not in SOLVERS:
        raise InputError("--with", program, one_of(program, SOLVERS))
    made = deck.make_deck(_affordable(scene, changes, allow_large), program)
    with TemporaryDirectory(prefix="tailslap-") as folder:
        found = confirm.run_confirmation(made, Path(folder), time_limit)
    report = confirm.confirm_report(found)
    histories = {name: load.history(columns) for name, columns in found.histories.items()}
    return result.of_report("confirm", report, histories=histories)


def _case(scene: Scene, changes: Changes | None, level: int = 4) -> Case:
    """The case of a scene with these changes; level: of the caller's line on the stack. Raises InputError."""
    if isinstance(scene, Case) and not changes:
        return scene
    if isinstance(scene, Case):
        source = scene.source
    elif isinstance(scene, Mapping):
        source = Source(given=_plain(scene))
    else:
        source = read.read_source(os.fspath(scene))
    typed = not isinstance(changes, Mapping)
    values = parse_changes(changes or (), source.given) if typed else named(_plain(changes))
    varied, source = vary(source, values)
    _warn(source, typed, level + 1)
    return case_of(varied, source)


def _warn(source: Source, typed: bool, level: int = 4) -> None:
    """Warn of what is remarkable in a scene; typed: by texts; level: of the caller's line on the stack."""
    for remark in read.remarks(source, typed):
        warnings.warn(remark, stacklevel=level)


def _affordable(scene: Scene, changes: Changes | None, allow_large: bool, level: int = 5) -> Case:
    """The case of a scene with a plate that this machine can carry; level: as of `_case`. Raises InputError."""
    case = _case(scene, changes, level)
    cost.demand_run(case.scene, case.duration, allow_large)
    return case


def _corner_plan(scene: Scene, changes: Changes | None, allow_large: bool) -> Any:
    """The plan of a constrained corner. Raises InputError for a whole impact."""
    case = _affordable(scene, changes, allow_large, 6)
    return CornerCase(case.scene, case.source).plan()


def _texts(changes: Changes | None) -> tuple[str, ...]:
    """Changes as texts, for worker processes."""
    return shown(named(changes)) if isinstance(changes, Mapping) else tuple(changes or ())


def _plain(value: Any) -> Any:
    """Value with numbers and arrays of NumPy converted to those of Python."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return value
