"""What a time loop costs: the one figure that plans, tolerances and studies reckon with."""

from __future__ import annotations

import math

NANOSECONDS = {"quad4": 12.0, "quad4-reduced": 12.0, "quad9": 75.0, "tri3": 8.0, "tri6": 40.0}
"""Time that a cell of the mesh costs a step [ns], on one core; measured by `benchmarks/speed.py`."""

OTHER_NS = 75.0
"""The same for an element from outside."""

ROW_S = 5e-5
"""Time that a row of the history costs [s], whatever the mesh."""


def loop_seconds(element: str, counts: tuple[int, int], steps: float, rows: int = 0) -> float:
    """Expected time of a loop over so many elements along and across, and of its history's rows [s]."""
    return steps * math.prod(counts) * NANOSECONDS.get(element, OTHER_NS) * 1e-9 + rows * ROW_S
