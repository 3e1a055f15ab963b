"""Compilation of the plate's time loop in a process of its own.

On the first use of a machine it runs beside the compilation of the rigid vehicle's motion. The process executes this
file as a program, with the tables of the scene on standard input.
"""

import json
import math
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from solver.impact.solve import has_machine_code
from tailslap.case import plate_input, resources
from tailslap.case.impact import error, plan
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.rigid import SAMPLE
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source, vary


@contextmanager
def plate_compiled_beside(scene: Scene, source: Source) -> Iterator[None]:
    """Compile the time loop of a scene's plate beside the block.

    There is no process without a plate, for a mesh that depends on the motion or is large, on one core, and where the
    motion of the rigid vehicle is compiled already. The process ends with the block.
    """
    is_small = scene.plate is not None and math.prod(scene.plate.elements or ()) < plate_input.LARGE
    if not is_small or scene.meshed_wall or resources.available_cores() < 2 or has_machine_code():
        yield
        return
    command = [sys.executable, "-P", "-m", __name__]  # -P: nothing is imported from the working directory
    silent = subprocess.DEVNULL
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=silent, stderr=silent) as process:
        try:
            assert process.stdin is not None
            with suppress(BrokenPipeError):
                process.stdin.write(json.dumps(source.given, default=str).encode())
                process.stdin.close()
            yield
        finally:
            process.kill()


class UnsolvedImpact(ImpactCase):
    """Whole impact without the motion of the rigid vehicle."""

    def __post_init__(self) -> None:
        """Accept any scene."""


def compile_plate(source: Source) -> None:
    """Compile the time loops of a run and of its error estimate.

    Raises InputError.
    """
    from fem.run.impact import compile_impact_loop

    case = UnsolvedImpact(*vary(source, {}))
    plate, _ = plan.chosen_plate(case.scene, 0)
    plates = [plate]
    if case.scene.verify.companion:
        plates += [coarse for coarse, _ in error.companions(plate) if coarse.element != plate.element][:1]
    for plate in plates:
        model, _ = plan.impact_model(case, plate, SAMPLE)
        compile_impact_loop(model)


if __name__ == "__main__":
    compile_plate(Source(given=json.load(sys.stdin)))
