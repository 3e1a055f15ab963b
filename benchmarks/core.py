"""Accuracy, conservation, steps and cost of the finite-element core.

    .venv/bin/python benchmarks/core.py

Times are the best of several runs; the machine's noise is in them, so no test looks at them.
"""

from __future__ import annotations

import math
import time

import command_line
import numpy as np
from main_job import outcome, row, timed, worst

from fem.run.corner import Stepper, simulate
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.scene.read import read_scene

ELEMENTS = ("quad4", "quad4-reduced", "quad9", "tri3", "tri6")
MODULI = np.geomspace(20e9, 20e12, 7)


def accuracy() -> None:
    """Shipped scenes, rigid limit, irregular meshes."""
    for name in ("paper-table-3", "paper-abaqus"):
        row(f"{name} as shipped: largest of five differences", "5e-6", f"{worst(outcome(name)):.1e}")
    for reaction in ("drag", "none"):
        result = outcome(
            "paper-table-3",
            f"corner.reaction={reaction}",
            "plate.youngs_modulus=20 TPa",
            "damping.ratio=0.02",
        )
        row(f"E x 100, damping ratio 0.02, reaction {reaction}", "5e-7", f"{worst(result):.1e}")
    for what, change in (("distorted quads", "plate.distortion=0.2"), ("triangles", "plate.element=tri3")):
        for reaction in ("drag", "none"):
            result = outcome("paper-table-3", f"corner.reaction={reaction}", change)
            row(f"{what}, reaction {reaction}", "1e-5", f"{worst(result):.1e}")


def flexibility() -> None:
    """Difference against 1/E, E from 20 GPa to 20 TPa, with light damping so that friction cannot flutter."""
    for reaction in ("drag", "none"):
        worsts = [
            worst(
                outcome(
                    "paper-table-3",
                    f"corner.reaction={reaction}",
                    f"plate.youngs_modulus={modulus}",
                    "damping.ratio=0.02",
                )
            )
            for modulus in MODULI
        ]
        slope = np.polyfit(np.log(MODULI), np.log(worsts), 1)[0]
        steps = np.diff(np.log(worsts)) / np.diff(np.log(MODULI))
        row(
            f"difference against E, reaction {reaction}: exponent",
            "power law",
            f"{slope:.4f} (between neighbours {steps.min():.3f} to {steps.max():.3f}), "
            f"{worsts[0]:.1e} down to {worsts[-1]:.1e}",
        )


def conservation() -> None:
    """Largest gap in the energy ledger over the initial energy."""
    for what, asked, changes in (
        ("undamped, frictionless", "1e-6", ("corner.reaction=none",)),
        ("undamped, with friction", "1e-4", ()),
        ("friction and damping", "1e-4", ("damping.ratio=0.1",)),
        (
            "friction, damping, dashpot, bulk, unstressed start",
            "1e-4",
            (
                *("damping.ratio=0.1", "damping.bulk_viscosity=0.06", "corner.damping_ratio=0.2"),
                "plate.start=unstressed",
            ),
        ),
    ):
        checks = {check.name: check.value for check in outcome("paper-table-3", *changes).checks}
        row(f"energy balance, {what}", asked, f"{checks['energy balance']:.1e}")


def runaway(fe_plan: CornerPlan, factor: float) -> bool:
    """Whether a disturbed plate runs away at this multiple of the stable step within 20 000 steps."""
    parameters = fe_plan.model.parameters._replace(time_step=factor * fe_plan.model.stable_time_step)
    stepper = Stepper(type(fe_plan.model)(**{**fe_plan.model.__dict__, "parameters": parameters}))
    state = stepper.advance(stepper.start(fe_plan.start, "unstressed"), 20_000)
    return not np.abs(state.velocities).max() < 1e3


def steps() -> None:
    """The step taken against the largest that is stable, found by trying."""
    fe_plan = outcome("paper-abaqus").fe_plan
    low, high = 0.8, 1.3
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if runaway(fe_plan, middle) else (middle, high)
    taken = fe_plan.model.parameters.time_step / fe_plan.model.stable_time_step
    row(
        "steps taken over the fewest that are stable (bisected)",
        f"{1 / 0.9:.3f}",
        f"{low / taken:.3f}: the true limit is {low:.3f} of the one computed",
    )


def loop_time() -> None:
    """The time loop of the shipped scene."""
    fe_plan = outcome("paper-table-3").fe_plan
    duration = fe_plan.case.motion.strike.t
    row(
        "time loop of paper-table-3, one core",
        "0.05 s",
        timed(lambda: simulate(fe_plan.model, fe_plan.start, duration), 15),
    )


def elements() -> None:
    """Error and cost of each element, material and hold; undamped but for the one-point quads."""
    print(
        f"\n{'paper-table-3 with':<44}{'difference':>11}{'give':>10}{'steps':>8}{'loop [s]':>10}{'M updates/s':>13}"
    )
    for changes in (
        *((f"plate.element={name}",) for name in ELEMENTS if name != "quad4-reduced"),
        ("plate.element=quad4-reduced", "damping.ratio=0.01"),
        ("material.law=neo-hookean",),
        ("plate.distortion=0.2",),
        ("damping.ratio=0.01",),
        ("corner.constraint=exact",),
        ("corner.patch_length=1",),
        ("corner.damping_ratio=0.2",),
    ):
        result = outcome("paper-table-3", *changes)
        seconds = best_loop(result)
        table = result.fe_plan.model.parameters.table
        updates = result.run.steps * table.connectivity.shape[1] / seconds / 1e6
        print(
            f"{', '.join(changes):<44}{worst(result):>11.1e}{result.fe_plan.deflection_ratio:>10.2e}"
            f"{result.run.steps:>8}{seconds:>10.3f}{updates:>13.1f}",
            flush=True,
        )


def best_loop(result: CornerOutcome) -> float:
    """Best of five time loops [s]."""
    fe_plan, best = result.fe_plan, math.inf
    for _ in range(5):
        began = time.perf_counter()
        simulate(fe_plan.model, fe_plan.start, fe_plan.case.motion.strike.t)
        best = min(best, time.perf_counter() - began)
    return best


def point_and_patch() -> None:
    """Print the compliance of the corner on four meshes.

    That of a point grows with the logarithm of the mesh, that of a patch converges.
    """
    print(
        f"\n{'give of the corner, E = 200 GPa':<44}"
        + "".join(f"{n:>5} x {3 * n // 10:<4}" for n in (20, 40, 80, 160))
    )
    for what, changes in (("one node", ()), ("patch of 1 m", ("corner.patch_length=1",))):
        gives = []
        for n in (20, 40, 80, 160):
            change = ("corner.constraint=exact", f"plate.elements=[{n}, {3 * n // 10}]", *changes)
            gives.append(run_scene_give(*change))
        print(f"{what:<44}" + "".join(f"{give:>12.4e}" for give in gives))


def run_scene_give(*changes: str) -> float:
    """Return the compliance of the plate without a run."""

    return CornerCase(*read_scene("paper-abaqus", changes)).plan().deflection_ratio


if __name__ == "__main__":
    command_line.parser(__doc__).parse_args()
    row("what", "asked", "measured")
    for part in (accuracy, flexibility, conservation, steps, loop_time, elements, point_and_patch):
        part()
