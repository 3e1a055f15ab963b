"""Functions `run`, `rigid`, `check` and `study` of `import tailslap`.

The others are in the modules of their subjects, see `tailslap/__init__.py`. The commands of the same names call these
functions.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from postprocess.report import data_files
from postprocess.report.terminal import concluded, labelled_text
from postprocess.units import SYSTEMS
from tailslap.arguments import UnitSystem, checked_arguments, picture_pixels
from tailslap.case.case import Case
from tailslap.case.force_band import ForceBand
from tailslap.case.of_arguments import Changes, Scene, affordable_case, case_of_scene, folder_or_temporary
from tailslap.result import columns, load, result
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
    histories = report.histories
    partial = result.Result(
        "run",
        case.scene.name,
        {},
        histories={
            label: columns.history(histories[name]) for label, name in load.FILES.items() if name in histories
        },
        fill=result.filled_by(
            lambda place, pictures, units: report.written(place, pictures, SYSTEMS[units], size)
        ),
        make_fields=report.fields,
        make_ends=report.fields_of_ends,
        make_charts=lambda: report.page(pictures=False).charts,
        changes=case.changes,
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
        text=f"{labelled_text(case.rigid_text(units), 19)}\n\n{concluded(headline.in_units(SYSTEMS[units]))}",
        fill=fill,
        make_charts=lambda: (force_chart.force_chart(case), case.drawing()),
        changes=case.changes,
    )


def _force_band(case: Case, is_requested: bool) -> ForceBand:
    """Return a case's force band if requested."""
    from tailslap.validation.calibration import calibrated_band

    return calibrated_band(case) if is_requested else ForceBand(refusal="not requested")


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
    text = f"{described}\n\n{concluded(headline.in_units(SYSTEMS[units]))}"
    return result.Result("check", case.scene.name, summary, text=text)


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
        "cost", "flexibility", "parapet", "stability", "tipping" or "uncertainty".
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
    from tailslap.campaign import records

    chosen = find_study(name)
    settings = checked_options(chosen, options)
    with folder_or_temporary(folder) as place:
        case = case_of_scene(scene, changes)
        _, origin = prepared(chosen, case, place, allow_large, settings)
        with records.kept(place), result_folder(place, force=force, origin=origin) as unfinished:
            study_outcome = study_result(chosen, case, place, settings)
            if folder is not None and study_outcome.fill:
                study_outcome.fill(unfinished, True, "si")
        return study_outcome


def study_result(chosen: Study, case: Case, place: Path, options: Mapping[str, object]) -> result.Result:
    """Run a study of a case in a locked place.

    options: of the study, as `compute` takes them.
    """
    report = chosen.report(chosen.compute(case, place, **options))
    text = concluded(report.page.headline, *report.terminal)
    return result.of_report(f"study {chosen.name}", report, text=text, changes=case.changes)
