"""ImpactCase: the rigid vehicle's whole impact, and the FE plate's beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from postprocess.report.units import SI, Units
from tailslap.case.impact.rigid import RigidImpact

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from postprocess.report.report import Report
    from tailslap.impact.fe_plan import ImpactFePlan
    from tailslap.impact.outcome import ImpactOutcome
    from tailslap.scene.schema import Scene


@dataclass(frozen=True)
class ImpactCase(RigidImpact):
    """A scene with [contact], see `Case`."""

    least_tolerance = 1e-6

    def rigid_numbers(self) -> dict[str, Any]:
        """Strikes, peaks and end of the rigid vehicle, SI."""
        from tailslap.impact.rigid_text import rigid_numbers

        return rigid_numbers(self)

    def rigid_text(self, units: str = "si") -> list[str]:
        """The answer as a person reads it, in SI or, with units "us", in ft, mph and kip."""
        from tailslap.impact.rigid_text import rigid_lines

        return rigid_lines(self, units)

    def rigid_history(self) -> dict[str, np.ndarray]:
        """Columns of the rigid vehicle's impact by name, SI."""
        from tailslap.impact.rigid_text import rigid_history

        return rigid_history(self)

    def plan(self, more_damping: float = 1.0) -> ImpactFePlan:
        """Decide what the scene leaves open, mesh and assemble; no damping is chosen."""
        from tailslap.impact.fe_plan import make_impact_fe_plan

        return make_impact_fe_plan(self)

    def _check_text(self) -> list[str]:
        from tailslap.impact.check_text import check_lines

        return check_lines(self)

    def _run(self) -> ImpactOutcome:
        from tailslap.impact.run import run_impact

        return run_impact(self)

    @staticmethod
    def stated_error(outcome: ImpactOutcome) -> float:
        """Largest change of impulse, peak and duration of the first two strikes by higher-order elements."""
        return max(map(abs, outcome.mesh_error.values()), default=float("nan"))

    def summary(self, outcome: ImpactOutcome, pictures: bool) -> dict[str, Any]:
        """The numbers of a run, SI."""
        from tailslap.impact.summary import impact_summary

        return impact_summary(outcome, pictures)

    def histories(self, outcome: ImpactOutcome) -> dict[str, dict[str, np.ndarray]]:
        """The histories of FE plate and rigid vehicle by the names of their files."""
        from tailslap.impact.summary import impact_histories

        return impact_histories(outcome)

    def report(self, outcome: ImpactOutcome, folder: Path, pictures: bool, units: Units = SI) -> Report:
        """The report of a run; its fields and animation, in these units, go into the folder."""
        from tailslap.impact.report import impact_report

        return impact_report(outcome, folder, pictures, units)

    @staticmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Columns that the table of a sweep has whatever its rows."""
        from tailslap.impact.columns import impact_column_kinds

        return impact_column_kinds(scene)

    def row(self, outcome: ImpactOutcome | None) -> dict[str, Any]:
        """A run as columns of that table, SI; without an outcome, the rigid vehicle alone."""
        from tailslap.impact.columns import impact_row

        return impact_row(self, outcome)
