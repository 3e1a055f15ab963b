"""Ripple of the reaction by rounding, predicted and computed.

    .venv/bin/python benchmarks/rounding.py

The prediction is that of `fem.stability.rounding`; the runs are undamped.
"""

from __future__ import annotations

import command_line
import numpy as np
from vehicles import plan_of

from fem.stability.rounding import rounding_noise
from tailslap.case.corner.corner_run import attempt

CASES = (
    ("impact.speed=2.5", "plate.youngs_modulus=2e13"),
    ("impact.speed=0.25", "plate.youngs_modulus=2e12"),
    ("impact.speed=2.5", "plate.youngs_modulus=2e14", "corner.constraint=exact"),
    ("impact.speed=2.5", "plate.youngs_modulus=2e14", "plate.elements=[8,3]"),
    ("impact.speed=1", "plate.youngs_modulus=2e13", "plate.element=quad9", "plate.elements=[8,3]"),
    ("impact.speed=1", "plate.youngs_modulus=2e13", "vehicle.length=4"),
    ("impact.speed=1", "plate.youngs_modulus=2e13", "vehicle.length=19", "plate.elements=[11,3]"),
)


def main() -> None:
    """Print each case with the ripple of its reaction [N]."""
    command_line.options(__doc__)
    for case in CASES:
        outcome = attempt(plan_of(("corner.reaction=none", "damping.kind=none", *case)))
        ripple = outcome.fe_history["reaction_normal"] - outcome.rigid_history["reaction_normal"]
        ripple = ripple[np.isfinite(ripple)]
        observed = float(np.sqrt(np.mean(ripple[-len(ripple) // 4 :] ** 2)))
        predicted = rounding_noise(outcome.fe_plan.model).ripple(outcome.rigid["t"])
        forces = f"{predicted:.2e} N for {observed:.2e} N"
        print(f"{predicted / observed:5.2f} times: {forces}, {outcome.run.steps} steps, {' '.join(case)}")


if __name__ == "__main__":
    main()
