"""What a time loop costs: the one figure that plans, tolerances and studies reckon with."""

from __future__ import annotations

import math

from fem.constitutive.materials import MATERIALS
from tailslap.errors import Verbatim
from tailslap.scene.schema import Scene

NANOSECONDS = {"quad4": 12.0, "quad4-reduced": 12.0, "quad9": 75.0, "tri3": 8.0, "tri6": 40.0}
"""Time that a cell of the mesh costs a step [ns], on one core; measured by `benchmarks/speed.py`."""

POINTS = {"quad4": 4, "quad4-reduced": 1, "quad9": 9, "tri3": 2, "tri6": 6}
"""Quadrature points of a cell of the mesh, at each of which a stress is taken."""

OTHER_NS, OTHER_POINTS = 75.0, 9
"""The same for an element from outside."""

ROW_S = 5e-5
"""Time that a row of the history costs [s], whatever the mesh."""


def loop_seconds(scene: Scene, element: str, counts: tuple[int, int], steps: float, rows: int = 0) -> float:
    """Expected time of a loop over so many elements along and across, and of its history's rows [s]."""
    stress = MATERIALS[scene.material.law].nanoseconds if scene.material else 0.0
    cell = NANOSECONDS.get(element, OTHER_NS) + POINTS.get(element, OTHER_POINTS) * stress
    return 1e-9 * steps * math.prod(counts) * cell + rows * ROW_S


def costly_key(scene: Scene, duration: float) -> tuple[str, object]:
    """The key that makes a run long, and its value: what is farthest from usual."""
    plate = scene.needed_plate
    if scene.time.safety_factor < 0.1:
        return "time.safety_factor", scene.time.safety_factor
    if duration > 60.0:
        start = scene.start
        if start and start.omega is not None:
            return "start.omega", start.omega
        assert scene.impact is not None
        return "impact.speed", scene.impact.speed
    if plate.elements and math.prod(plate.elements) > 10_000:
        return "plate.elements", Verbatim(list(plate.elements))
    key = "youngs_modulus" if plate.first_frequency is None else "first_frequency"
    return f"plate.{key}", getattr(plate, key)
