"""The rigid wall, seen from above."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshes.rectangle import rectangle_mesh

if TYPE_CHECKING:
    import meshio


def wall_mesh(start: float, length: float, depth: float, elements: tuple[int, int]) -> meshio.Mesh:
    """Mesh the wall with quadrilaterals; its face is Y = 0.

    Parameters
    ----------
    start : float
        X of its near end [m].
    length, depth : float
        Along X and, behind the face, along Y [m].
    elements : tuple of int
        Along the length and across the depth.

    Returns
    -------
    meshio.Mesh
        Points [m], shape (nodes, 3). Groups: surface `wall`, lines `wall_face`, `wall_end`, `wall_back`,
        `wall_start`.
    """
    return rectangle_mesh(
        "wall",
        origin=(start, -depth),
        size=(length, depth),
        elements=elements,
        corners=("", "", "", ""),
        sides=("wall_back", "wall_end", "wall_face", "wall_start"),
    )
