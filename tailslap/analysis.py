"""What a calculation that a scene may ask for offers to the commands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import Compared
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source

if TYPE_CHECKING:
    import numpy as np

    from postprocess.report.report import Report


CORNER, WHOLE_IMPACT = "a constrained corner", "a whole impact"
"""Names of the two."""


@dataclass(frozen=True)
class Analysis:
    """A calculation.

    Attributes
    ----------
    name : str
        What it is, for messages.
    make_plan : callable
        (scene, source) -> plan; the rigid vehicle is solved in it, or when it is asked for.
    rigid_numbers, rigid_lines : callable
        plan -> what `tailslap rigid` says, as numbers, and (plan, units) -> as lines.
    rigid_history : callable
        (plan, rows) -> columns of the rigid motion by name, SI.
    check_lines : callable
        plan -> what `tailslap check` says.
    run : callable
        (plan, tolerance) -> outcome of a run.
    report : callable
        (outcome, folder, pictures) -> its report; pictures are drawn into the folder.
    summary : callable
        (outcome, pictures) -> its numbers, SI: what `summary.json` holds.
    histories : callable
        outcome -> the histories of FE and rigid vehicle, columns by the names of their files.
    duration : callable
        plan -> how long the motion lasts that a run integrates [s].
    columns : callable
        plan -> columns of a run for the table of a sweep.
    column_kinds : callable
        scene -> columns that this table has whatever its rows, the checks' beside, and the type of their values; raises
        InputError for a scene that cannot be swept.
    compared : Compared
        What its pictures and its page show of FE and rigid vehicle.
    """

    name: str
    make_plan: Callable[[Scene, Source], Any]
    rigid_numbers: Callable[[Any], dict[str, Any]]
    rigid_lines: Callable[[Any, str], list[str]]
    rigid_history: Callable[[Any, int], dict[str, np.ndarray]]
    check_lines: Callable[[Any], list[str]]
    run: Callable[[Any, float | None], Any]
    report: Callable[[Any, Path, bool], Report]
    summary: Callable[[Any, bool], dict[str, Any]]
    histories: Callable[[Any], dict[str, dict[str, np.ndarray]]]
    duration: Callable[[Any], float]
    columns: Callable[[Any], dict[str, Any]]
    column_kinds: Callable[[Scene], dict[str, type]]
    compared: Compared
