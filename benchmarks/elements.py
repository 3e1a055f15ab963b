"""Steps a second of quad4-reduced over those of quad4, on the same 160 x 48 plate, in turns.

.venv/bin/python benchmarks/elements.py
"""

from __future__ import annotations

import statistics
import time
from typing import Any

from fem.run.corner import Stepper
from tailslap.case.corner.case import CornerCase
from tailslap.scene.read import read_scene

ROUNDS, STEPS = 21, 200


def prepared(element: str) -> tuple[Stepper, Any]:
    """The compiled loop of the plate, and its state after a few steps."""
    changes = (f"plate.element={element}", "plate.elements=[160, 48]", "corner.constraint=penalty")
    fe_plan = CornerCase(*read_scene("paper-table-3", changes)).plan()
    stepper = Stepper(fe_plan.model)
    return stepper, stepper.advance(stepper.start(fe_plan.start, fe_plan.plate.start), 10)


def main() -> None:
    """Print the ratio."""
    loops = {name: prepared(name) for name in ("quad4", "quad4-reduced")}
    times: dict[str, list[float]] = {name: [] for name in loops}
    for _ in range(ROUNDS):
        for name, (stepper, state) in loops.items():
            began = time.perf_counter()
            stepper.advance(state, STEPS)
            times[name].append(time.perf_counter() - began)
    full, reduced = times.values()
    ratios = [a / b for a, b in zip(full, reduced, strict=True)]
    print(
        f"quad4-reduced over quad4: {statistics.median(ratios):.2f} times as fast "
        f"({min(ratios):.2f} to {max(ratios):.2f}, {ROUNDS} rounds), bests {min(full) / min(reduced):.2f}"
    )


if __name__ == "__main__":
    main()
