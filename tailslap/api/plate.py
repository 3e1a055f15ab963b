"""The plate alone: its natural frequencies, and a run with a few of its modes."""

from __future__ import annotations

from typing import Any

from postprocess.files.summary import plain
from tailslap.api.result import Result, filled_by
from tailslap.api.scenes import Changes, Scene, planned_plate
from tailslap.files.load import history

MODAL = "modal"


def modal(
    scene: Scene,
    changes: Changes | None = None,
    *,
    modes: int = 4,
    steps: int = 100,
    tolerance: float = 1e-5,
    allow_large: bool = False,
) -> Result:
    """Run a scene with a few modes of the plate.

    Parameters
    ----------
    scene : str, path or mapping
        As of `run`; with a constrained corner.
    changes : mapping, optional
        As of `run`.
    modes : int
        Elastic modes to keep, the lowest.
    steps : int
        Time steps to the tail-slap.
    tolerance : float
        Relative error allowed [-].
    allow_large : bool
        As of `run`.

    Returns
    -------
    Result
        `summary` is what `tailslap modal --json` prints.

    Raises
    ------
    InputError
        As `run`, and for what the modal model does not have.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.modal("paper-table-3", modes=2).passed
    True
    """
    from tailslap.modal_analysis.run import modal_numbers, modal_run, modal_text

    fe_plan = _fe_plan(scene, changes, allow_large)
    found = modal_run(fe_plan, modes, tolerance, steps)
    summary = plain(modal_numbers(fe_plan, found))
    return Result(
        "modal",
        summary["scene"],
        summary,
        passed=found.passed,
        histories={MODAL: history(dict(found.history))},
        text=modal_text(fe_plan, found),
    )


def modes(
    scene: Scene, changes: Changes | None = None, *, count: int = 10, allow_large: bool = False
) -> Result:
    """Natural frequencies and shapes of the free plate in its plane.

    Parameters
    ----------
    scene : str, path or mapping
        As of `run`.
    changes : mapping, optional
        As of `run`.
    count : int
        Elastic modes, the lowest.
    allow_large : bool
        As of `run`.

    Returns
    -------
    Result
        `summary["modes"]` has a record a mode: frequency [Hz], kind, and beam theory's.

    Raises
    ------
    InputError
        As `run`, and for a number of modes that the mesh does not have.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.modes("paper-table-3", count=1).summary["modes"][0]["kind"]
    'bending'
    """
    from tailslap.modal_analysis.modes import find_modes, headline, modes_report, modes_table
    from tailslap.modal_analysis.modes import summary as summary_of

    found = find_modes(_fe_plan(scene, changes, allow_large), count)
    summary = plain(summary_of(found))
    tables, fill = (
        {"Frequencies": modes_table(found)},
        filled_by(lambda folder, pictures: modes_report(found)),
    )
    return Result("modes", summary["scene"], summary, headline(found), tables=tables, fill=fill)


def _fe_plan(scene: Scene, changes: Changes | None, allow_large: bool) -> Any:
    from tailslap.case.corner.case import CornerCase

    case = planned_plate(scene, changes, allow_large)
    return CornerCase(case.scene, case.source).plan()
