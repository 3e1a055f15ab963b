"""Rectangles of transfinite quadrilaterals with named groups: the plate PEHK in its body frame and the rigid wall.

Sessions of gmsh print nothing, work in any thread and are always closed. Meshes are written for other programs.
"""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator, Sequence
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
        if handler == signal.SIG_IGN:  # in any thread: a write to what is closed is to raise, not to kill
            ctypes.CDLL(None).signal(int(number), ctypes.c_void_p(1))
        elif callable(handler) and threading.current_thread() is threading.main_thread():
            signal.signal(number, handler)


@contextmanager
def gmsh_model(name: str) -> Iterator[Any]:
    """Yield the gmsh module with an empty model of this name, and close what was opened, also after an error.

    A session that the calling program has open already is used and left open; only our model is removed.
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


CELL_TYPES = {1: "line", 2: "triangle", 3: "quad", 15: "vertex"}
"""gmsh element types that a transfinite rectangle has, with meshio's names."""


def rectangle_mesh(
    name: str,
    origin: tuple[float, float],
    size: tuple[float, float],
    elements: tuple[int, int],
    corners: tuple[str, str, str, str],
    sides: tuple[str, str, str, str],
    cells: str = "quad",
    columns: np.ndarray | None = None,
) -> meshio.Mesh:
    """Mesh a rectangle [m] with `elements` quadrilaterals along X and Y, or twice as many triangles.

    cells: "quad" or "triangle". columns: X of the columns of nodes from the origin [m]; evenly spaced if left out.

    `corners` and `sides` name the physical groups counter-clockwise, from the lower left corner and the
    lower side; `name` is the surface's. An empty name leaves that group out.
    """
    with gmsh_model(name) as gmsh:
        points, curves, surface = _geometry(gmsh.model.geo, origin, size, elements)
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
    """The mesh with nodes numbered along X and then along Y, cells in the order of their nodes."""
    import meshio

    order = np.lexsort((mesh.points[:, 0], mesh.points[:, 1]))
    number = np.argsort(order)
    cells = [(block.type, number[block.data]) for block in mesh.cells]
    cells = [(kind, nodes[np.lexsort(nodes.T[::-1])]) for kind, nodes in cells]
    return meshio.Mesh(mesh.points[order], cells, cell_sets=mesh.cell_sets)


def _on_lattice(points: Any, origin: Any, size: Any, elements: Any, columns: Any) -> Any:
    """Move each node to its lattice point: gmsh's transfinite nodes are 1e-11 of the size beside it."""
    spacing = np.divide(size, elements)
    numbers = np.rint((points - origin) / spacing)
    places = origin + numbers * spacing
    if columns is not None:
        places[:, 0] = origin[0] + columns[numbers[:, 0].astype(int)]
    return places


def columns_through(length: float, count: int, places: Sequence[float]) -> np.ndarray:
    """Columns of nodes [m], from 0 to the length, each place [m] on the one nearest to it; shape (count + 1,).

    Between places they are evenly spaced. A place without one, where elements would be less than half as long as the
    mean, stays between columns.
    """
    kept, spacing = [(0, 0.0)], length / count
    for place in sorted(places):
        number, (before, start) = round(place / spacing), kept[-1]
        if before < number < count and place - start >= 0.5 * spacing * (number - before):
            kept.append((number, place))
    numbers, stations = zip(*kept, (count, length), strict=True)
    return np.interp(np.arange(count + 1), numbers, stations)


def _geometry(
    geo: Any, origin: tuple[float, float], size: tuple[float, float], elements: tuple[int, int]
) -> Any:
    (x, y), (width, height) = origin, size
    places = (x, y), (x + width, y), (x + width, y + height), (x, y + height)
    points = [geo.addPoint(*place, 0.0) for place in places]
    curves = [geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])
    for curve, count in zip(curves, (*elements, *elements), strict=True):
        geo.mesh.setTransfiniteCurve(curve, count + 1)
    geo.mesh.setTransfiniteSurface(surface, cornerTags=points)
    return points, curves, surface


def _groups(gmsh: Any, dimension: int, tags: list[int], names: Any) -> None:
    for tag, name in zip(tags, names, strict=True):
        if name:
            gmsh.model.addPhysicalGroup(dimension, [tag], name=name)


def _to_meshio(gmsh: Any) -> meshio.Mesh:
    """Copy nodes, cells and physical groups of the current gmsh model, without a file between."""
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


def _cell_sets(names: list[str], cells: list[tuple[str, Any]]) -> dict[str, list[Any]]:
    """Each named group is one block of cells: all cells of that block, none of the others."""
    none = np.empty(0, dtype=np.int64)
    blocks = [np.arange(len(block)) for _, block in cells]
    return {name: [b if i == j else none for j, b in enumerate(blocks)] for i, name in enumerate(names)}


def plate_mesh(
    length: float,
    width: float,
    elements: tuple[int, int],
    cells: str = "quad",
    hinges: Sequence[float] = (),
) -> meshio.Mesh:
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
    hinges : sequence of float
        Distances behind the front [m] onto which the nearest column of nodes is moved.

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


SEED = 7


def distorted(
    mesh: meshio.Mesh, fraction: float, elements: tuple[int, int], hinged: bool = False
) -> meshio.Mesh:
    """A copy with the nodes inside the plate moved at random, equally every time.

    Parameters
    ----------
    mesh : meshio.Mesh
        Of `plate_mesh`.
    fraction : float
        Largest displacement of a node, as a fraction of an element's length and width [-].
    elements : tuple of int
        Along and across, as the mesh was made with.
    hinged : bool
        Whether nodes on the middle line, or those nearest to it, stay where they are.

    Returns
    -------
    meshio.Mesh
        With the same cells and groups.
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
