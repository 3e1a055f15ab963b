"""The plate PEHK in its body frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshes.rectangle import rectangle_mesh

if TYPE_CHECKING:
    import meshio


def plate_mesh(length: float, width: float, elements: tuple[int, int], cells: str = "quad") -> meshio.Mesh:
    """Mesh the plate with quadrilaterals, or triangles, in rows along its length.

    Parameters
    ----------
    length, width : float
        Of the plate [m]. Corner P, the one on the wall, is the origin; E lies at (-length, 0), H at
        (-length, width), K at (0, width).
    elements : tuple of int
        Quadrilaterals along the length and across the width.
    cells : {"quad", "triangle"}
        With "triangle" each quadrilateral is cut in two.

    Returns
    -------
    meshio.Mesh
        Points [m], shape (nodes, 3). Groups: surface `plate`, lines `side_pe`, `side_kp`, `side_hk`, `side_eh`,
        vertices `corner_p`, `corner_e`, `corner_h`, `corner_k`.
    """
    return rectangle_mesh(
        "plate",
        origin=(-length, 0.0),
        size=(length, width),
        elements=elements,
        corners=("corner_e", "corner_p", "corner_k", "corner_h"),
        sides=("side_pe", "side_kp", "side_hk", "side_eh"),
        cells=cells,
    )
