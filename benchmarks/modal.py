"""Difference of the modal model from the whole plate, its estimate, and cost.

    .venv/bin/python benchmarks/modal.py

Both runs have the same initial state and matrices; times are the best of alternating runs.
"""

from __future__ import annotations

import statistics
import time

import command_line
from main_job import row

from fem.plate.free_modes import free_modes
from fem.run.corner import Run, simulate
from postprocess.comparison.quantities import KEYS
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.modal_run import MODES, ModalRun, modal_run
from tailslap.scene.read import read_scene

SCENES = {"paper-table-3": "drag", "paper-abaqus": "none"}
SOFT = ("plate.youngs_modulus=", "plate.first_frequency=20 Hz")
REPEATS = 15


def fe_plan_of(name: str, *changes: str) -> CornerPlan:
    """Plan of a shipped scene with changes."""
    return CornerCase(*read_scene(name, changes)).plan()


def whole(fe_plan: CornerPlan) -> Run:
    """The finite-element run."""
    return simulate(
        fe_plan.model, fe_plan.start, fe_plan.case.motion.strike.t, rows=fe_plan.case.scene.time.rows
    )


def differences(fe_plan: CornerPlan, found: ModalRun) -> dict[str, float]:
    """Modal over finite-element result - 1, for the five quantities."""
    strike = whole(fe_plan).strike
    assert strike
    return {name: found.values[name] / strike.values[name] - 1.0 for name in KEYS}


def accuracy() -> None:
    """Against the whole plate, with the modes that are kept unless one asks for others."""
    for what, asked, change in (("E = 200 GPa", "1e-5", ()), ("first frequency 20 Hz", "1e-3", SOFT)):
        for name, reaction in SCENES.items():
            fe_plan = fe_plan_of(name, *change)
            found = modal_run(fe_plan, MODES)
            off = differences(fe_plan, found)
            each = ", ".join(f"{key} {value:+.1e}" for key, value in off.items())
            row(f"{what}, {reaction}: largest of five", asked, f"{max(map(abs, off.values())):.1e} ({each})")


def estimate() -> None:
    """The model's own estimate over the difference from the whole plate: above one, and not far."""
    ratios = []
    for name in SCENES:
        for modulus in ("200 GPa", "20 GPa", "2 GPa", "200 MPa", "20 MPa"):
            fe_plan = fe_plan_of(name, f"plate.youngs_modulus={modulus}")
            for modes in (0, 1, 2, 4, 8):
                found = modal_run(fe_plan, modes)
                off = differences(fe_plan, found)
                ratios.append(found.estimate.total / max(map(abs, off.values())))
    row(
        f"estimate over difference, {len(ratios)} runs from 200 GPa to 20 MPa, 0 to 8 modes",
        "above 1",
        f"{min(ratios):.1f} to {max(ratios):.1f}",
    )


def cost() -> None:
    """Time loops in turn, and what comes before them."""
    for what, change in (("E = 200 GPa", ()), ("first frequency 20 Hz", SOFT)):
        fe_plan = fe_plan_of("paper-table-3", *change)
        pairs = [(whole(fe_plan), modal_run(fe_plan, MODES)) for _ in range(REPEATS)]
        full, modal = (min(run.time_loop_s for run, _ in pairs), min(run.integration_s for _, run in pairs))
        checked = min(run.integration_s + run.estimate_s for _, run in pairs)
        ratio = statistics.median(run.time_loop_s / other.integration_s for run, other in pairs)
        asked = "20 times less" if not change else "-"
        row(
            f"{what}, drag: FE time loop, modal integration",
            asked,
            f"{1e3 * full:.1f} ms, {1e3 * modal:.2f} ms: {full / modal:.0f} times less (median {ratio:.0f})",
        )
        row(
            f"{what}, drag: integration and estimate",
            "-",
            f"{1e3 * checked:.2f} ms: {full / checked:.0f} times less",
        )
        setup = min(run.setup_s for _, run in pairs)
        row(f"{what}: set-up of the modal model, modes and start", "-", f"{1e3 * setup:.1f} ms")
    spent = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        free_modes(fe_plan.model, 1)
        spent.append(time.perf_counter() - began)
    row("first frequency of the plate, 20 x 6", "20 ms", f"{1e3 * min(spent):.1f} ms")


if __name__ == "__main__":
    command_line.parser(__doc__).parse_args()
    row("what", "asked", "measured")
    accuracy()
    estimate()
    cost()
