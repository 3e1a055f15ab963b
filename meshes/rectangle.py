"""Rectangles of transfinite quadrilaterals with named groups.

The plate PEHK in its body frame, and the rigid wall. Sessions of gmsh print nothing, work in any thread and are
always closed.
"""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import meshio


Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Pair = tuple[float, float]

# gmsh has one global state per process, so that one thread at a time may use it.
_LOCK = threading.Lock()

CELL_TYPES = {1: "line", 2: "triangle", 3: "quad", 15: "vertex"}
"""Element types of gmsh in a transfinite rectangle, with meshio's names."""

SEED = 7
"""Seed of random displacements."""


def _restore_handlers() -> None:
    """Restore Python's signal handlers.

    Libraries within gmsh replace them by the default ones.
    """
    for number in signal.valid_signals():
        handler = signal.getsignal(number)
        if handler == signal.SIG_IGN:  # in any thread: writes to closed files must raise
            ctypes.CDLL(None).signal(int(number), ctypes.c_void_p(1))
        elif callable(handler) and threading.current_thread() is threading.main_thread():
            signal.signal(number, handler)


@contextmanager
def gmsh_model(name: str) -> Iterator[ModuleType]:
    """Yield gmsh with an empty model of this name.

    A session that this function opened is closed, also after an error. A session of the calling program is used and
    remains open; only the new model is removed.
    """
    try:
        import gmsh
    except OSError as error:  # of ctypes
        raise ImportError(f"gmsh cannot be loaded: {error}") from None

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


def rectangle_mesh(
    name: str,
    origin: Pair,
    size: Pair,
    elements: tuple[int, int],
    corners: tuple[str, str, str, str],
    sides: tuple[str, str, str, str],
    cells: str = "quad",
    columns: Floats | None = None,
) -> meshio.Mesh:
    """Mesh a rectangle by quadrilaterals or triangles.

    origin, size [m]; elements: quadrilaterals along X and Y; cells: "quad" or "triangle", which are twice as many;
    columns: X of the columns of nodes from the origin [m], by default evenly spaced. `corners` and `sides` name the
    physical groups counter-clockwise, from the lower left corner and the lower side; `name` is the surface's. Groups
    without a name are omitted.
    """
    with gmsh_model(name) as gmsh:
        points, curves, surface = _geometry(gmsh, origin, size, elements)
        if cells == "quad":
            gmsh.model.geo.mesh.setRecombine(2, surface)
        gmsh.model.geo.synchronize()
        _groups(gmsh, 0, points, corners)
        _groups(gmsh, 1, curves, sides)
        _groups(gmsh, 2, [surface], [name])
        gmsh.model.mesh.generate(2)
        mesh = _to_meshio(gmsh)
    mesh.points[:, :2] = _on_lattice(mesh.points[:, :2], origin, size, elements, columns)
    return _row_by_row(mesh)


def _row_by_row(mesh: meshio.Mesh) -> meshio.Mesh:
    """Return the mesh numbered along X and then along Y.

    Cells are in the order of their nodes.
    """
    import meshio

    order = np.lexsort((mesh.points[:, 0], mesh.points[:, 1]))
    number = np.argsort(order)
    cells = [(block.type, number[block.data]) for block in mesh.cells]
    cells = [(kind, nodes[np.lexsort(nodes.T[::-1])]) for kind, nodes in cells]
    return meshio.Mesh(mesh.points[order], cells, cell_sets=mesh.cell_sets)


def _on_lattice(
    points: Floats, origin: Pair, size: Pair, elements: tuple[int, int], columns: Floats | None
) -> Floats:
    """Return the lattice point of each node.

    Transfinite nodes of gmsh deviate by 1e-11 of the size.
    """
    spacing = np.divide(size, elements)
    numbers = np.rint((points - origin) / spacing)
    places = origin + numbers * spacing
    if columns is not None:
        places[:, 0] = origin[0] + columns[numbers[:, 0].astype(int)]
    return places


def columns_through(length: float, count: int, places: Sequence[float]) -> Floats:
    """Return columns of nodes, each place on the nearest one.

    Columns [m] from 0 to the length, shape (count + 1,), evenly spaced between places. A place where elements would
    be less than half as long as the mean remains between columns.
    """
    fixed, spacing = [(0, 0.0)], length / count
    for place in sorted(places):
        number, (before, start) = round(place / spacing), fixed[-1]
        if before < number < count and place - start >= 0.5 * spacing * (number - before):
            fixed.append((number, place))
    numbers, stations = zip(*fixed, (count, length), strict=True)
    return np.interp(np.arange(count + 1), numbers, stations)


def _geometry(
    gmsh: ModuleType, origin: Pair, size: Pair, elements: tuple[int, int]
) -> tuple[list[int], list[int], int]:
    geo, (x, y), (width, height) = gmsh.model.geo, origin, size
    places = (x, y), (x + width, y), (x + width, y + height), (x, y + height)
    points = [geo.addPoint(*place, 0.0) for place in places]
    curves = [geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])
    for curve, count in zip(curves, (*elements, *elements), strict=True):
        geo.mesh.setTransfiniteCurve(curve, count + 1)
    geo.mesh.setTransfiniteSurface(surface, cornerTags=points)
    return points, curves, surface


def _groups(gmsh: ModuleType, dimension: int, tags: list[int], names: Sequence[str]) -> None:
    for tag, name in zip(tags, names, strict=True):
        if name:
            gmsh.model.addPhysicalGroup(dimension, [tag], name=name)


def _to_meshio(gmsh: ModuleType) -> meshio.Mesh:
    """Return nodes, cells and physical groups of the current gmsh model."""
    import meshio

    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    row[tags] = np.arange(tags.size)
    names, cells = [], []
    for dimension, group in gmsh.model.getPhysicalGroups():
        (entity,) = gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
        (kind,), _, (nodes,) = gmsh.model.mesh.getElements(dimension, entity)
        _, _, _, nodes_per_cell, *_ = gmsh.model.mesh.getElementProperties(kind)
        names.append(gmsh.model.getPhysicalName(dimension, group))
        cells.append((CELL_TYPES[kind], row[nodes].reshape(-1, nodes_per_cell)))
    return meshio.Mesh(coordinates.reshape(-1, 3), cells, cell_sets=_cell_sets(names, cells))


def _cell_sets(names: list[str], cells: list[tuple[str, Indices]]) -> dict[str, list[Indices]]:
    """Return each group as one block of cells.

    A group contains all cells of its block, and none of the others.
    """
    none = np.empty(0, dtype=np.int64)
    blocks = [np.arange(len(block)) for _, block in cells]
    return {name: [b if i == j else none for j, b in enumerate(blocks)] for i, name in enumerate(names)}


def plate_mesh(
    length: float, width: float, elements: tuple[int, int], cells: str = "quad", hinges: Sequence[float] = ()
) -> meshio.Mesh:
    """Mesh the plate in rows along its length.

    Parameters
    ----------
    length, width : float
        Length and width of the plate [m]. Corner P, the one on the wall, is the origin; E lies at (-length, 0), H at
        (-length, width), K at (0, width).
    elements : tuple of int
        Quadrilaterals along the length and across the width.
    cells : {"quad", "triangle"}
        With "triangle" each quadrilateral is cut in two.
    hinges : sequence of float
        Distances behind the front of the nearest columns of nodes [m].

    Returns
    -------
    meshio.Mesh
        Points [m], shape (nodes, 3). Groups: surface `plate`, lines `side_pe`, `side_kp`, `side_hk`, `side_eh`,
        vertices `corner_p`, `corner_e`, `corner_h`, `corner_k`.
    """
    columns = columns_through(length, elements[0], [length - place for place in hinges]) if hinges else None
    return rectangle_mesh(
        "plate",
        origin=(-length, 0.0),
        size=(length, width),
        elements=elements,
        corners=("corner_e", "corner_p", "corner_k", "corner_h"),
        sides=("side_pe", "side_kp", "side_hk", "side_eh"),
        cells=cells,
        columns=columns,
    )


def wall_mesh(start: float, length: float, depth: float, elements: tuple[int, int]) -> meshio.Mesh:
    """Mesh the wall with quadrilaterals.

    Its face is Y = 0.

    Parameters
    ----------
    start : float
        Place X of its near end [m].
    length, depth : float
        Length along X, and depth behind the face along Y [m].
    elements : tuple of int
        Numbers of elements along the length and across the depth.

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


def distorted(
    mesh: meshio.Mesh, fraction: float, elements: tuple[int, int], hinged: bool = False
) -> meshio.Mesh:
    """Return a copy with random displacements of inner nodes.

    They are the same in every call.

    Parameters
    ----------
    mesh : meshio.Mesh
        Mesh of `plate_mesh`.
    fraction : float
        Largest displacement of a node, as a fraction of an element's length and width [-].
    elements : tuple of int
        Numbers of elements along and across the mesh.
    hinged : bool
        True if the nodes nearest to the middle line are not displaced.

    Returns
    -------
    meshio.Mesh
        Mesh with the same cells and groups.
    """
    import meshio

    points = mesh.points.copy()
    inner = np.ones(len(points), dtype=bool)
    inner[np.unique(mesh.cells_dict["line"])] = False
    size = np.ptp(points[:, :2], axis=0) / elements
    if hinged:
        inner &= np.abs(points[:, 1] - points[:, 1].mean()) > 0.6 * size[1]
    points[inner, :2] += np.random.default_rng(SEED).uniform(-fraction, fraction, (inner.sum(), 2)) * size
    return meshio.Mesh(points, mesh.cells, cell_sets=mesh.cell_sets)
