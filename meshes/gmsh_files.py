"""gmsh sessions that print nothing, work in any thread and are always closed; files of meshes for other programs."""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import meshio


# gmsh keeps one global state a process, so two threads must not be in it at once.
_LOCK = threading.Lock()


def _restore_handlers() -> None:
    """Set Python's signal handlers again: libraries within gmsh leave the default ones behind."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        handler = signal.getsignal(number)
        if (
            handler == signal.SIG_IGN
        ):  # in any thread; a write to what has been closed is to raise, not to kill
            ctypes.CDLL(None).signal(int(number), ctypes.c_void_p(1))
        elif callable(handler) and threading.current_thread() is threading.main_thread():
            signal.signal(number, handler)


@contextmanager
def gmsh_model(name: str) -> Iterator[Any]:
    """Yield the gmsh module with an empty model of this name, and close what was opened, also after an error.

    A session that the calling program has open already is used and left open; only our model is removed.
    """
    import gmsh

    with _LOCK:
        ours = not gmsh.isInitialized()
        if ours:
            gmsh.initialize(readConfigFiles=False, interruptible=False)
            _restore_handlers()
        terminal = gmsh.option.getNumber("General.Terminal")
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        try:
            yield gmsh
        finally:
            if ours:
                gmsh.finalize()
                _restore_handlers()
            else:
                gmsh.model.remove()
                gmsh.option.setNumber("General.Terminal", terminal)


FORMATS = {".msh": "gmsh", ".vtu": "vtu"}
"""File endings that can be written, with the name meshio gives the format."""


def write_mesh(mesh: meshio.Mesh, path: Path) -> None:
    """Write a mesh with its groups: as physical tags with names (.msh), or as the integer cell array `group` (.vtu).

    Parameters
    ----------
    mesh : meshio.Mesh
        Of `plate_mesh` or `wall_mesh`.
    path : Path
        Ending in .msh (Gmsh 4.1) or .vtu.

    Raises
    ------
    ValueError
        For another ending.
    """
    import meshio

    if path.suffix not in FORMATS:
        raise ValueError(f"{path.name}: a mesh is written as {' or '.join(FORMATS)}")
    tags = [np.full(len(block.data), number) for number, block in enumerate(mesh.cells, start=1)]
    if path.suffix == ".vtu":
        tagged = meshio.Mesh(mesh.points, mesh.cells, cell_data={"group": tags})
    else:
        tagged = meshio.Mesh(
            mesh.points,
            mesh.cells,
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={
                name: np.array([number, mesh.cells[number - 1].dim])
                for number, name in enumerate(mesh.cell_sets, start=1)
            },
            point_data={"gmsh:dim_tags": _dimension_and_tag(mesh)},
        )
    tagged.write(path, file_format=FORMATS[path.suffix])


def _dimension_and_tag(mesh: meshio.Mesh) -> np.ndarray:
    """Entity that owns each node, the one of lowest dimension, as Gmsh 4.1 wants it; shape (nodes, 2)."""
    owner = np.zeros((len(mesh.points), 2), dtype=np.int64)
    for number, block in sorted(enumerate(mesh.cells, start=1), key=lambda item: -item[1].dim):
        owner[np.unique(block.data)] = block.dim, number
    return owner
