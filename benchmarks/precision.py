"""Five differences of `paper-abaqus` in double and in single precision.

    .venv/bin/python benchmarks/precision.py

`SingleStepper` names the parts in single precision.
"""

from __future__ import annotations

from typing import Any

import command_line
import numpy as np

from fem.run.corner import Run, Stepper, simulate
from postprocess.comparison.quantities import KEYS, relative_difference
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.scene.read import read_scene
from tailslap.studies.cost.cost_study import SingleStepper

SCENE = "paper-abaqus"
ENERGIES = ("kinetic_energy", "strain_energy", "contact_energy")
"""Their sum stays as it is: the scene has neither friction nor damping."""


def run(fe_plan: CornerPlan, stepper: Any) -> Run:
    """The scene's run by this kind of stepper."""
    return simulate(fe_plan.model, fe_plan.start, fe_plan.case.motion.strike.t, make_stepper=stepper)


def row(what: str, fe_plan: CornerPlan, result: Run) -> str:
    """One line of the table."""
    if result.strike is None:
        return f"{what:<8} no tail-slap: the run left the finite or its time"
    values = {name: result.strike.values[name] for name in KEYS}
    difference = relative_difference(values, fe_plan.case.tail_slap)
    energy = np.sum([result.history[name] for name in ENERGIES], axis=0)
    drift = np.abs(energy / energy[0] - 1.0).max()
    numbers = "".join(f"{value:>+12.1e}" for value in difference.values())
    swing = np.ptp(result.history["reaction_normal"])
    updates = result.steps * fe_plan.model.parameters.table.connectivity.shape[1] / result.time_loop_s
    return f"{what:<8}{numbers}{drift:>12.1e}{swing:>14.3g}{updates:>12.2g}"


def main() -> None:
    """Run both and print."""
    command_line.parser(__doc__).parse_args()
    fe_plan = CornerCase(*read_scene(SCENE)).plan()
    names = "".join(f"{name:>12}" for name in KEYS)
    print(f"{SCENE:<8}\n{'stored':<8}{names}{'energy':>12}{'range of N, N':>14}{'updates/s':>12}")
    for what, stepper in (("double", Stepper), ("single", SingleStepper)):
        run(fe_plan, stepper)  # compiles
        print(row(what, fe_plan, run(fe_plan, stepper)), flush=True)


if __name__ == "__main__":
    main()
