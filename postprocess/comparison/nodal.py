"""Nodal histories of other programs.

The motion of the centre of mass follows from them.

Files that are read, in SI:

- CalculiX prints with `*NODE PRINT` a block of lines per quantity and instant to its file `.dat`.
- LS-DYNA prints with `*DATABASE_NODOUT` a table per instant to `nodout`: node numbers in 10 columns, values in 12.
- ABAQUS prints a field output report per frame, with U and V of the nodes.
- OpenRadioss: `th_to_csv` makes a CSV file of its time histories, with DX, DY, VX and VY of each node by /TH/NODE and
  /TH/TITLE.

Positions and masses of the nodes are in `nodes.csv` beside it, with the columns node, x, y [m] and mass [kg]; Z is
not considered.
"""

import csv
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

Blocks = dict[float, dict[int, list[float]]]
"""Values by instant and node: displacement and velocity, both along X and Y, or one of the two."""

LARGEST = 1e30
"""Largest number in a file; its square does not overflow."""

ALLOWED = f"allowed are numbers of at most {LARGEST:g}"
NODES, COLUMNS = "nodes.csv", ("DX", "DY", "VX", "VY")
"""File of positions and masses, and columns of a node in files of OpenRadioss."""

MAX_HEAD = 4_000_000
"""Characters searched for the heading of a file; a legend of LS-DYNA lists all nodes."""

INSTANT = re.compile(r"n o d a l   p r i n t   o u t.*\( at time\s+(\S+)\s*\)")
STEP_TIME = re.compile(r"Frame:.*Step Time =\s*(\S+)")
FIELDS = ("U.U1", "U.U2", "V.V1", "V.V2")
NODE_COLUMN = re.compile(r".*?\s{2,}(\d+)\s.*\b(DX|DY|VX|VY)\s*")
"""Title of the group and number of the node, both padded with blanks, and quantity."""

MAX_TITLE = 1000
"""Characters of such a title."""

FORTRAN = re.compile(r"([-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+))(?:[dD]([-+]?[0-9]+)|([-+][0-9]{3}))")
"""Numbers of Fortran like 1.0D+00, and those with three digits in the exponent like 1.0-100."""

HEAD = re.compile(
    r"^[ \t]*(displacements|velocities) \(vx,vy,vz\) for set (\S+) and time\s+(\S+)\s*", re.MULTILINE
)
REPORT = re.compile(r"^[ \t]*Field Output Report, written", re.MULTILINE)


@dataclass(frozen=True)
class NodalHistory:
    """Motion of nodes.

    Attributes
    ----------
    numbers : ndarray, shape (nodes,)
        Their numbers, rising.
    t : ndarray, shape (instants,)
        [s].
    displacements, velocities : ndarray, shape (instants, nodes, 2)
        [m], [m/s].
    """

    numbers: NDArray[np.int64]
    t: Floats
    displacements: Floats
    velocities: Floats


def number(cell: str) -> float:
    """Return the number in a cell, also of Fortran.

    Raises ValueError for words, NaN, and sizes above `LARGEST`.
    """
    if (fortran := FORTRAN.fullmatch(cell)) and (fortran[2] or "." in cell):
        cell = f"{fortran[1]}e{fortran[2] or fortran[3]}"
    try:
        value = float(cell.replace("_", " "))  # Python reads 1_0 as ten
    except ValueError:
        value = math.nan
    if not abs(value) <= LARGEST:
        raise ValueError(f'given "{cell[:40]}"; {ALLOWED}')
    return value


def _numbers(cells: Sequence[str], line: int) -> list[float]:
    """Return the numbers of a line.

    Raises ValueError with the line.
    """
    try:
        return [number(cell) for cell in cells]
    except ValueError as error:
        raise ValueError(f"line {line}: {error}") from None


def read_calculix(path: Path) -> NodalHistory:
    """Read nodal displacements and velocities from a file `.dat` of CalculiX.

    Raises OSError, and ValueError for a truncated file, or one without displacements or velocities.
    """
    blocks: dict[str, Blocks] = {"displacements": {}, "velocities": {}}
    block: dict[int, list[float]] | None = None
    for place, line in _numbered(path):
        if head := HEAD.fullmatch(line):
            (t,) = _numbers([head[3]], place)
            block = blocks[head[1]].setdefault(t, {})
        elif (cells := line.split()) and not cells[0].isdigit():
            block = None
        elif cells and block is not None:
            if len(cells) != 4:
                raise ValueError(f"line {place} is cut short: {line.strip()!r}")
            block[int(cells[0])] = _numbers(cells[1:], place)[:2]
    displacements, velocities = blocks["displacements"], blocks["velocities"]
    if not velocities or not displacements:
        raise ValueError(
            "it has no displacements or no velocities of nodes; allowed are U and V of *NODE PRINT"
        )
    if displacements.keys() != velocities.keys():
        t = max(displacements.keys() ^ velocities.keys())
        raise ValueError(f"it is cut short: displacements or velocities are missing at {t:g} s")
    states = ((t, displacements[t], velocities[t]) for t in velocities)
    return _stacked({t: {n: u.get(n, []) + v.get(n, []) for n in u | v} for t, u, v in states})


def read_nodout(path: Path) -> NodalHistory:
    """Read nodal displacements and velocities from a file `nodout` of LS-DYNA.

    Raises OSError, and ValueError for a truncated file.
    """
    blocks, block, length, inside = Blocks(), dict[int, list[float]](), 0, False
    for place, line in _numbered(path):
        if instant := INSTANT.search(line):
            (t,), inside = _numbers([instant[1]], place), False
            block = blocks.setdefault(t, {})
        elif "nodal point" in line:  # translations; a table of rotations may follow at the same instant
            inside, length = "x-disp" in line, 0
        elif inside and line[:10].strip().isdigit():
            length = length or len(line)
            if len(line) != length:
                raise ValueError(f"line {place} is cut short: {line!r}")
            cells = [line[10 + 12 * k : 22 + 12 * k].strip() for k in (0, 1, 3, 4)]
            block[int(line[:10])] = _numbers(cells, place)
    return _stacked(blocks)


def read_field_report(path: Path) -> NodalHistory:
    """Read nodal displacements and velocities from field reports of ABAQUS.

    Frames follow each other. Raises OSError, and ValueError for a truncated file, one without U and V, or with
    several steps.
    """
    blocks, block, names = Blocks(), dict[int, list[float]](), list[str]()
    for place, line in _numbered(path):
        cells = line.split()
        if frame := STEP_TIME.search(line):
            (t,), names = _numbers([frame[1]], place), []
            if t in blocks:
                raise ValueError(f"line {place}: {t:g} s is there twice; allowed is one step")
            block = blocks[t] = {}
        elif fields := [cell for cell in cells if re.fullmatch(r"[A-Z]+\.\w+", cell)]:
            names = fields
            if missing := ", ".join(name for name in FIELDS if name not in names):
                raise ValueError(f"line {place}: {missing} are missing; the columns are {', '.join(names)}")
        elif names and cells and cells[0].isdigit():
            if len(cells) != len(names) + 1:
                raise ValueError(f"line {place} is cut short: {line.strip()!r}")
            values = dict(zip(names, _numbers(cells[1:], place), strict=True))
            block[int(cells[0])] = [values[name] for name in FIELDS]
    return _stacked(blocks)


def read_radioss(path: Path) -> NodalHistory:
    """Read nodal displacements and velocities from a CSV file of OpenRadioss.

    `th_to_csv` makes it. Raises OSError, and ValueError for a truncated file, or a node without one of the four
    columns.
    """
    with open(path, encoding="utf-8", errors="replace", newline="") as file:
        header, *rows = csv.reader(file)
    columns: dict[int, dict[str, int]] = {}
    for k, name in enumerate(header):
        if match := NODE_COLUMN.fullmatch(name[-MAX_TITLE:]):
            columns.setdefault(int(match[1]), {})[match[2]] = k
    for node, indices in columns.items():
        if missing := ", ".join(name for name in COLUMNS if name not in indices):
            raise ValueError(f"columns of node {node} are missing: {missing}")
    blocks, named = Blocks(), [k for k, name in enumerate(header) if name.strip()]
    for place, row in enumerate(rows, 2):
        if row and len(row) <= named[-1]:
            raise ValueError(f"line {place} is cut short: {len(row)} of {len(header)} entries")
        if any(row[named[-1] + 1 :]):
            raise ValueError(f"line {place} has {len(row)} entries for {named[-1] + 1} names")
        if empty := [" ".join(header[k].split()) for k in named if row and not row[k].strip()]:
            raise ValueError(f"line {place} has no entry under {empty[0]}; its entries may be shifted")
        if row:
            (t,) = _numbers(row[:1], place)
            if t in blocks:
                raise ValueError(f"line {place}: {t:g} s is there twice; allowed is one row an instant")
            cells = {node: [row[indices[name]] for name in COLUMNS] for node, indices in columns.items()}
            blocks[t] = {node: _numbers(texts, place) for node, texts in cells.items()}
    return _stacked(blocks)


def reader_of(path: Path) -> Callable[[Path], NodalHistory] | None:
    """Return the reader of a nodal file by its heading.

    None for other files, and for paths that are no regular files.
    """
    if not path.is_file():
        return None
    with open(path, encoding="ascii", errors="replace") as file:
        first = file.readline(MAX_HEAD)
        names = first.split('"') if '"INTERNAL ENERGY"' in first else []
        head = first + file.read(MAX_HEAD)
    if any(NODE_COLUMN.fullmatch(name[-MAX_TITLE:]) for name in names):
        return read_radioss
    headings = (REPORT, read_field_report), (INSTANT, read_nodout), (HEAD, read_calculix)
    return next((read for heading, read in headings if heading.search(head)), None)


def _numbered(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the numbered lines of a text file.

    Blanks at their ends are removed.
    """
    with open(path, encoding="ascii", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            yield number, line.rstrip()


def _stacked(blocks: Blocks) -> NodalHistory:
    """Return blocks of displacements and velocities as arrays.

    Raises ValueError where nodes are missing at an instant.
    """
    times, numbers = sorted(blocks), sorted(next(iter(blocks.values()), ()))
    if not numbers:
        raise ValueError("it has no displacements and velocities of nodes")
    for t in times:
        if missing := set(numbers) ^ {node for node, row in blocks[t].items() if len(row) == len(COLUMNS)}:
            raise ValueError(f"it is cut short: {len(missing)} nodes are missing at {t:g} s")
    values = np.array([[blocks[t][n] for n in numbers] for t in times])
    moved, speeds = (np.ascontiguousarray(part) for part in np.split(values, 2, axis=-1))
    return NodalHistory(np.array(numbers), np.array(times), moved, speeds)


def read_nodes(path: Path) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Read numbers, positions and masses of the nodes.

    In rising order; positions [m], shape (nodes, 2), masses [kg]. Raises OSError, and ValueError for a file without
    the columns node, x, y and mass.
    """
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    if longer := [k for k, row in enumerate(rows, 2) if any(row.get(None, ()))]:
        raise ValueError(f"{path.name}, line {longer[0]} has more entries than names")
    try:
        numbers = np.array([int(row["node"]) for row in rows])
        lines = [_numbers([row[name] for name in ("x", "y", "mass")], k) for k, row in enumerate(rows, 2)]
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"{path.name} must have the columns node, x, y and mass: {error}") from None
    values = np.array(lines).reshape(-1, 3)
    if wrong := [k for k, mass in enumerate(values[:, 2], 2) if mass <= 0.0]:
        raise ValueError(f"{path.name}, line {wrong[0]}: the mass of a node must be positive")
    if np.unique(numbers).size < numbers.size:
        raise ValueError(f"{path.name} has a node twice")
    order = np.argsort(numbers)
    return numbers[order], values[order, :2], values[order, 2]


def centre_of_mass_history(
    nodes: Floats, masses: Floats, times: Floats, displacements: Floats, velocities: Floats
) -> dict[str, Floats]:
    """Return the planar motion of the centre of mass of nodes.

    Parameters
    ----------
    nodes : ndarray, shape (nodes, 2 or more)
        Initial positions [m].
    masses : ndarray, shape (nodes,)
        [kg].
    times : ndarray, shape (instants,)
        [s].
    displacements, velocities : ndarray, shape (instants, nodes, 2 or more)
        [m], [m/s].

    Returns
    -------
    dict of ndarray, shape (instants,)
        "t" [s]; "x_g", "y_g" [m]; "v_gx", "v_gy" [m/s], momentum over mass; "omega" [rad/s], spin about the centre of
        mass over its moment of inertia; "rotation" [rad], of the rigid motion that fits best by mass, counter-clockwise
        from the initial positions.
    """
    fraction = masses / masses.sum()
    place = nodes[:, :2] + displacements[..., :2]
    centre, mean = fraction @ place, fraction @ velocities[..., :2]
    arm, rate = place - centre[:, None], velocities[..., :2] - mean[:, None]
    start = nodes[:, :2] - fraction @ nodes[:, :2]
    spin = (arm[..., 0] * rate[..., 1] - arm[..., 1] * rate[..., 0]) @ fraction
    turned = (start[:, 0] * arm[..., 1] - start[:, 1] * arm[..., 0]) @ fraction
    aligned = (start[:, 0] * arm[..., 0] + start[:, 1] * arm[..., 1]) @ fraction
    return {
        "t": times,
        "x_g": centre[:, 0],
        "y_g": centre[:, 1],
        "v_gx": mean[:, 0],
        "v_gy": mean[:, 1],
        "omega": spin / ((arm**2).sum(axis=-1) @ fraction),
        "rotation": np.unwrap(np.arctan2(turned, aligned)),
    }


def read_centre_of_mass(path: Path) -> dict[str, Floats]:
    """Read a nodal file as columns of `centre_of_mass_history`.

    It requires `nodes.csv` beside it. Raises OSError, and ValueError for damaged files and for nodes that are missing
    in one of the two.
    """
    if not path.with_name(NODES).is_file():
        raise ValueError(f"positions and masses of its nodes, in {NODES} beside it, are missing")
    numbers, nodes, masses = read_nodes(path.with_name(NODES))
    history = (reader_of(path) or read_calculix)(path)
    if missing := sorted(set(numbers.tolist()) ^ set(history.numbers.tolist())):
        listed = ", ".join(map(str, missing[:5])) + (", ..." if missing[5:] else "")
        raise ValueError(f"nodes that are in one of {path.name} and {NODES} only: {listed}")
    return centre_of_mass_history(nodes, masses, history.t, history.displacements, history.velocities)
