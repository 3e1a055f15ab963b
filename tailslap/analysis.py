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
    check_lines : callable
        plan -> what `tailslap check` says.
    run_report : callable
        (plan, folder, tolerance, pictures) -> the report of a run.
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
    check_lines: Callable[[Any], list[str]]
    run_report: Callable[[Any, Path, float | None, bool], Report]
    duration: Callable[[Any], float]
    columns: Callable[[Any], dict[str, Any]]
    column_kinds: Callable[[Scene], dict[str, type]]
    compared: Compared
