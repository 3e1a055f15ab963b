"""The plate PEHK in its body frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshes.rectangle import rectangle_mesh

if TYPE_CHECKING:
    import meshio


def plate_mesh(length: float, width: float, elements: tuple[int, int], cells: str = "quad") -> meshio.Mesh:
    """Mesh the plate [m] with `elements` quadrilaterals along its length and across its width.

    With cells = "triangle" each is cut in two.

    Corner P, the one on the wall, is the origin; E lies at (-length, 0), H at (-length, width), K at (0, width).
    Groups: surface `plate`, lines `side_pe`, `side_kp`, `side_hk`, `side_eh`, vertices `corner_p` and so on.
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
