"""Functions of `import tailslap` that calculate one scene or compare results.

`sweep` stands in `tailslap.campaign`, `export` in `tailslap.exports`, `load` in `tailslap.result`, `paper` in
`tailslap.replication`, `scenes` and `new` in `tailslap.scene`. The commands of the same names call these functions.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

from postprocess.report import data_files
from postprocess.report.terminal import labelled_text, opened
from postprocess.units import SYSTEMS
from tailslap.arguments import UnitSystem, checked_arguments, picture_pixels
from tailslap.case.case import Case
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.force_band import ForceBand
from tailslap.case.of_arguments import (
    Changes,
    Scene,
    affordable_case,
    case_of_scene,
    folder_or_temporary,
)
from tailslap.errors import InputError, one_of
from tailslap.result import columns, load, result
from tailslap.result.columns import Columns
from tailslap.scene.vary import changes_of
from tailslap.storage.folder import result_folder
from tailslap.studies import find_study
from tailslap.studies.study import Study, checked_options, prepared


@checked_arguments
def run(
    scene: Scene,
    changes: Changes | None = None,
    *,
    tolerance: float | None = None,
    allow_large: bool = False,
    picture_size: str | tuple[int, int] | None = None,
    band: bool = True,
) -> result.Result:
    """Run a scene without writing files.

    A run solves the rigid body, makes the mesh, integrates the FE model, compares both and checks the result.

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
    band : bool
        Compute the band of the force over varied inputs, of up to 256 rigid vehicles.

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
    size, case = picture_pixels(picture_size), affordable_case(scene, changes, allow_large)
    report = case.report(case.run(tolerance), _force_band(case, band))
    partial = result.Result(
        "run",
        case.scene.name,
        {},
        histories={label: columns.history(report.histories[name]) for label, name in load.FILES.items()},
        fill=result.filled_by(
            lambda place, pictures, units: report.written(place, pictures, SYSTEMS[units], size)
        ),
        make_fields=report.fields,
        make_ends=report.fields_of_ends,
        make_charts=lambda: report.page(pictures=False).charts,
        changes=changes_of(case.source),
    )
    return result.of_run(data_files.plain(report.summary(True)), partial)


@checked_arguments
def rigid(
    scene: Scene, changes: Changes | None = None, *, units: UnitSystem = "si", band: bool = True
) -> result.Result:
    """Solve the rigid-body method, or a whole impact of the rigid vehicle.

    Mesh and FE libraries are not loaded.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    units : {"si", "us"}
        Units of the printed text, "si" or "us"; numbers are in SI.
    band : bool
        Compute the band of the force over varied inputs, of up to 256 rigid vehicles.

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
    from tailslap.case import force_chart

    case = case_of_scene(scene, changes)
    distribution = _force_band(case, band)
    headline, motion = case.headline(distribution), case.rigid_history()
    numbers = {**vars(headline), **case.rigid_numbers(), "force_band": distribution.numbers()}
    summary = data_files.plain(numbers)

    def fill(folder: Path, pictures: bool, units: str) -> None:
        data_files.write_summary(folder / "summary.json", summary)
        data_files.write_history(folder / "rigid.csv", motion)

    return result.Result(
        "rigid",
        summary["scene"],
        summary,
        tables=force_chart.force_tables(case),
        histories={result.RIGID: columns.history(motion)},
        text=f"{opened(headline.in_units(SYSTEMS[units]))}\n\n{labelled_text(case.rigid_text(units), 19)}",
        fill=fill,
        make_charts=lambda: (force_chart.force_chart(case), case.drawing()),
        changes=changes_of(case.source),
    )


def _force_band(case: Case, is_requested: bool) -> ForceBand:
    """Return the band of a case's force if requested."""
    from tailslap.campaign import band_samples

    return band_samples.force_band(case) if is_requested else ForceBand(refusal="not requested")


@checked_arguments
def check(
    scene: Scene, changes: Changes | None = None, *, allow_large: bool = False, units: UnitSystem = "si"
) -> result.Result:
    """Show the model and estimated cost of a run.

    Automatic choices are listed; nothing is run.

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
    from tailslap.case.run_report import LABEL

    case = case_of_scene(scene, changes)
    headline, lines = case.check_text(allow_large)
    labelled = [f"{label:<{LABEL}}{text}" for label, texts in lines.items() for text in texts]
    described = labelled_text([SYSTEMS[units].rendered(line) for line in labelled], LABEL)
    summary = data_files.plain({**vars(headline), "scene": case.scene.name, "valid": True, **lines})
    text = f"{opened(headline.in_units(SYSTEMS[units]))}\n\n{described}"
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
    """Run a scene with the modal model.

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
    from tailslap import modal_run

    case = affordable_case(scene, changes, allow_large)
    fe_plan = CornerCase(case.scene, case.source).plan()
    motion = modal_run.modal_run(fe_plan, modes, tolerance, steps)
    summary = data_files.plain(modal_run.modal_numbers(fe_plan, motion))
    return result.Result(
        "modal",
        summary["scene"],
        summary,
        passed=motion.passed,
        histories={"modal": columns.history(motion.history)},
        text=modal_run.modal_text(fe_plan, motion, units),
    )


@checked_arguments
def modes(
    scene: Scene, changes: Changes | None = None, *, count: int = 10, allow_large: bool = False
) -> result.Result:
    """Compute the free modes of the plate.

    They are those in its plane, of a train those of the hinged plates.

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

    report = modal_analysis.modes_report(affordable_case(scene, changes, allow_large, 6), count)
    return result.of_report("modes", report, tables={"Frequencies": report.terminal[0]})


@checked_arguments
def study(
    name: str,
    scene: Scene,
    changes: Changes | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
    allow_large: bool = False,
    force: bool = False,
    **options: object,
) -> result.Result:
    """Run a study of a scene.

    Parameters
    ----------
    name : str
        "cost", "flexibility", "stability", "tipping" or "uncertainty".
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
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
    >>> result = tailslap.study("uncertainty", "mash-tl4-sut", samples=1000)
    >>> result.summary["study"], result.passed
    ('uncertainty', None)
    """
    chosen = find_study(name)
    settings = checked_options(chosen, options)
    with folder_or_temporary(folder) as place:
        case = case_of_scene(scene, changes)
        _, origin = prepared(chosen, case, place, allow_large, settings)
        with result_folder(place, force=force, origin=origin) as unfinished:
            study_outcome = study_result(chosen, case, place, settings)
            if folder is not None and study_outcome.fill:
                study_outcome.fill(unfinished, True, "si")
        return study_outcome


def study_result(chosen: Study, case: Case, place: Path, options: Mapping[str, object]) -> result.Result:
    """Run a study of a case in a locked place.

    options: of the study, as `compute` takes them.
    """
    report = chosen.report(chosen.compute(case, place, **options))
    text = opened(report.page.headline, *report.terminal)
    return result.of_report(f"study {chosen.name}", report, text=text)


@checked_arguments
def compare(
    reference: result.Result | str | os.PathLike[str],
    *results: result.Result | str | os.PathLike[str],
    columns: Mapping[str, str] | str | None = None,
    only: Sequence[str] = (),
    author: str = "",
    force: bool = False,
) -> result.Result:
    """Compare histories with a reference.

    The result has differences, Sprague-Geers metrics, residuals, and the validation by NCHRP W179.

    Parameters
    ----------
    reference : Result or path
        Result of a run, its folder, a file with named columns: a history from ABAQUS, LS-DYNA or a test; or nodes of
        CalculiX (.dat), LS-DYNA (nodout), ABAQUS (field output report) or OpenRadioss (CSV of th_to_csv).
    *results : Result or path
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
    from tailslap.comparing import compare_report, validation

    items = (reference, *results)
    comparison = compare_report.compare_items(items, columns, only, force)
    page = validation.with_validation(compare_report.compare_report(comparison), comparison, author)
    histories = {item.label: Columns(item.columns, item.units) for item in comparison.items}
    tables = {"Metrics": page.tables["metrics.csv"]}
    inputs = chain(*(item.inputs if isinstance(item, result.Result) else (Path(item),) for item in items))
    return result.of_report("compare", page, tables=tables, histories=histories, inputs=tuple(inputs))


@checked_arguments
def confirm(
    scene: Scene,
    changes: Changes | None = None,
    *,
    program: str = "calculix",
    time_limit: float = 600.0,
    allow_large: bool = False,
) -> result.Result:
    """Confirm a scene by another solver.

    They are those of the other solver, of the rigid body, which is exact, and of this program's plate.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene; with a constrained corner, whose
        friction is omitted.
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
    case = confirm.without_friction(affordable_case(scene, changes, allow_large))
    solver_deck = deck.make_deck(case, program)
    with TemporaryDirectory(prefix="tailslap-") as folder:
        confirmation = confirm.run_confirmation(solver_deck, Path(folder), time_limit)
    histories = {name: columns.history(motion) for name, motion in confirmation.histories.items()}
    return result.of_report("confirm", confirm.confirm_report(confirmation), histories=histories)
