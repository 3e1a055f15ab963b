"""Accuracy, conservation, steps and cost of the finite-element core.

    .venv/bin/python benchmarks/core.py [PART ...]

Parts: accuracy, flexibility, conservation, steps, elements, point_and_patch. Times are the best of several.
"""

from __future__ import annotations

import command_line
import numpy as np
from command_line import corner_case, row, seconds
from main_job import REACTIONS, outcome, worst

from fem.run.corner import Stepper, simulate
from tailslap.case.corner.corner_plan import CornerPlan

MODULI = np.geomspace(20e9, 20e12, 7)
DAMPED = "damping.ratio=0.02"
ALL_DAMPING = (
    *("damping.ratio=0.1", "damping.bulk_viscosity=0.06", "corner.damping_ratio=0.2"),
    "plate.start=unstressed",
)
CONSERVED = (
    ("undamped, frictionless", "1e-6", ("corner.reaction=none",)),
    ("undamped, with friction", "1e-4", ()),
    ("friction and damping", "1e-4", ("damping.ratio=0.1",)),
    ("friction, damping, dashpot, bulk, unstressed start", "1e-4", ALL_DAMPING),
)
VARIANTS = (
    *((f"plate.element={name}",) for name in ("quad4", "quad9", "tri3", "tri6")),
    *(("plate.element=quad4-reduced", "damping.ratio=0.01"), ("material.law=neo-hookean",)),
    *(("plate.distortion=0.2",), ("damping.ratio=0.01",), ("corner.constraint=exact",)),
    *(("corner.patch_length=1",), ("corner.damping_ratio=0.2",)),
)


def accuracy() -> None:
    """Print differences of shipped scenes, stiff plates and irregular meshes."""
    for name in ("paper-table-3", "paper-abaqus"):
        row(f"{name} as shipped: largest of five differences", "5e-6", f"{worst(outcome(name)):.1e}")
    for required, what, changes in (
        ("5e-7", "E x 100, damping ratio 0.02", ("plate.youngs_modulus=20 TPa", DAMPED)),
        ("1e-5", "distorted quads", ("plate.distortion=0.2",)),
        ("1e-5", "triangles", ("plate.element=tri3",)),
    ):
        for reaction in REACTIONS[:2]:
            result = outcome("paper-table-3", f"corner.reaction={reaction}", *changes)
            row(f"{what}, reaction {reaction}", required, f"{worst(result):.1e}")


def flexibility() -> None:
    """Print the exponent of the difference over E, lightly damped."""
    for reaction in REACTIONS[:2]:
        changes = [(f"corner.reaction={reaction}", f"plate.youngs_modulus={e}", DAMPED) for e in MODULI]
        worsts = [worst(outcome("paper-table-3", *change)) for change in changes]
        slope = np.polyfit(np.log(MODULI), np.log(worsts), 1)[0]
        steps = np.diff(np.log(worsts)) / np.diff(np.log(MODULI))
        between = f"between neighbours {steps.min():.3f} to {steps.max():.3f}"
        text = f"{slope:.4f} ({between}), {worsts[0]:.1e} down to {worsts[-1]:.1e}"
        row(f"difference over E, reaction {reaction}: exponent", "power law", text)


def conservation() -> None:
    """Print the largest imbalance of energy over the initial energy."""
    for what, required, changes in CONSERVED:
        checks = {check.name: check.value for check in outcome("paper-table-3", *changes).checks}
        row(f"energy balance, {what}", required, f"{checks['energy balance']:.1e}")


def diverges(plan: CornerPlan, factor: float) -> bool:
    """Return True if a disturbed plate diverges in 20 000 steps.

    factor: the step over the stable one.
    """
    loop = plan.model.parameters._replace(time_step=factor * plan.model.stable_time_step)
    stepper = Stepper(type(plan.model)(**{**plan.model.__dict__, "parameters": loop}))
    state = stepper.advance(stepper.start(plan.start, "unstressed"), 20_000)
    return not np.abs(state.velocities).max() < 1e3


def steps() -> None:
    """Print the steps over the fewest that are stable."""
    plan = outcome("paper-abaqus").fe_plan
    low, high = 0.8, 1.3
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if diverges(plan, middle) else (middle, high)
    ratio = low * plan.model.stable_time_step / plan.model.parameters.time_step
    text = f"{ratio:.3f}: the true limit is {low:.3f} of the one computed"
    row("steps over the fewest that are stable", f"{1 / 0.9:.3f}", text)


def elements() -> None:
    """Print error and cost of elements, materials and constraints."""
    print("\npaper-table-3 with; largest difference; compliance of the corner; steps; loop [s]; updates/s")
    for changes in VARIANTS:
        result = outcome("paper-table-3", *changes)
        plan, count = result.fe_plan, result.run.steps
        end = plan.case.motion.strike.t
        best = min(seconds(lambda: simulate(plan.model, plan.start, end)) for _ in range(5))  # noqa: B023
        rate = count * plan.model.parameters.table.connectivity.shape[1] / best
        cost = f"{plan.deflection_ratio:9.2e} {count:7} {best:8.3f} {rate:9.2g}"
        row(", ".join(changes), f"{worst(result):.1e}", cost)


def point_and_patch() -> None:
    """Print the compliance of the corner on four meshes.

    That of a point grows with the logarithm of the mesh, that of a patch converges.
    """
    print("\ncompliance of the corner, E = 200 GPa, on 20 x 6, 40 x 12, 80 x 24, 160 x 48 elements")
    for what, patch in (("one node", ()), ("patch of 1 m", ("corner.patch_length=1",))):
        meshes = (f"plate.elements=[{n}, {3 * n // 10}]" for n in (20, 40, 80, 160))
        cases = (corner_case("paper-abaqus", "corner.constraint=exact", mesh, *patch) for mesh in meshes)
        row(what, "", " ".join(f"{case.plan().deflection_ratio:.4e}" for case in cases))


FUNCTIONS = (accuracy, flexibility, conservation, steps, elements, point_and_patch)
PARTS = {function.__name__: function for function in FUNCTIONS}

if __name__ == "__main__":
    for name in command_line.options(__doc__, ("parts", PARTS)).parts:
        PARTS[name]()
