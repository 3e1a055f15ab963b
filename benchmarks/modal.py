"""Difference of the modal model from the full plate, and cost.

    .venv/bin/python benchmarks/modal.py

Both runs have the same initial state and matrices; times are the best of alternating runs.
"""

from __future__ import annotations

import statistics

import command_line
from command_line import corner_case, row, seconds

from fem.plate.free_modes import free_modes
from fem.run.corner import Run, simulate
from postprocess.comparison.quantities import KEYS
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.modal_run import MODES, ModalRun, modal_run

SCENES = {"paper-table-3": "drag", "paper-abaqus": "none"}
SOFT = ("plate.youngs_modulus=", "plate.first_frequency=20 Hz")
REPEATS = 15


def whole(fe_plan: CornerPlan) -> Run:
    """Run the finite-element model."""
    case = fe_plan.case
    return simulate(fe_plan.model, fe_plan.start, case.motion.strike.t, rows=case.scene.time.rows)


def differences(fe_plan: CornerPlan, modal: ModalRun) -> dict[str, float]:
    """Return the five differences of the modal from the finite-element result."""
    strike = whole(fe_plan).strike
    assert strike
    return {name: modal.values[name] / strike.values[name] - 1.0 for name in KEYS}


def accuracy() -> None:
    """Print the differences from the whole plate with the default modes."""
    for what, required, change in (("E = 200 GPa", "1e-5", ()), ("first frequency 20 Hz", "1e-3", SOFT)):
        for name, reaction in SCENES.items():
            fe_plan = corner_case(name, *change).plan()
            modal = modal_run(fe_plan, MODES)
            off = differences(fe_plan, modal)
            listed = ", ".join(f"{key} {value:+.1e}" for key, value in off.items())
            row(
                f"{what}, {reaction}: largest of five",
                required,
                f"{max(map(abs, off.values())):.1e} ({listed})",
            )


def estimate() -> None:
    """Print the model's own estimate over the difference from the whole plate."""
    ratios = []
    for name in SCENES:
        for modulus in ("200 GPa", "20 GPa", "2 GPa", "200 MPa", "20 MPa"):
            fe_plan = corner_case(name, f"plate.youngs_modulus={modulus}").plan()
            for modes in (0, 1, 2, 4, 8):
                modal = modal_run(fe_plan, modes)
                off = differences(fe_plan, modal)
                ratios.append(modal.estimate.total / max(map(abs, off.values())))
    what = f"estimate over difference, {len(ratios)} runs from 200 GPa to 20 MPa, 0 to 8 modes"
    row(what, "above 1", f"{min(ratios):.1f} to {max(ratios):.1f}")


def cost() -> None:
    """Print the times of loops in turn, and of the set-up."""
    for what, change in (("E = 200 GPa", ()), ("first frequency 20 Hz", SOFT)):
        fe_plan = corner_case("paper-table-3", *change).plan()
        pairs = [(whole(fe_plan), modal_run(fe_plan, MODES)) for _ in range(REPEATS)]
        full, modal = (min(run.time_loop_s for run, _ in pairs), min(run.integration_s for _, run in pairs))
        checked = min(run.integration_s + run.estimate_s for _, run in pairs)
        ratio = statistics.median(run.time_loop_s / other.integration_s for run, other in pairs)
        text = (
            f"{1e3 * full:.1f} ms, {1e3 * modal:.2f} ms: {full / modal:.0f} times less (median {ratio:.0f})"
        )
        row(f"{what}, drag: FE time loop, modal integration", "" if change else "20 times", text)
        text = f"{1e3 * checked:.2f} ms: {full / checked:.0f} times less"
        row(f"{what}, drag: integration and estimate", "", text)
        setup = min(run.setup_s for _, run in pairs)
        row(f"{what}: set-up of the modal model, modes and start", "-", f"{1e3 * setup:.1f} ms")
    spent = [seconds(lambda: free_modes(fe_plan.model, 1)) for _ in range(REPEATS)]
    row("first frequency of the plate, 20 x 6", "20 ms", f"{1e3 * min(spent):.1f} ms")


if __name__ == "__main__":
    command_line.options(__doc__)
    for part in (accuracy, estimate, cost):
        part()
