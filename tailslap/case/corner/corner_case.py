"""Case of a constrained corner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from postprocess.comparison import quantities
from tailslap.case import check
from tailslap.case.case import NO_BAND, within_tolerance
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.force_band import ForceBand
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    from tailslap.case.corner.corner_plan import CornerPlan
    from tailslap.case.corner.corner_report import CornerReport
    from tailslap.case.corner.outcome import CornerOutcome


@dataclass(frozen=True)
class CornerCase(RigidStages):
    """A scene with a constrained corner, see `Case`."""

    least_tolerance = 1e-8

    def plan(self, more_damping: float = 1.0) -> CornerPlan:
        """Decide open keys, and make the model of a run.

        more_damping: factor on the damping that the program chooses [-].
        """
        from tailslap.case.corner.corner_plan import make_corner_plan

        return make_corner_plan(self, more_damping)

    def check_lines(self, fe_plan: CornerPlan | None) -> dict[str, list[str]]:
        """Return the texts of `tailslap check` by label."""
        from tailslap.case.corner import corner_report

        return corner_report.check_lines(self, fe_plan)

    def run(self, tolerance: float | None = None) -> CornerOutcome:
        """Run the plate, compare it with the rigid body, and check it.

        tolerance: see `within_tolerance`. Raises InputError.
        """
        from tailslap.case.corner import corner_run

        return within_tolerance(self, corner_run.run_corner, tolerance)

    def report(self, outcome: CornerOutcome, band: ForceBand = NO_BAND) -> CornerReport:
        """Return the report of a run.

        band: of the force over varied inputs.
        """
        from tailslap.case.corner.corner_report import CornerReport

        return CornerReport(outcome, band)

    @staticmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Return the columns of sweeps with their types.

        Raises InputError for a scene without [plate].
        """
        _ = scene.needed_plate
        compared = [f"{group}.{key}" for group in ("rigid", "fe", "difference") for key in quantities.KEYS]
        real = dict.fromkeys([*compared, "rigid.peak_force", "fe.peak_force", "deflection_ratio"], float)
        cost = {"cost.elements": int, "cost.nodes": int, "cost.steps": int, "cost.time_step": float}
        return {**real, **cost}

    def row(self, outcome: CornerOutcome | None) -> dict[str, Any]:
        """Return a run as a sweep's row, SI.

        Quantities of the tail-slap are missing where it was not reached.
        """
        from tailslap.case.run_report import run_cost

        if outcome is None:
            _ = self.scene.needed_plate
            return {}
        groups = {"rigid": outcome.rigid, "fe": outcome.fe, "difference": outcome.difference}
        groups["cost"] = run_cost(outcome)
        return {
            **check.check_columns(outcome.checks),
            **{f"{group}.{key}": value for group, values in groups.items() for key, value in values.items()},
            "rigid.peak_force": float(self.force.peak_force),
            "fe.peak_force": outcome.lateral_force,
            "deflection_ratio": float(outcome.fe_plan.deflection_ratio),
            "numerical_error": float(outcome.error.total),
        }
