"""The rigid wall, seen from above."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshes.rectangle import rectangle_mesh

if TYPE_CHECKING:
    import meshio


def wall_mesh(start: float, length: float, depth: float, elements: tuple[int, int]) -> meshio.Mesh:
    """Mesh the wall [m] from X = start over `length`, from Y = -depth to its face Y = 0.

    Groups: surface `wall`, lines `wall_face`, `wall_end`, `wall_back`, `wall_start`.
    """
    return rectangle_mesh(
        "wall",
        origin=(start, -depth),
        size=(length, depth),
        elements=elements,
        corners=("", "", "", ""),
        sides=("wall_back", "wall_end", "wall_face", "wall_start"),
    )
