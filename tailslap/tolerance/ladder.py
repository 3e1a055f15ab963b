"""The settings among which `--tolerance` picks: meshes from the coarsest upwards, of two elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tailslap.scene import MOST_ELEMENTS, Scene

ACROSS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
"""Elements across the width; along the length as many as make them about square."""

STRETCH = 1.2
"""Length over height of an element."""

NANOSECONDS = {"quad4": 12.0, "quad9": 75.0}
"""Time per element update on one core of the machines that this was measured on; only their ratio matters."""

ROW_SECONDS = 5e-5
"""Time that a row of the history costs, whatever the mesh."""


@dataclass(frozen=True)
class Rung:
    """A setting: the element, how many along and across, and how the corner is held."""

    element: str
    elements: tuple[int, int]
    constraint: str

    @property
    def changes(self) -> tuple[str, ...]:
        """The same as --set would give it."""
        along, across = self.elements
        held = (f"corner.constraint={self.constraint}",) if self.constraint == "exact" else ()
        return (f"plate.element={self.element}", f"plate.elements=[{along}, {across}]", *held)

    def halved(self) -> Rung | None:
        """The same with half the elements each way, or None where that is no mesh."""
        along, across = self.elements
        if min(along, across) < 4:
            return None
        return Rung(self.element, (along // 2, across // 2), self.constraint)


def ladder(scene: Scene, constraint: str) -> Iterator[Rung]:
    """Every rung for this vehicle, coarse ones first."""
    ratio = scene.vehicle.length / (scene.vehicle.width * STRETCH)
    for across in ACROSS:
        along = max(2, round(across * ratio))
        if along * across > MOST_ELEMENTS // 64:
            return
        for element in NANOSECONDS:
            yield Rung(element, (along, across), constraint)


def seconds(rung: Rung, steps: int, rows: int) -> float:
    """Expected time of the loop."""
    along, across = rung.elements
    return steps * along * across * NANOSECONDS[rung.element] * 1e-9 + rows * ROW_SECONDS
