"""A scene run, solved as a rigid body, or checked."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from postprocess.files.histories import write_history
from postprocess.files.summary import plain, write_summary
from postprocess.report.terminal import labelled_text
from tailslap.api.result import FE, RIGID, Result, filled_by
from tailslap.api.run_tables import run_headline, run_tables
from tailslap.api.scenes import Changes, Scene, planned, planned_plate
from tailslap.case.case import Case
from tailslap.files.load import history


def run(
    scene: Scene,
    changes: Changes | None = None,
    *,
    tolerance: float | None = None,
    allow_large: bool = False,
) -> Result:
    """Run a scene: rigid solution, mesh, FE run, comparison, checks. Nothing is written.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene that comes with the program, path of a TOML file, or its tables as a dict.
    changes : mapping, optional
        Values by dotted key: numbers in SI, texts with their unit, None to take a key out. A friction law, a constraint
        or a material of your own stands in the place of its name: {"corner.reaction": law}.
    tolerance : float, optional
        Relative error [-] for which the cheapest mesh and constraint are picked.
    allow_large : bool
        Also where it takes more memory, time or threads than there are.

    Returns
    -------
    Result
        `summary` is what `summary.json` of the command holds, to the bit but for the times it took.

    Raises
    ------
    InputError
        For a scene, a key or a value that is wrong; it names the key, what was given and what is allowed.

    Examples
    --------
    >>> import tailslap
    >>> result = tailslap.run("mash-tl4-sut", {"plate.youngs_modulus": "2 TPa"})
    >>> result.passed, round(result.summary["fe"]["t"], 4)
    (True, 0.3867)
    """
    case = planned_plate(scene, changes, allow_large)
    return run_result(case, case.run(tolerance))


def run_result(case: Case, outcome: Any) -> Result:
    """The record of a finished run."""
    summary = plain(case.summary(outcome, True))
    histories = case.histories(outcome)

    def fields() -> Any:
        from tailslap.report.fields import field_series

        return field_series(outcome.fe_plan.model, outcome.run.snapshots)

    def ends() -> Any:
        from tailslap.report.fields import series_of_ends

        return series_of_ends(outcome)

    return Result(
        "run",
        summary["scene"],
        summary,
        run_headline(summary),
        summary["passed"],
        run_tables(summary),
        {FE: history(histories["history.csv"]), RIGID: history(histories["rigid.csv"])},
        fill=filled_by(partial(case.report, outcome)),
        make_fields=None if outcome.run.snapshots is None else fields,
        make_ends=ends if getattr(outcome.run, "strike", None) is not None else None,
    )


def rigid(scene: Scene, changes: Changes | None = None) -> Result:
    """Solve the rigid-body method, or the rigid vehicle's whole impact, alone; loads no mesh or FE library.

    Parameters
    ----------
    scene : str, path or mapping
        As of `run`.
    changes : mapping, optional
        As of `run`.

    Returns
    -------
    Result
        `summary` is what `tailslap rigid --json` prints; the history is the motion to its end.

    Raises
    ------
    InputError
        As `run`.

    Examples
    --------
    >>> import tailslap
    >>> round(tailslap.rigid("mash-tl4-sut").summary["stage3"]["peak_force"] / 1e3)
    653
    """
    case = planned(scene, changes)
    summary, columns = plain(case.rigid_numbers()), case.rigid_history()

    def fill(folder: Path, pictures: bool) -> None:
        write_summary(folder / "summary.json", summary)
        write_history(folder / "rigid.csv", columns)

    return Result(
        "rigid",
        summary["scene"],
        summary,
        histories={RIGID: history(columns)},
        text=labelled_text(case.rigid_text(), 19),
        fill=fill,
    )


def check(scene: Scene, changes: Changes | None = None, *, allow_large: bool = False) -> Result:
    """Say what a run would use, choose, leave out and cost; runs nothing.

    Parameters
    ----------
    scene : str, path or mapping
        As of `run`.
    changes : mapping, optional
        As of `run`.
    allow_large : bool
        As of `run`.

    Returns
    -------
    Result
        Printed, it says what `tailslap check` does; `summary` is what `tailslap check --json` prints.

    Raises
    ------
    InputError
        As `run`.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.check("paper-table-3").summary["plate"][0][:23]
    '120 elements, 147 nodes'
    """
    from tailslap.report.check_text import LABEL, as_numbers

    case = planned(scene, changes)
    name, lines = case.scene.name, case.check_text(allow_large)
    return Result("check", name, as_numbers(name, lines), text=labelled_text(lines, LABEL))
