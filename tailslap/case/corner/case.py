"""CornerCase: the paper's three stages, and the FE plate with a constrained corner beside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from postprocess.comparison.quantities import KEYS
from postprocess.report.units import SI, Units
from tailslap.case.corner.rigid import RigidStages

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from postprocess.report.report import Report
    from tailslap.planning.fe_plan import FePlan
    from tailslap.scene.schema import Scene
    from tailslap.scene_run import Outcome


@dataclass(frozen=True)
class CornerCase(RigidStages):
    """A scene with a constrained corner, see `Case`."""

    def plan(self, more_damping: float = 1.0) -> FePlan:
        """Decide what the scene leaves open, mesh and assemble; more_damping: factor on the damping chosen [-]."""
        from tailslap.planning.fe_plan import make_fe_plan

        return make_fe_plan(self, more_damping)

    def _check_text(self) -> list[str]:
        from tailslap.report.check_text import check_lines

        return check_lines(self)

    def run(self, tolerance: float | None = None) -> Outcome:
        """Run the plate and compare it with the rigid motion; with a tolerance, on the cheapest mesh for it."""
        if tolerance is None:
            from tailslap.scene_run import run_scene

            return run_scene(self)
        from tailslap.tolerance import run_to_tolerance

        return run_to_tolerance(self, tolerance)

    def summary(self, outcome: Outcome, pictures: bool) -> dict[str, Any]:
        """The numbers of a run, SI; what was not reached is NaN, which is written as null."""
        from tailslap.report.summary import summary

        return summary(outcome, pictures)

    def histories(self, outcome: Outcome) -> dict[str, dict[str, np.ndarray]]:
        """The histories of FE plate and rigid body by the names of their files."""
        return outcome.histories

    def report(self, outcome: Outcome, folder: Path, pictures: bool, units: Units = SI) -> Report:
        """The report of a run; its fields and pictures, in these units, go into the folder."""
        from tailslap.report.run_report import report_in_folder

        return report_in_folder(outcome, folder, pictures, units)

    @staticmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Columns that the table of a sweep has whatever its rows. Raises InputError for a scene without [plate]."""
        _ = scene.needed_plate
        compared = [f"{group}.{key}" for group in ("rigid", "fe", "difference") for key in KEYS]
        real = dict.fromkeys([*compared, "rigid.peak_force", "deflection_ratio"], float)
        spent = {"cost.elements": int, "cost.nodes": int, "cost.steps": int, "cost.time_step": float}
        return {**real, **spent}

    def row(self, outcome: Outcome | None) -> dict[str, Any]:
        """A run as columns of that table, SI; those of the tail-slap are missing where it was not reached."""
        from tailslap.report.common import run_cost
        from tailslap.verification.check import check_columns

        if outcome is None:
            _ = self.scene.needed_plate
            return {}
        groups = {"rigid": outcome.rigid, "fe": outcome.fe, "difference": outcome.difference}
        groups["cost"] = run_cost(outcome)
        return {
            **check_columns(outcome.checks),
            **{f"{group}.{name}": value for group, its in groups.items() for name, value in its.items()},
            "rigid.peak_force": float(self.force.peak_force),
            "deflection_ratio": float(outcome.fe_plan.deflection_ratio),
            "numerical_error": float(outcome.error.total),
        }
