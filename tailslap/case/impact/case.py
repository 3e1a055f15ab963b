"""Whole impact of the rigid vehicle and of the FE plate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from postprocess.signals.filters import LABELS
from tailslap.case.case import NO_BAND, within_tolerance
from tailslap.case.check import check_columns
from tailslap.case.force_band import ForceBand
from tailslap.case.impact import answers, rigid
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    from tailslap.case.impact.plan import ImpactPlan
    from tailslap.case.impact.report import ImpactReport
    from tailslap.case.impact.run import ImpactOutcome


VALUES = ("start", "duration", "peak_force", "mean_50ms", "impulse")
SPACE = ("outcome", "largest_roll", "largest_pitch", "lowest_wall")
SPACE_FORCE = ("mean_50ms", "height", "length")
HINGE = ("peak_force", "mean_50ms", "largest_angle")
SPENT = {"cost.steps": int, "cost.time_step": float}


@dataclass(frozen=True)
class ImpactCase(rigid.RigidImpact):
    """Calculation of a scene with [contact], see `Case`."""

    least_tolerance = 5e-3  # half a row has half this effect on a duration

    def plan(self, more_damping: float = 1.0) -> ImpactPlan:
        """Choose omitted values, mesh and assemble.

        No damping is chosen.
        """
        from tailslap.case.impact.plan import make_impact_plan

        return make_impact_plan(self)

    def check_lines(self, fe_plan: ImpactPlan | None) -> dict[str, list[str]]:
        """Return the texts of `tailslap check` by label."""
        from tailslap.case.impact import report

        return report.check_lines(self, fe_plan)

    def run(self, tolerance: float | None = None) -> ImpactOutcome:
        """Run the plate, compare it with the rigid vehicle, and check it.

        tolerance: see `within_tolerance`. Raises InputError.
        """
        return within_tolerance(self, _run, tolerance)

    def report(self, outcome: ImpactOutcome, band: ForceBand = NO_BAND) -> ImpactReport:
        """Return the report of a run.

        band: of the force over varied inputs.
        """
        from tailslap.case.impact.report import ImpactReport

        return ImpactReport(outcome, band)

    @staticmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Return the columns of a sweep's table with their types.

        These exist in any row.
        """
        models = ("rigid",) if scene.plate is None else ("rigid", "fe")
        kinds: dict[str, type] = {}
        strikes = range(1, 1 + answers.counted(len(scene.units)))
        for model in models:
            kinds |= {f"{model}.strikes": int, f"{model}.strikes_cut": int}
            for k in strikes:
                kinds[f"{model}.strike_{k}.corner"] = str
                kinds |= {f"{model}.strike_{k}.{name}": float for name in VALUES}
            kinds |= {f"{model}.peaks.{name}": float for name in LABELS}
            kinds |= {f"{model}.end.{name}": float for name in answers.END}
            for k in range(1, len(scene.units)):
                kinds |= {f"{model}.hinge_{k}.{name}": float for name in HINGE}
        if scene.body:
            kinds |= {f"space.{name}": str if name == "outcome" else float for name in SPACE}
            kinds |= {f"space.{name}": float for name in SPACE_FORCE}
        if not scene.trailer:
            kinds["inertial.mean_50ms"] = float
        if scene.plate is None:
            return kinds
        names = [f"difference.strike_{k}.{name}" for k in strikes for name in answers.COMPARED]
        return {**kinds, **dict.fromkeys([*names, "numerical_error"], float), **SPENT}

    def row(self, outcome: ImpactOutcome | None) -> dict[str, Any]:
        """Return a run as a row of that table, SI.

        Without an outcome it is that of the rigid vehicle alone.
        """
        from tailslap.case.run_report import run_cost

        if outcome is None:
            row = {"status": "passed", "reason": "", **_answer_columns("rigid", self.answer)}
            return row | self._further_columns()
        return {
            **check_columns(outcome.checks),
            **_answer_columns("rigid", outcome.rigid),
            **_answer_columns("fe", outcome.fe),
            **self._further_columns(),
            **{f"difference.{name}": value for name, value in outcome.difference.items()},
            "numerical_error": outcome.stated_error,
            **{f"cost.{name}": value for name, value in run_cost(outcome).items()},
        }

    def _further_columns(self) -> dict[str, object]:
        """Return columns in space and of the inertial estimate, if any."""
        columns = dict[str, object]()
        if self.space:
            numbers = self.space.numbers()
            columns = {f"space.{name}": numbers[name] for name in SPACE}
            columns |= {f"space.{name}": numbers["force"][name] for name in SPACE_FORCE}
        return columns | ({"inertial.mean_50ms": self.inertial["mean_50ms"]} if self.inertial else {})


def _run(case: ImpactCase) -> ImpactOutcome:
    """Run the plate with error and checks."""
    from tailslap.case.impact import checks, run

    outcome = run.assessed(case) if case.scene.verify.companion else run.attempt(case)
    return replace(outcome, checks=checks.impact_checks(outcome))


def _answer_columns(model: str, answer: answers.ImpactAnswer) -> dict[str, object]:
    """Return the columns of one model with its compared strikes.

    Columns of strikes that do not occur are missing.
    """
    row: dict[str, object] = {
        f"{model}.strikes": len(answer.strikes),
        f"{model}.strikes_cut": len(answer.cut),
    }
    for k, strike in enumerate(answer.strikes[: answer.counted], 1):
        row[f"{model}.strike_{k}.corner"] = strike.corner
        values = {"mean_50ms": answers.mean_peak(answer, strike), **answers.strike_numbers(strike)}
        row |= {f"{model}.strike_{k}.{name}": float(values[name]) for name in VALUES}
    row |= {f"{model}.peaks.{name}": float(value) for name, value in answer.peaks.items()}
    for k, hinge in enumerate(answer.hinges, 1):
        row |= {f"{model}.hinge_{k}.{name}": value for name, value in hinge.items()}
    return row | {f"{model}.end.{name}": value for name, value in answer.end.items()}
