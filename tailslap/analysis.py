"""The two calculations, and what each offers to the commands: a scene with [contact] is a whole impact; any other is
the paper's three stages, with a constrained corner."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from postprocess.comparison.comparison import STRIKES, TAIL_SLAP, Compared
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source

if TYPE_CHECKING:
    import numpy as np

    from postprocess.report.report import Report


def later(name: str) -> Callable[..., Any]:
    """The function of this name, "module:function", whose module is imported when it is called."""
    module, _, function = name.partition(":")

    def called(*arguments: Any, **options: Any) -> Any:
        return getattr(importlib.import_module(module), function)(*arguments, **options)

    return called


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
        plan -> columns of the rigid motion by name, SI.
    check_lines : callable
        plan -> what `tailslap check` says.
    run : callable
        plan -> outcome of a run.
    run_to_tolerance : callable
        (plan, tolerance) -> outcome of a run on the cheapest mesh for this error.
    report : callable
        (outcome, folder, pictures, units of these) -> its report; fields and pictures go into the folder.
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
    rigid_history: Callable[[Any], dict[str, np.ndarray]]
    check_lines: Callable[[Any], list[str]]
    run: Callable[[Any], Any]
    run_to_tolerance: Callable[[Any, float], Any]
    report: Callable[..., Report]
    summary: Callable[[Any, bool], dict[str, Any]]
    histories: Callable[[Any], dict[str, dict[str, np.ndarray]]]
    duration: Callable[[Any], float]
    columns: Callable[[Any], dict[str, Any]]
    column_kinds: Callable[[Scene], dict[str, type]]
    compared: Compared

    def checked(self, plan: Any, allow_large: bool) -> list[str]:
        """What `tailslap check` says of a plan; of a large mesh an estimate. Raises InputError."""
        from tailslap.planning.affordable import demand_affordable, is_large
        from tailslap.report.check_text import estimate_part

        scene, duration = plan.scene, self.duration(plan)
        if not allow_large:
            demand_affordable(scene, duration)
        return estimate_part(scene, duration) if is_large(scene) else self.check_lines(plan)

    def outcome(self, plan: Any, tolerance: float | None) -> Any:
        """The outcome of a run, on the scene's own mesh or on the cheapest for a tolerance."""
        return self.run(plan) if tolerance is None else self.run_to_tolerance(plan, tolerance)


CORNER, WHOLE_IMPACT = "a constrained corner", "a whole impact"
"""Names of the two."""

SLIDING = Analysis(
    name=CORNER,
    make_plan=later("tailslap.planning.plan:make_plan"),
    rigid_numbers=later("tailslap.planning.rigid:rigid_answer"),
    rigid_lines=later("tailslap.planning.rigid:rigid_lines"),
    rigid_history=later("tailslap.planning.rigid:rigid_history"),
    check_lines=later("tailslap.report.check_text:check_lines"),
    run=later("tailslap.scene_run:run_scene"),
    run_to_tolerance=later("tailslap.tolerance:run_to_tolerance"),
    report=later("tailslap.report.run_report:report_in_folder"),
    summary=later("tailslap.report.summary:summary"),
    histories=lambda outcome: outcome.histories,
    duration=lambda plan: plan.motion.strike.t,
    columns=later("tailslap.sweeps.corner_columns:corner_columns"),
    column_kinds=later("tailslap.sweeps.corner_columns:corner_column_kinds"),
    compared=TAIL_SLAP,
)
IMPACT = Analysis(
    name=WHOLE_IMPACT,
    make_plan=later("tailslap.impact.plan:make_impact_plan"),
    rigid_numbers=later("tailslap.impact.rigid_text:rigid_numbers"),
    rigid_lines=later("tailslap.impact.rigid_text:rigid_lines"),
    rigid_history=later("tailslap.impact.rigid_text:rigid_history"),
    check_lines=later("tailslap.impact.check_text:check_lines"),
    run=later("tailslap.impact.run:run_impact"),
    run_to_tolerance=later("tailslap.tolerance.impacts:run_impact_to_tolerance"),
    report=later("tailslap.impact.report:impact_report"),
    summary=later("tailslap.impact.summary:impact_summary"),
    histories=later("tailslap.impact.summary:impact_histories"),
    duration=lambda plan: plan.motion.t_end,
    columns=later("tailslap.impact.columns:impact_columns"),
    column_kinds=later("tailslap.impact.columns:impact_column_kinds"),
    compared=STRIKES,
)


def analysis_of(scene: Scene) -> Analysis:
    """The calculation that the scene asks for; only its own modules are imported."""
    return SLIDING if scene.contact is None else IMPACT
