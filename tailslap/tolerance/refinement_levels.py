"""The settings among which `--tolerance` picks: meshes from the coarsest upwards, of two elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tailslap.scene.schema import MAX_ELEMENTS, Scene

ACROSS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
"""Elements across the width; along the length as many as make them about square."""

STRETCH = 1.2
"""Length over height of an element."""

ELEMENTS = ("quad4", "quad9")


@dataclass(frozen=True)
class RefinementLevel:
    """A setting: the element, how many along and across, and how the corner is held."""

    element: str
    elements: tuple[int, int]
    constraint: str

    @property
    def changes(self) -> dict[str, Any]:
        """What it changes in a scene."""
        return {
            "plate.element": self.element,
            "plate.elements": self.elements,
            "corner.constraint": self.constraint,
        }

    @property
    def fineness(self) -> tuple[int, int]:
        """Sorts levels by their nodes, the most last."""
        along, across = self.elements
        order = 2 if self.element == "quad9" else 1
        return order * along * order * across, order

    def scaled(self, factor: float) -> RefinementLevel | None:
        """The same with so many times the elements each way, or None where that is no mesh."""
        along, across = (int(factor * count) for count in self.elements)
        return (
            RefinementLevel(self.element, (along, across), self.constraint)
            if min(along, across) >= 2
            else None
        )


def refinement_levels(scene: Scene, constraint: str) -> Iterator[RefinementLevel]:
    """Every level for this vehicle, coarse ones first."""
    ratio = scene.vehicle.length / (scene.vehicle.width * STRETCH)
    for across in ACROSS:
        along = max(2, round(across * ratio))
        if along * across > MAX_ELEMENTS // 64:
            return
        for element in ELEMENTS:
            yield RefinementLevel(element, (along, across), constraint)
