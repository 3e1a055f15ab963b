"""The modal run on standard output: as text, and as JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from postprocess.comparison.comparison import comparison_rows
from postprocess.report.report import shown_in
from postprocess.report.table import Column, Table
from postprocess.report.terminal import printed
from postprocess.report.units import SYSTEMS
from tailslap.modal_run import ModalRun
from tailslap.planning.fe_plan import FePlan

COLUMNS = (
    Column("quantity.symbol", "at the tail-slap"),
    Column("quantity.unit", "unit", is_unit=True),
    Column("fe", "modal", form=".7g", unit_key="quantity.unit"),
    Column("rigid", "rigid, exact", form=".7g", unit_key="quantity.unit"),
    Column("difference", "modal/rigid - 1", form="+.1e"),
)


def modal_text(fe_plan: FePlan, run: ModalRun, units: str = "si") -> str:
    """The results as a person reads them, in units "si" or "us"."""
    scene, estimate = fe_plan.plan.scene, run.estimate
    kept = ", ".join(f"{frequency:.4g}" for frequency in run.frequencies) or "none"
    estimated = (
        f"Estimate of its error: {estimate.total:.1e}, of that {estimate.modes:.1e} by the modes left out, "
        f"{estimate.linear:.1e} by linear strain, {estimate.steps:.1e} by the time steps"
    )
    failed = (
        f"FAILED  {check.name}: {check.value:.3g}, limit {check.limit:.3g} ({check.meaning})"
        for check in run.checks
        if not check.passed
    )
    compared = Table(COLUMNS, comparison_rows(run.values, run.rigid, None)) if run.values else None
    parts = (
        f"{scene.name}: modal model, reaction {scene.corner.reaction}, modes kept [Hz]: {kept}",
        *((compared, estimated) if compared else ()),
        *failed,
        f"Cost:   {run.steps} steps in {1e3 * run.integration_s:.2f} ms, set-up {1e3 * run.setup_s:.1f} ms, "
        f"estimate {1e3 * run.estimate_s:.2f} ms",
    )
    return printed(parts if units == "si" else [shown_in(part, SYSTEMS[units]) for part in parts])


def modal_numbers(fe_plan: FePlan, run: ModalRun) -> dict[str, Any]:
    """The numbers for other programs, SI; what was not reached is None."""
    unknown = dict.fromkeys(run.rigid)
    cost = ("steps", "iterations", "setup_s", "integration_s", "estimate_s")
    return {
        "scene": fe_plan.plan.scene.name,
        "passed": run.passed,
        "modal": run.values or unknown,
        "rigid": run.rigid,
        "difference": run.difference or unknown,
        "estimate": {**asdict(run.estimate), "total": run.estimate.total},
        "frequencies_hz": run.frequencies,
        "checks": [asdict(check) for check in run.checks],
        "cost": {"modes": run.frequencies.size} | {name: getattr(run, name) for name in cost},
    }
