"""CornerCase: the paper's three stages, and the FE plate with a constrained corner beside them."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

from postprocess.comparison import quantities
from tailslap.case import case
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    from tailslap.case.corner.corner_plan import CornerPlan
    from tailslap.case.corner.outcome import CornerOutcome


@dataclass(frozen=True)
class CornerCase(RigidStages):
    """A scene with a constrained corner, see `Case`."""

    least_tolerance = 1e-8

    def plan(self, more_damping: float = 1.0) -> CornerPlan:
        """Decide what the scene leaves open, mesh and assemble; more_damping: factor on the damping chosen [-]."""
        from tailslap.case.corner.corner_plan import make_corner_plan

        return make_corner_plan(self, more_damping)

    @staticmethod
    def pages() -> ModuleType:
        """Import the texts of a constrained corner."""
        from tailslap.case.corner import corner_report

        return corner_report

    def _run(self) -> CornerOutcome:
        from tailslap.case.corner import corner_run

        return corner_run.run_corner(self)

    @staticmethod
    def stated_error(outcome: CornerOutcome) -> float:
        """Largest relative error of the five quantities that the run states; NaN without a tail-slap."""
        return outcome.error.total if outcome.fe else float("nan")

    @staticmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Columns that the table of a sweep has whatever its rows. Raises InputError for a scene without [plate]."""
        _ = scene.needed_plate
        compared = [f"{group}.{key}" for group in ("rigid", "fe", "difference") for key in quantities.KEYS]
        real = dict.fromkeys([*compared, "rigid.peak_force", "fe.peak_force", "deflection_ratio"], float)
        spent = {"cost.elements": int, "cost.nodes": int, "cost.steps": int, "cost.time_step": float}
        return {**real, **spent}

    def row(self, outcome: CornerOutcome | None) -> dict[str, Any]:
        """A run as columns of that table, SI; those of the tail-slap are missing where it was not reached."""
        from tailslap.case.run_report import run_cost

        if outcome is None:
            _ = self.scene.needed_plate
            return {}
        groups = {"rigid": outcome.rigid, "fe": outcome.fe, "difference": outcome.difference}
        groups["cost"] = run_cost(outcome)
        return {
            **case.check_columns(outcome.checks),
            **{f"{group}.{name}": value for group, its in groups.items() for name, value in its.items()},
            "rigid.peak_force": float(self.force.peak_force),
            "fe.peak_force": outcome.lateral_force,
            "deflection_ratio": float(outcome.fe_plan.deflection_ratio),
            "numerical_error": float(outcome.error.total),
        }
