"""Plates of speed.py and peers.py for this program and others."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import meshio
    import numpy as np
    from other_codes.plate import Plate

    from fem.model.plate_model import PlateModel

LENGTH, WIDTH = 10.0, 2.438
DISTORTION = 0.2
"""Largest displacement of an inner node of a distorted mesh over the element's size."""
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")}


def interpreter_path(name: str | None) -> str | None:
    """Return an interpreter as an absolute path, links included.

    One of a virtual environment is a link.
    """
    if name is None:
        return None
    if (path := shutil.which(name)) is None:
        print(f"--others: given {name}, allowed an interpreter of Python", file=sys.stderr)
        sys.exit(2)
    return str(Path(path).absolute())


def on_one_thread() -> None:
    """Start this process again with one thread for each library."""
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | ONE_THREAD)


def make_mesh(elements: tuple[int, int], distortion: float) -> meshio.Mesh:
    """Return the mesh of the plate."""
    from meshes import distorted, plate_mesh

    mesh = plate_mesh(LENGTH, WIDTH, elements)
    return distorted(mesh, distortion, elements) if distortion else mesh


def make_model(elements: tuple[int, int], distortion: float = 0.0, bare: bool = False) -> PlateModel:
    """Return the plate with friction and exact inertia.

    bare: as in the other codes, exact corner, no friction, row sums.
    """
    from fem.laws.friction import Drag
    from fem.model.plate_model import build_model
    from fem.plate.properties import CornerProperties, PlateProperties, StepProperties

    plate = PlateProperties(0.053, 7800.0, 200e9, 0.3, lumping="row-sum" if bare else "exact")
    corner = CornerProperties(constraint="exact") if bare else CornerProperties(Drag(0.47))
    return build_model(make_mesh(elements, distortion), plate, corner, StepProperties())


def same_plate(
    elements: tuple[int, int], distortion: float, time_step: float, folder: Path, angle: float = 0.0
) -> Plate:
    """Return the plate for the other codes.

    Nodes of a distorted mesh go into a file.
    """
    import numpy as np
    from other_codes.plate import Plate

    if not distortion:
        return Plate(elements, time_step, angle)
    file = folder / f"{elements[0]}x{elements[1]}.npy"
    if not file.exists():
        np.save(file, row_by_row(elements, distortion))
    return Plate(elements, time_step, angle, str(file))


def row_by_row(elements: tuple[int, int], distortion: float) -> np.ndarray:
    """Return the nodes [m] as other codes order them, shape (nodes, 2)."""
    import numpy as np

    even, moved = (make_mesh(elements, share).points[:, :2] for share in (0.0, distortion))
    columns, rows = np.rint(even / (LENGTH / elements[0], WIDTH / elements[1])).astype(int).T
    return np.asarray(moved[np.lexsort((columns, rows))])
