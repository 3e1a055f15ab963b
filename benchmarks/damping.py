"""Effect and cost of the damping of elastic velocities.

    .venv/bin/python benchmarks/damping.py

Of the first table stated over measured should be above one. The second times set-up and loop of the paper's plate, with
the damping and without, in turns: median of the ratios, least and largest.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import command_line
from command_line import seconds, spread
from vehicles import plan_of

from fem.run.corner import Stepper, compile_loop
from tailslap.case.corner.corner_plan import make_corner_plan
from tailslap.case.corner.corner_run import attempt, run_corner
from tailslap.case.corner.decisions import predict_growth

PATCH = ("plate.youngs_modulus=", "corner.patch_length=1 m")
CASES = (
    ((*PATCH, "plate.first_frequency=8 Hz"), (20.0, 100.0, 1000.0)),
    ((*PATCH, "plate.first_frequency=2 Hz"), (10.0, 30.0)),
    (("vehicle.width=0.3", "corner.friction=1", "corner.penalty_scale=0.1"), (100.0, 400.0, 900.0)),
    (("vehicle.length=19", "impact.angle=8 deg", "plate.youngs_modulus=2e9"), (50.0, 500.0)),
)
TURNS, STEPS = 15, 3000


def bias() -> None:
    """Print the stated effect of each rate beside the measured one."""
    print("case; rate [1/s]; stated; measured: largest change of the five quantities; stated over measured")
    for changes, rates in CASES:
        free = attempt(plan_of((*changes, "damping.kind=none")))
        for rate in rates:
            damped = run_corner(plan_of((*changes, "damping.kind=elastic-velocity", f"damping.rate={rate}")))
            moved = max(abs(value / free.fe[name] - 1.0) for name, value in damped.fe.items())
            stated = damped.error.damping
            print(f"{' '.join(changes)}; {rate:g}; {stated:.1e}; {moved:.1e}; {stated / moved:.1f}")


def advance_time(fe_plan: Any) -> float:
    """Return the seconds of the steps."""
    stepper = Stepper(fe_plan.model)
    state = stepper.start(fe_plan.start, "inertia-relief")
    return seconds(lambda: stepper.advance(state, STEPS))


def cost() -> None:
    """Print the cost of damping in the loop, and of its prediction."""
    choices = (), ("damping.kind=elastic-velocity", "damping.rate=100")
    plain, damped = (make_corner_plan(plan_of(changes)) for changes in choices)
    for fe_plan in (plain, damped):
        compile_loop(fe_plan.model, fe_plan.start)
    pairs = [(advance_time(damped), advance_time(plain)) for _ in range(TURNS)]
    ratios = [one / other for one, other in pairs]
    print(f"loop with it over loop without, 120 elements: {spread(ratios)}")
    predict = partial(predict_growth, plain.case, plain.plate, plain.model, 1.0)
    extra = [1e3 * seconds(predict) for _ in range(TURNS)]
    print(f"set-up, 120 elements, milliseconds for flutter and rounding: {spread(extra)}")


if __name__ == "__main__":
    command_line.options(__doc__)
    cost()
    bias()
