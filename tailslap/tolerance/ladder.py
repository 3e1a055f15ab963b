"""The settings among which `--tolerance` picks: meshes from the coarsest upwards, of two elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tailslap.scene.schema import MOST_ELEMENTS, Scene

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
        return (
            f"plate.element={self.element}",
            f"plate.elements=[{along}, {across}]",
            f"corner.constraint={self.constraint}",
        )

    @property
    def fineness(self) -> tuple[int, int]:
        """Sorts rungs by their nodes, the most last."""
        along, across = self.elements
        order = 2 if self.element == "quad9" else 1
        return order * along * order * across, order

    def scaled(self, factor: float) -> Rung | None:
        """The same with so many times the elements each way, or None where that is no mesh."""
        along, across = (int(factor * count) for count in self.elements)
        return Rung(self.element, (along, across), self.constraint) if min(along, across) >= 2 else None


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
