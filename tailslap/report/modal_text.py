"""The modal run on standard output: as text, and as JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from postprocess.comparison.comparison import comparison_rows
from postprocess.files.summary import plain
from tailslap.modal import ModalRun
from tailslap.planning.fe_plan import FePlan


def modal_lines(fe_plan: FePlan, run: ModalRun) -> list[str]:
    """The answer as a person reads it."""
    scene, estimate = fe_plan.plan.scene, run.estimate
    kept = ", ".join(f"{frequency:.4g}" for frequency in run.frequencies) or "none"
    lines = [f"{scene.name}: modal model, reaction {scene.corner.reaction}, modes kept [Hz]: {kept}", ""]
    if run.values:
        lines.append(f"  {'at the tail-slap':<18}{'modal':>14}{'rigid, exact':>14}{'modal/rigid - 1':>18}")
        lines += [
            f"  {f'{row.quantity.symbol} [{row.quantity.unit}]':<18}{row.fe:>14.7g}{row.rigid:>14.7g}"
            f"{row.difference:>+18.1e}"
            for row in comparison_rows(run.values, run.rigid, None)
        ]
        lines += [
            "",
            f"Estimate of its error: {estimate.total:.1e}, of that {estimate.modes:.1e} by the modes left out, "
            f"{estimate.linear:.1e} by linear strain, {estimate.steps:.1e} by the time steps",
        ]
    lines += [
        f"FAILED  {check.name}: {check.value:.3g}, limit {check.limit:.3g} ({check.meaning})"
        for check in run.checks
        if not check.passed
    ]
    lines.append(
        f"Cost:   {run.steps} steps in {1e3 * run.integration_s:.2f} ms, set-up {1e3 * run.setup_s:.1f} ms, "
        f"estimate {1e3 * run.estimate_s:.2f} ms"
    )
    return lines


def modal_answer(fe_plan: FePlan, run: ModalRun) -> dict[str, Any]:
    """The numbers for other programs, SI; what was not reached is None."""
    nothing = dict.fromkeys(run.rigid)
    answer: dict[str, Any] = plain(
        {
            "scene": fe_plan.plan.scene.name,
            "passed": run.passed,
            "modal": run.values or nothing,
            "rigid": run.rigid,
            "difference": run.difference or nothing,
            "estimate": {**asdict(run.estimate), "total": run.estimate.total},
            "frequencies_hz": run.frequencies,
            "checks": [asdict(check) for check in run.checks],
            "cost": {
                "modes": run.frequencies.size,
                "steps": run.steps,
                "iterations": run.iterations,
                "setup_s": run.setup_s,
                "integration_s": run.integration_s,
                "estimate_s": run.estimate_s,
            },
        }
    )
    return answer
